// The axes and lengths of files whose tools do not agree on them.
#pragma once

#include <array>
#include <map>
#include <string>

#include <Eigen/Core>

#include "kinora/plugin.h"

namespace kinora::formats {

inline constexpr KinoraOption kUpOption = {
    "up", "y|z", "y", "The axis that points up: y with z backward, or z with y forward; x is to the right.", nullptr};
inline constexpr KinoraOption kUnitsOption = {"units", "m|cm|mm", "m", "Lengths in metres, centimetres or millimetres.",
                                              nullptr};

/// From Kinora's axes (x right, y down, z forward; metres) to those of a file.
struct WorldAxes {
  WorldAxes() = default;
  /// As the options above say.
  explicit WorldAxes(const std::map<std::string, std::string>& options) {
    const auto value = [&options](const char* name) {
      const auto found = options.find(name);
      return found == options.end() ? std::string() : found->second;
    };
    z_up = value("up") == "z";
    per_metre = value("units") == "cm" ? 100 : value("units") == "mm" ? 1000 : 1;
  }

  bool z_up = false;
  double per_metre = 1;

  /// Its rows are the file's axes.
  Eigen::Matrix3d rotation() const {
    Eigen::Matrix3d axes = Eigen::Vector3d(1, -1, -1).asDiagonal();
    if (z_up) axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    return axes;
  }
  std::array<float, 3> direction(const float* v) const {
    return z_up ? std::array<float, 3>{v[0], v[2], -v[1]} : std::array<float, 3>{v[0], -v[1], -v[2]};
  }
  std::array<float, 3> position(const float* p) const {
    std::array<float, 3> at = direction(p);
    if (per_metre != 1) {
      for (float& a : at) a = static_cast<float>(a * per_metre);
    }
    return at;
  }
  /// "metres, x right, y up, z backward"
  std::string text() const {
    const char* lengths = per_metre == 1 ? "metres" : per_metre == 100 ? "centimetres" : "millimetres";
    return std::string(lengths) + (z_up ? ", x right, y forward, z up" : ", x right, y up, z backward");
  }
};

} // namespace kinora::formats
