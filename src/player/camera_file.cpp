#include "player/camera_file.h"

#include <cmath>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace kinora::player {
namespace {

using Json = nlohmann::json;

/// One frame of the file with the file's top level behind it, and words for errors.
class Entry {
public:
  Entry(const Json& top, const Json& frame, std::string where) : top_(top), frame_(frame), where_(std::move(where)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", where_, what));
  }
  const Json* find(const char* key) const {
    if (const auto per_frame = frame_.find(key); per_frame != frame_.end()) return &*per_frame;
    if (const auto common = top_.find(key); common != top_.end()) return &*common;
    return nullptr;
  }
  double number(const char* key) const {
    const Json* value = find(key);
    if (value == nullptr) fail(fmt::format("\"{}\" is missing; give it per frame or at the top", key));
    if (!value->is_number()) fail(fmt::format("\"{}\" is not a number", key));
    return value->get<double>();
  }
  double number_or(const char* key, double otherwise) const { return find(key) == nullptr ? otherwise : number(key); }
  const Json& frame() const { return frame_; }
  const std::string& where() const { return where_; }

private:
  const Json& top_;
  const Json& frame_;
  std::string where_;
};

Json parse_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw Error(ErrorCode::kUsage, fmt::format("{} cannot be opened; is the name right?", path.string()));
  }
  try {
    return Json::parse(file);
  } catch (const Json::exception& e) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{} is not JSON, which a camera file must be: {}", path.string(), e.what()));
  }
}

int size_of(const Entry& entry, const char* key) {
  const double value = entry.number(key);
  if (!(value >= 1 && value <= 16384)) entry.fail(fmt::format("\"{}\" is {}; it must be 1 to 16384", key, value));
  return static_cast<int>(value);
}

Intrinsics intrinsics_of(const Entry& entry) {
  Intrinsics camera;
  camera.width = size_of(entry, "w");
  camera.height = size_of(entry, "h");
  const bool by_angle = entry.find("fl_x") == nullptr && entry.find("camera_angle_x") != nullptr;
  camera.fx = by_angle ? camera.width / (2 * std::tan(entry.number("camera_angle_x") / 2)) : entry.number("fl_x");
  camera.fy = entry.number_or("fl_y", camera.fx);
  // From pixel centres at half integers to pixel centres at integers.
  camera.cx = entry.number_or("cx", camera.width / 2.0) - 0.5;
  camera.cy = entry.number_or("cy", camera.height / 2.0) - 0.5;
  camera.validate(entry.where());
  return camera;
}

SE3 pose_of(const Entry& entry) {
  const Json* rows = entry.find("transform_matrix");
  Eigen::Matrix4d matrix;
  if (rows == nullptr || !rows->is_array() || rows->size() != 4) entry.fail("\"transform_matrix\" is not 4×4");
  for (int r = 0; r < 4; ++r) {
    const Json& row = (*rows)[static_cast<std::size_t>(r)];
    if (!row.is_array() || row.size() != 4) entry.fail("\"transform_matrix\" is not 4×4");
    for (int c = 0; c < 4; ++c) {
      const Json& value = row[static_cast<std::size_t>(c)];
      if (!value.is_number()) entry.fail("\"transform_matrix\" holds something that is not a number");
      matrix(r, c) = value.get<double>();
    }
  }
  matrix.col(1) *= -1; // y up to y down
  matrix.col(2) *= -1; // z back to z forward
  return rigid_from_matrix(matrix, (entry.where() + ": \"transform_matrix\"").c_str());
}

double frame_of(const Entry& entry, const clip::Clip& clip) {
  const bool by_time = entry.frame().contains("time");
  const double value = by_time ? entry.number("time") : entry.frame().contains("frame") ? entry.number("frame") : 0;
  if (!std::isfinite(value)) entry.fail("its time is not a finite number");
  return by_time ? clip.frame_at(value) : std::clamp(value, 0.0, static_cast<double>(clip.times.size() - 1));
}

std::string name_of(const Entry& entry, std::size_t index) {
  const auto found = entry.frame().find("file_path");
  if (found == entry.frame().end()) return fmt::format("{:06d}", index);
  if (!found->is_string()) entry.fail("\"file_path\" is not a text");
  std::filesystem::path name = std::filesystem::path(found->get<std::string>()).lexically_normal();
  if (name.extension() == ".png") name.replace_extension();
  if (name.empty() || !name.has_filename() || name.filename() == "." || name.is_absolute() || *name.begin() == "..") {
    entry.fail(
        fmt::format("\"file_path\" is \"{}\", which is no name inside the output folder", found->get<std::string>()));
  }
  return name.string();
}

bool has_distortion(const Entry& entry) {
  for (const char* key : {"k1", "k2", "k3", "k4", "p1", "p2"}) {
    if (entry.number_or(key, 0) != 0) return true;
  }
  return false;
}

} // namespace

std::vector<View> read_camera_file(const std::filesystem::path& path, const clip::Clip& clip, Progress& progress) {
  const Json top = parse_file(path);
  const auto frames = top.is_object() ? top.find("frames") : top.end();
  if (!top.is_object() || frames == top.end() || !frames->is_array() || frames->empty()) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{} has no list \"frames\" of cameras, as a transforms.json has", path.string()));
  }
  std::vector<View> views;
  std::set<std::string> names;
  bool warned = false;
  for (std::size_t i = 0; i < frames->size(); ++i) {
    const Json& frame = (*frames)[i];
    const Entry entry(top, frame, fmt::format("{}: frame {}", path.string(), i));
    if (!frame.is_object()) entry.fail("is not an object");
    View view{{intrinsics_of(entry), pose_of(entry)}, frame_of(entry, clip), name_of(entry, i)};
    if (!names.insert(view.name).second) entry.fail(fmt::format("the name \"{}\" occurs twice", view.name));
    if (!warned && has_distortion(entry)) {
      progress.warn(fmt::format("{} asks for lens distortion, which is ignored: pictures are drawn by a pinhole camera",
                                path.string()));
      warned = true;
    }
    views.push_back(std::move(view));
  }
  return views;
}

} // namespace kinora::player
