// Material points in CSV files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinora::cli {

struct NamedPoint {
  std::string id;
  Eigen::Vector3d position; ///< world, metres
};

/// The first line is `id,x,y,z`, every other one a point; ids are unique and hold no quotes. Throws
/// Error(kCorruptInput) naming file and line, and if there is no point.
std::vector<NamedPoint> read_points(const std::filesystem::path& path);

/// `text` is what the file holds. For tests, and for read_points.
std::vector<NamedPoint> parse_points(std::string_view text, const std::string& location);

} // namespace kinora::cli
