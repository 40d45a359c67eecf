#include "azure_kinect/kinect_calibration.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/error.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;

/// A mode shows a part of the sensor, whose pixels are joined two by two in some.
struct Mode {
  int width, height;               ///< of its pictures
  int sensor_width, sensor_height; ///< in its pixels
  int left, top;                   ///< of the part that is shown
};
constexpr Mode kDepthModes[] = {{640, 576, 1024, 1024, 192, 180},
                                {320, 288, 512, 512, 96, 90},
                                {512, 512, 512, 512, 0, 0},
                                {1024, 1024, 1024, 1024, 0, 0}};
constexpr Mode kColorModes[] = {{1280, 720, 1280, 960, 0, 120},   {1920, 1080, 1920, 1440, 0, 180},
                                {2560, 1440, 2560, 1920, 0, 240}, {2048, 1536, 2048, 1536, 0, 0},
                                {3840, 2160, 3840, 2880, 0, 360}, {4096, 3072, 4096, 3072, 0, 0}};

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
}

const Mode& mode_of(std::span<const Mode> modes, int width, int height, const std::string& source) {
  for (const Mode& mode : modes)
    if (mode.width == width && mode.height == height) return mode;
  fail(source, "pictures of " + std::to_string(width) + "x" + std::to_string(height) + " are of no mode of the camera");
}

const Json& camera_called(const Json& json, const char* location, const std::string& source) {
  for (const Json& camera : json.at("CalibrationInformation").at("Cameras"))
    if (camera.at("Location").get<std::string>() == location) return camera;
  fail(source, std::string("has no camera ") + location);
}

RationalLens lens_of(const Json& camera, const Mode& mode, const std::string& source) {
  constexpr std::size_t kParameters = 14;
  constexpr double kMaxCoefficient = 1e4;
  const Json& intrinsics = camera.at("Intrinsics");
  const auto given = intrinsics.at("ModelParameters").get<std::vector<double>>();
  if (given.size() < kParameters) fail(source, "a camera has too few parameters");
  for (const double value : given)
    if (!(std::abs(value) < kMaxCoefficient)) fail(source, "a camera's parameter is absurd");
  RationalLens lens;
  // Relative to the whole sensor, whose pixels have their centres at (0.5, 0.5) there.
  lens.intrinsics = {mode.width,
                     mode.height,
                     given[2] * mode.sensor_width,
                     given[3] * mode.sensor_height,
                     given[0] * mode.sensor_width - mode.left - 0.5,
                     given[1] * mode.sensor_height - mode.top - 0.5};
  lens.intrinsics.validate(source);
  std::copy_n(given.begin() + 4, 6, lens.k);
  lens.p2 = given[12];
  lens.p1 = given[13];
  lens.max_radius = camera.value("MetricRadius", 0.0);
  lens.half_tangential = intrinsics.value("ModelType", "") == "CALIBRATION_LensDistortionModelRational6KT";
  return lens;
}

/// From the origin that the cameras share to the camera.
SE3 transform_of(const Json& camera, const std::string& source) {
  const auto rotation = camera.at("Rt").at("Rotation").get<std::array<double, 9>>();
  const auto translation = camera.at("Rt").at("Translation").get<std::array<double, 3>>();
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = rotation[static_cast<std::size_t>(i)];
  for (int i = 0; i < 3; ++i) matrix(i, 3) = translation[static_cast<std::size_t>(i)];
  return rigid_from_matrix(matrix, source.c_str());
}

/// The ray's place in the picture as the lens has it; nothing beyond what is calibrated.
std::optional<Eigen::Vector2d> distorted(const RationalLens& lens, double x, double y) {
  const double r2 = x * x + y * y;
  if (lens.max_radius > 0 && r2 > lens.max_radius * lens.max_radius) return std::nullopt;
  const double* k = lens.k;
  const double above = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
  const double below = 1 + r2 * (k[3] + r2 * (k[4] + r2 * k[5]));
  if (!(std::abs(below) > 1e-9)) return std::nullopt;
  const double radial = above / below;
  const double xy = (lens.half_tangential ? 1 : 2) * x * y;
  return Eigen::Vector2d(x * radial + xy * lens.p1 + (r2 + 2 * x * x) * lens.p2,
                         y * radial + xy * lens.p2 + (r2 + 2 * y * y) * lens.p1);
}

} // namespace

KinectCalibration read_kinect_calibration(std::span<const std::byte> bytes, int color_width, int color_height,
                                          int depth_width, int depth_height, const std::string& source) {
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  std::size_t size = bytes.size();
  while (size > 0 && text[size - 1] == '\0') --size; // the recorder adds one
  const Json json = Json::parse(text, text + size, nullptr, false);
  try {
    const Json& color = camera_called(json, "CALIBRATION_CameraLocationPV0", source);
    const Json& depth = camera_called(json, "CALIBRATION_CameraLocationD0", source);
    KinectCalibration calibration;
    calibration.color = lens_of(color, mode_of(kColorModes, color_width, color_height, source), source);
    calibration.depth = lens_of(depth, mode_of(kDepthModes, depth_width, depth_height, source), source);
    calibration.depth_to_color = transform_of(color, source) * transform_of(depth, source).inverse();
    return calibration;
  } catch (const Json::exception& error) {
    fail(source, std::string("is no calibration of such a camera: ") + error.what());
  }
}

LensMap::LensMap(const RationalLens& lens) : width_(lens.intrinsics.width), height_(lens.intrinsics.height) {
  const Intrinsics& k = lens.intrinsics;
  sources_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const auto ray = distorted(lens, (u - k.cx) / k.fx, (v - k.cy) / k.fy);
      const double from_u = ray ? k.fx * ray->x() + k.cx : -1;
      const double from_v = ray ? k.fy * ray->y() + k.cy : -1;
      const bool inside = from_u >= 0 && from_v >= 0 && from_u <= width_ - 1 && from_v <= height_ - 1;
      sources_.push_back(inside ? Source{static_cast<float>(from_u), static_cast<float>(from_v)} : Source{-1, -1});
    }
  }
}

ColorImage LensMap::straighten(const ColorImage& image) const {
  ColorImage out(width_, height_, 3);
  std::uint8_t* to = out.data();
  for (const Source& from : sources_) {
    if (from.u >= 0) {
      const int u = std::min(static_cast<int>(from.u), width_ - 2);
      const int v = std::min(static_cast<int>(from.v), height_ - 2);
      const float a = from.u - static_cast<float>(u);
      const float b = from.v - static_cast<float>(v);
      for (int c = 0; c < 3; ++c) {
        const float above = (1 - a) * image.at(u, v, c) + a * image.at(u + 1, v, c);
        const float below = (1 - a) * image.at(u, v + 1, c) + a * image.at(u + 1, v + 1, c);
        to[c] = static_cast<std::uint8_t>(std::lround((1 - b) * above + b * below));
      }
    }
    to += 3;
  }
  return out;
}

DepthImage16 LensMap::straighten(const DepthImage16& image) const {
  DepthImage16 out(width_, height_);
  for (std::size_t i = 0; i < sources_.size(); ++i)
    if (sources_[i].u >= 0)
      out.data()[i] =
          image.at(static_cast<int>(std::lround(sources_[i].u)), static_cast<int>(std::lround(sources_[i].v)));
  return out;
}

} // namespace kinora::formats
