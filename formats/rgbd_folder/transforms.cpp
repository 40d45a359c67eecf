// transforms.json with depth: data sets of nerfstudio and instant-ngp, with one file per frame and its pose.
#include <algorithm>
#include <numbers>

#include <nlohmann/json.hpp>

#include "common/files.h"
#include "core/error.h"
#include "rgbd_folder/listing.h"

namespace kinora::formats {
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr double kDefaultFramesPerSecond = 30;
constexpr const char* kDepthKeys[] = {"depth_file_path", "depth_path"}; ///< nerfstudio's, instant-ngp's
constexpr const char* kNumbersOfACamera[] = {"fl_x", "fl_y", "cx", "cy", "w", "h", "k1", "k2", "p1", "p2", "k3"};

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

Json read_json(const fs::path& path) {
  Json json = Json::parse(read_text(path), nullptr, false);
  if (!json.is_object() || !json.contains("frames") || !json["frames"].is_array())
    fail(path, "not a JSON object with a list \"frames\"");
  return json;
}

std::optional<double> number_of(const Json& json, const char* key, const fs::path& path) {
  if (!json.contains(key)) return std::nullopt;
  if (!json[key].is_number() || !std::isfinite(json[key].get<double>()))
    fail(path, std::string("\"") + key + "\" must be a number");
  return json[key].get<double>();
}

std::string text_of(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "";
}

std::string depth_name(const Json& frame) {
  for (const char* key : kDepthKeys)
    if (std::string name = text_of(frame, key); !name.empty()) return name;
  return {};
}

/// From the top level, or from the first frame where each frame has its own.
Calibration calibration_of(const Json& json, const fs::path& path) {
  const Json& first = json["frames"].front();
  const auto number = [&](const char* key) {
    const std::optional<double> value = number_of(json, key, path);
    return value ? value : number_of(first, key, path);
  };
  Calibration calibration;
  calibration.source = path;
  Intrinsics& camera = calibration.intrinsics;
  const double width = number("w").value_or(0);
  const double height = number("h").value_or(0);
  constexpr double kMaxSide = 16384;
  if (width < 0 || width > kMaxSide || height < 0 || height > kMaxSide) fail(path, "\"w\" or \"h\" is absurd");
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  std::optional<double> focal = number("fl_x");
  if (const auto angle = number("camera_angle_x"); !focal && angle && *angle > 0 && *angle < std::numbers::pi)
    focal = 0.5 * width / std::tan(0.5 * *angle);
  if (!focal || *focal <= 0) fail(path, "has no focal length; add \"fl_x\", or \"camera_angle_x\" and \"w\"");
  camera.fx = *focal;
  camera.fy = number("fl_y").value_or(*focal);
  // There, pixel (0,0) has its centre at (0.5, 0.5); here at (0, 0).
  camera.cx = number("cx").value_or(0.5 * width) - 0.5;
  camera.cy = number("cy").value_or(0.5 * height) - 0.5;
  calibration.distortion = {number("k1").value_or(0), number("k2").value_or(0), number("p1").value_or(0),
                            number("p2").value_or(0), number("k3").value_or(0)};
  for (const double k : {calibration.distortion.k1, calibration.distortion.k2, calibration.distortion.p1,
                         calibration.distortion.p2, calibration.distortion.k3})
    if (!(std::abs(k) < 100)) fail(path, "the lens distortion is absurd; correct it");
  const std::optional<double> unit = number("integer_depth_scale");
  calibration.depth_unit = unit ? unit : number("depth_unit_scale_factor");
  if (calibration.depth_unit && !(*calibration.depth_unit > 0 && *calibration.depth_unit <= 1))
    fail(path, "the size of a unit of depth must be more than 0 and at most 1 metre");
  if (!calibration.depth_unit) calibration.depth_unit = 0.001;
  const double rate = number_of(json, "fps", path).value_or(kDefaultFramesPerSecond);
  if (!(rate > 0 && rate < 1e5)) fail(path, "\"fps\" is absurd; correct it");
  calibration.frames_per_second = rate;
  return calibration;
}

/// A reader has one camera: frames of another one cannot be used.
bool has_same_camera(const Json& frame, const Json& first) {
  return std::ranges::all_of(kNumbersOfACamera, [&](const char* key) {
    return frame.contains(key) == first.contains(key) && (!frame.contains(key) || frame[key] == first[key]);
  });
}

SE3 pose_of(const Json& frame, const std::string& where) {
  const Json matrix = frame.value("transform_matrix", Json());
  Eigen::Matrix4d values = Eigen::Matrix4d::Identity();
  bool good = matrix.is_array() && (matrix.size() == 3 || matrix.size() == 4);
  for (std::size_t row = 0; good && row < matrix.size(); ++row) {
    good = matrix[row].is_array() && matrix[row].size() == 4;
    for (std::size_t column = 0; good && column < 4; ++column) {
      good = matrix[row][column].is_number();
      if (good)
        values(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = matrix[row][column].get<double>();
    }
  }
  if (!good) throw Error(ErrorCode::kCorruptInput, where + ": \"transform_matrix\" must be a 4x4 matrix");
  values.col(1) = -values.col(1); // axes there: x right, y up, z back
  values.col(2) = -values.col(2);
  return rigid_from_matrix(values, where.c_str());
}

/// A name without an extension means PNG, as instant-ngp has it.
fs::path file_of(const fs::path& folder, const std::string& name) {
  fs::path file = folder / name;
  if (!is_image_name(file) && !file.has_extension()) file += ".png";
  return file;
}

FrameFiles frame_of(const Json& json, const Json& first, std::size_t number, const fs::path& path) {
  FrameFiles frame;
  const std::string where = path.string() + ", frame " + std::to_string(number);
  try {
    if (!json.is_object()) throw Error(ErrorCode::kCorruptInput, where + ": not an object");
    const std::string color = text_of(json, "file_path");
    const std::string depth = depth_name(json);
    if (color.empty()) throw Error(ErrorCode::kCorruptInput, where + ": has no \"file_path\"");
    if (depth.empty()) throw Error(ErrorCode::kCorruptInput, where + ": has no \"depth_file_path\"");
    if (!has_same_camera(json, first)) throw Error(ErrorCode::kCorruptInput, where + ": has a camera of its own");
    frame.color = file_of(path.parent_path(), color);
    frame.depth = file_of(path.parent_path(), depth);
    if (const std::string labels = text_of(json, "label_file_path"); !labels.empty())
      frame.masks = {file_of(path.parent_path(), labels)};
    frame.camera_to_world = pose_of(json, where);
  } catch (const Error& error) {
    frame.problem = error.what();
  }
  return frame;
}

/// Where not all frames say their time, they follow one another at the nominal rate.
void set_times(Listing& listing, const Json& frames, const fs::path& path) {
  bool timed = true;
  for (std::size_t i = 0; i < frames.size() && timed; ++i) {
    const std::optional<double> time = frames[i].is_object() ? number_of(frames[i], "time", path) : std::nullopt;
    timed = time.has_value();
    if (timed) listing.frames[i].time = *time;
  }
  if (!timed) {
    for (std::size_t i = 0; i < listing.frames.size(); ++i)
      listing.frames[i].time = static_cast<double>(i) / listing.frames_per_second;
    return;
  }
  const auto earlier = [](const FrameFiles& a, const FrameFiles& b) { return a.time < b.time; };
  if (std::ranges::is_sorted(listing.frames, earlier)) return;
  listing.warnings.push_back(path.string() + ": the times are out of order; frames are taken in order of time");
  std::ranges::stable_sort(listing.frames, earlier);
}

} // namespace

void probe_transforms(const char* path, KinoraProbe* answer) {
  const fs::path file = fs::path(path) / "transforms.json";
  if (!fs::is_regular_file(file)) return answer_probe(answer, 0, "no transforms.json");
  Json json;
  try {
    json = read_json(file);
  } catch (const Error& error) { // of this format, but broken
    return answer_probe(answer, 50, error.what());
  }
  const bool has_depth =
      std::ranges::any_of(json["frames"], [](const Json& frame) { return !depth_name(frame).empty(); });
  if (!has_depth) return answer_probe(answer, 20, "transforms.json, but no frame has a \"depth_file_path\"");
  answer_probe(answer, 92, "transforms.json whose frames have depth");
}

Listing list_transforms(const fs::path& folder) {
  const fs::path path = folder / "transforms.json";
  if (!fs::exists(path))
    throw Error(ErrorCode::kNotRecognised, folder.string() + ": not a data set with transforms.json");
  const Json json = read_json(path);
  const Json& frames = json["frames"];
  if (frames.empty()) fail(path, "\"frames\" is empty");
  Listing listing;
  listing.calibration = calibration_of(json, path);
  listing.frames_per_second = *listing.calibration.frames_per_second;
  listing.has_poses = true;
  for (std::size_t i = 0; i < frames.size(); ++i)
    listing.frames.push_back(frame_of(frames[i], frames.front(), i, path));
  set_times(listing, frames, path);
  return listing;
}

} // namespace kinora::formats
