// Material points that a synthetic capture knows the places of, for `eval`; never read when encoding.
#pragma once

#include <filesystem>
#include <map>

#include <Eigen/Core>

namespace kinora::evaluate {

struct TruePosition {
  Eigen::Vector3d point; ///< metres, in the capture camera's frame
  bool visible;          ///< to the capture camera
};

/// By the point's id, then by the capture's frame number.
using GroundTruthTracks = std::map<int, std::map<int, TruePosition>>;

/// Reads gt/tracks.csv.gz of a capture folder: a header, then lines of frame,id,x,y,z,visible. Empty if there is no
/// such file. Throws Error(kCorruptInput), naming the file and the line.
GroundTruthTracks read_ground_truth_tracks(const std::filesystem::path& capture);

} // namespace kinora::evaluate
