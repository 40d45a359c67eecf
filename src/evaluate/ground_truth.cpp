#include "evaluate/ground_truth.h"

#include <charconv>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::evaluate {
namespace fs = std::filesystem;

namespace {

constexpr double kMetresPerUnit = 0.001; ///< of the depth images in novel/

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) fail(path, "the file is missing, empty or cannot be read");
  return std::move(text).str();
}

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// The numbers of a line; stops at the first word that is none.
std::vector<double> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  const char* const end = line.data() + line.size();
  for (const char* at = line.data(); at != end;) {
    if (*at == ' ' || *at == '\t' || *at == '\r') {
      ++at;
      continue;
    }
    double value = 0;
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error != std::errc()) break;
    numbers.push_back(value);
    at = stop;
  }
  return numbers;
}

SE3 pose_of(std::span<const double> row_major, const std::string& what) {
  return rigid_from_matrix(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(row_major.data()),
                           what.c_str());
}

Camera camera_of(const nlohmann::json& json, const std::string& what) {
  Camera camera;
  camera.intrinsics = {json.at("width"), json.at("height"), json.at("fx"), json.at("fy"), json.at("cx"), json.at("cy")};
  camera.intrinsics.validate(what);
  std::vector<double> matrix;
  for (const nlohmann::json& row : json.at("camera_to_world"))
    for (const nlohmann::json& value : row) matrix.push_back(value.get<double>());
  matrix.resize(16);
  camera.camera_to_world = pose_of(matrix, what);
  return camera;
}

std::vector<int> numbers_in(const fs::path& folder) {
  std::vector<int> numbers;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string stem = entry->path().stem().string();
    int number = 0;
    const auto [stop, problem] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (problem == std::errc() && stop == stem.data() + stem.size()) numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

/// folder/NNNNNN.ext with the first extension that exists, or an empty path.
fs::path find_image(const fs::path& folder, int frame) {
  const std::string digits = std::to_string(frame);
  const std::string name = std::string(6 - std::min<std::size_t>(digits.size(), 6), '0') + digits;
  for (const char* extension : {".png", ".jpg", ".jpeg"})
    if (fs::path path = folder / (name + extension); fs::exists(path)) return path;
  return {};
}

} // namespace

std::optional<GroundTruth> GroundTruth::read(const fs::path& capture, const SE3& capture_camera_to_world) {
  GroundTruth truth;
  truth.folder_ = capture;
  const bool cameras = fs::exists(capture / "cameras.json");
  const bool poses = fs::exists(capture / "gt" / "object_pose.txt");
  if (!cameras && !poses) return std::nullopt;
  if (cameras) truth.read_cameras(capture_camera_to_world);
  if (poses) truth.read_object_poses();
  if (fs::exists(capture / "gt" / "object_mesh.obj")) truth.read_object_mesh();
  return truth;
}

void GroundTruth::read_cameras(const SE3& capture_camera_to_world) {
  const fs::path path = folder_ / "cameras.json";
  const std::string text = read_file(path);
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    const nlohmann::json& cameras = json.at("cameras");
    SE3 file_to_clip = SE3::Identity();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const std::string name = cameras.at(i).at("name");
      Camera camera = camera_of(cameras.at(i), path.string() + ", camera " + name);
      if (i == 0) { // the capture camera comes first
        file_to_clip = capture_camera_to_world * camera.camera_to_world.inverse();
        continue;
      }
      camera.camera_to_world = file_to_clip * camera.camera_to_world;
      novel_cameras_.push_back({name, camera, numbers_in(folder_ / "novel" / name / "rgb")});
    }
  } catch (const nlohmann::json::exception& error) {
    fail(path, std::string("not a list of cameras with name, intrinsics and camera_to_world: ") + error.what());
  }
}

void GroundTruth::read_object_poses() {
  const fs::path path = folder_ / "gt" / "object_pose.txt";
  std::istringstream lines(read_file(path));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with('#') || line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string what = path.string() + ", line " + std::to_string(number);
    const std::vector<double> values = numbers_of(line);
    if (values.size() != 18 || !(values[0] >= 0 && values[0] < 1e9))
      throw Error(ErrorCode::kCorruptInput, what + ": must hold frame, time and 16 numbers of a matrix");
    object_to_camera_[static_cast<int>(values[0])] = pose_of(std::span(values).subspan(2), what);
  }
}

void GroundTruth::read_object_mesh() {
  const fs::path path = folder_ / "gt" / "object_mesh.obj";
  std::istringstream lines(read_file(path));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("v ")) continue;
    const std::vector<double> values = numbers_of(std::string_view(line).substr(2));
    if (values.size() < 3) fail(path, "a vertex has no three coordinates");
    sum += Eigen::Vector3d(values[0], values[1], values[2]);
    ++count;
  }
  if (count == 0 || !sum.allFinite()) fail(path, "has no vertices");
  object_centroid_ = sum / static_cast<double>(count);
}

NovelView GroundTruth::novel_view(const NovelCamera& camera, int frame) const {
  const fs::path folder = folder_ / "novel" / camera.name;
  const fs::path color = find_image(folder / "rgb", frame);
  if (color.empty()) fail(folder / "rgb", "has no image of frame " + std::to_string(frame));
  NovelView view;
  view.color = decode_color(bytes_of(read_file(color)), color.string());
  if (const fs::path path = find_image(folder / "depth", frame); !path.empty()) {
    const DepthImage16 units = decode_depth16(bytes_of(read_file(path)), path.string());
    view.depth = DepthImage(units.width(), units.height());
    std::transform(units.values().begin(), units.values().end(), view.depth.data(),
                   [](std::uint16_t unit) { return static_cast<float>(unit * kMetresPerUnit); });
  }
  if (const fs::path path = find_image(folder / "mask", frame); !path.empty())
    view.mask = decode_labels(bytes_of(read_file(path)), path.string());
  const Intrinsics& expected = camera.camera.intrinsics;
  const auto fits = [&expected](const auto& image) {
    return image.empty() || (image.width() == expected.width && image.height() == expected.height);
  };
  if (!fits(view.color) || !fits(view.depth) || !fits(view.mask))
    fail(color, "this image, or its depth or mask, does not have the camera's size");
  return view;
}

} // namespace kinora::evaluate
