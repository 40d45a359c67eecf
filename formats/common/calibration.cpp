#include "common/calibration.h"

#include <algorithm>
#include <iterator>
#include <span>

#include <nlohmann/json.hpp>

#include "common/files.h"
#include "core/error.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

double number_of(const nlohmann::json& json, const char* key, const fs::path& path) {
  if (!json.contains(key)) fail(path, std::string("the key \"") + key + "\" is missing; add it");
  if (!json[key].is_number()) fail(path, std::string("\"") + key + "\" must be a number");
  return json[key].get<double>();
}

double positive_of(const nlohmann::json& json, const char* key, const fs::path& path, double limit) {
  const double value = number_of(json, key, path);
  if (!(value > 0 && value <= limit)) fail(path, std::string("\"") + key + "\" is absurd; correct it");
  return value;
}

Distortion distortion_of(const nlohmann::json& json, const fs::path& path) {
  double k[5] = {};
  if (!json.is_array() || json.size() > 5) fail(path, "\"distortion\" must be a list of k1 k2 p1 p2 k3");
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (!json[i].is_number()) fail(path, "\"distortion\" must be a list of numbers");
    k[i] = json[i].get<double>();
    if (!(std::abs(k[i]) < 100)) fail(path, "\"distortion\" is absurd; correct it");
  }
  return {k[0], k[1], k[2], k[3], k[4]};
}

/// Open3D's: nine numbers, column by column.
void take_open3d_matrix(const nlohmann::json& json, const fs::path& path, Intrinsics& intrinsics) {
  if (!json.is_array() || json.size() != 9 ||
      !std::ranges::all_of(json, [](const nlohmann::json& value) { return value.is_number(); }))
    fail(path, "\"intrinsic_matrix\" must be a list of the 9 numbers fx 0 0 0 fy 0 cx cy 1");
  intrinsics.fx = json[0].get<double>();
  intrinsics.fy = json[4].get<double>();
  intrinsics.cx = json[6].get<double>();
  intrinsics.cy = json[7].get<double>();
}

Calibration read_json(const fs::path& path) {
  const nlohmann::json json = nlohmann::json::parse(read_text(path), nullptr, false);
  if (!json.is_object()) fail(path, "not a JSON object; write {\"fx\": …, \"fy\": …, \"cx\": …, \"cy\": …}");
  Calibration calibration;
  Intrinsics& intrinsics = calibration.intrinsics;
  if (json.contains("intrinsic_matrix")) {
    take_open3d_matrix(json["intrinsic_matrix"], path, intrinsics);
  } else {
    intrinsics.fx = number_of(json, "fx", path);
    intrinsics.fy = number_of(json, "fy", path);
    intrinsics.cx = number_of(json, "cx", path);
    intrinsics.cy = number_of(json, "cy", path);
  }
  constexpr double kMaxSide = 16384;
  if (json.contains("width")) intrinsics.width = static_cast<int>(positive_of(json, "width", path, kMaxSide));
  if (json.contains("height")) intrinsics.height = static_cast<int>(positive_of(json, "height", path, kMaxSide));
  if (json.contains("distortion")) calibration.distortion = distortion_of(json["distortion"], path);
  if (json.contains("depth_factor"))
    calibration.depth_unit = 1.0 / positive_of(json, "depth_factor", path, 1e9);
  else if (json.contains("depth_scale")) // Open3D's word for it
    calibration.depth_unit = 1.0 / positive_of(json, "depth_scale", path, 1e9);
  else if (json.contains("depth_scale_m"))
    calibration.depth_unit = positive_of(json, "depth_scale_m", path, 1);
  if (json.contains("fps")) calibration.frames_per_second = positive_of(json, "fps", path, 1e5);
  if (json.value("depth_registered_to_color", nlohmann::json(true)) == false)
    fail(path, "says that depth is not registered to colour; register it first (one depth pixel per colour pixel)");
  return calibration;
}

Calibration read_matrix(const fs::path& path) {
  const std::string text = read_text(path);
  std::vector<double> values;
  for (const std::string_view word : split_words(text)) {
    const std::optional<double> value = parse_number(word);
    if (!value) fail(path, std::string("\"").append(word) + "\" is not a number; write a 3x3 or 4x4 matrix");
    values.push_back(*value);
  }
  if (values.size() != 9 && values.size() != 16) fail(path, "must hold a 3x3 or 4x4 matrix");
  const std::size_t row = values.size() == 9 ? 3 : 4;
  Calibration calibration;
  calibration.intrinsics.fx = values[0];
  calibration.intrinsics.fy = values[row + 1];
  calibration.intrinsics.cx = values[2];
  calibration.intrinsics.cy = values[row + 2];
  if (values[2 * row + 2] != 1 || values[row] != 0) fail(path, "is not a camera matrix [fx s cx; 0 fy cy; 0 0 1]");
  return calibration;
}

} // namespace

Calibration read_calibration(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    for (const char* name : {"intrinsics.json", "intrinsics.txt", "camera-intrinsics.txt", "intrinsic.json",
                             "camera_intrinsic.json", "camera_primesense.json"}) { // the last three are Open3D's
      const fs::path path = folder / name;
      if (!fs::exists(path)) continue;
      Calibration calibration = path.extension() == ".json" ? read_json(path) : read_matrix(path);
      calibration.source = path;
      const Intrinsics& k = calibration.intrinsics;
      if (!std::isfinite(k.fx) || !std::isfinite(k.fy) || !std::isfinite(k.cx) || !std::isfinite(k.cy) || k.fx <= 0 ||
          k.fy <= 0)
        fail(path, "the focal lengths must be positive and all numbers finite; correct them");
      return calibration;
    }
  }
  fail(folders.front(), "has no intrinsics; add intrinsics.json with fx, fy, cx, cy, width, height and depth_factor");
}

bool is_lens_straight(const KinoraCamera& camera) {
  return std::all_of(std::begin(camera.distortion), std::end(camera.distortion), [](double k) { return k == 0; });
}

void write_calibration(const fs::path& folder, const KinoraCamera& camera, double frames_per_second,
                       double depth_unit) {
  nlohmann::ordered_json json = {
      {"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},          {"fy", camera.fy},
      {"cx", camera.cx},       {"cy", camera.cy},         {"fps", frames_per_second}, {"depth_scale_m", depth_unit}};
  if (!is_lens_straight(camera))
    json["distortion"] = std::vector<double>(std::begin(camera.distortion), std::end(camera.distortion));
  const std::string text = json.dump(2) + "\n";
  write_file(folder / "intrinsics.json", std::as_bytes(std::span(text)));
}

} // namespace kinora::formats
