// A pose network for tests that finds joints by their colour.
#pragma once

#include <array>
#include <cmath>

#include "ingest/frame/joint_detection.h"
#include "tiny_network.h"

namespace kinora::test::onnx {

/// Seventeen directions, evenly about a sphere (Fibonacci's).
inline Eigen::Vector3d joint_direction(std::size_t joint) {
  const double z = 1 - 2 * (static_cast<double>(joint) + 0.5) / ingest::kDetectedJoints;
  const double turn = 2.399963 * static_cast<double>(joint);
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(turn), radius * std::sin(turn), z};
}

/// What the network knows a joint by; everything else should be grey (128).
inline std::array<std::uint8_t, 3> joint_color(std::size_t joint) {
  const Eigen::Vector3d color = Eigen::Vector3d::Constant(128) + 120 * joint_direction(joint);
  return {static_cast<std::uint8_t>(std::lround(color.x())), static_cast<std::uint8_t>(std::lround(color.y())),
          static_cast<std::uint8_t>(std::lround(color.z()))};
}

/// Heat map i is 0.9 on colour i and less on all others. `joints`: how many maps it gives.
inline std::string joint_detector(std::uint64_t width, std::uint64_t height,
                                  std::size_t joints = ingest::kDetectedJoints) {
  const Eigen::Vector3d mean(0.485, 0.456, 0.406);
  const Eigen::Vector3d deviation(0.229, 0.224, 0.225);
  const Eigen::Vector3d grey = Eigen::Vector3d::Constant(128.0 / 255);
  std::vector<float> weights;
  std::vector<float> biases;
  for (std::size_t i = 0; i < joints; ++i) {
    const Eigen::Vector3d gradient = 0.9 * 255 / 120 * joint_direction(i);
    for (int c = 0; c < 3; ++c) weights.push_back(static_cast<float>(gradient[c] * deviation[c]));
    biases.push_back(static_cast<float>(gradient.dot(mean - grey)));
  }
  return convolution(joints, weights, biases, width, height);
}

} // namespace kinora::test::onnx
