// Frames of a capture as copies, for tests that compare captures.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/frame_reader.h"
#include "host/plugin_table.h"

namespace kinora::test {

struct CopiedFrame {
  std::string problem;
  double time = 0;
  double depth_unit = 0;
  bool has_pose = false;
  std::array<double, 16> pose{};
  std::vector<std::byte> color, depth, infrared, confidence, labels, jpeg;
};

struct CopiedCapture {
  std::string format;
  KinoraCaptureInfo info{}; ///< without its lists
  std::vector<std::string> warnings;
  std::vector<CopiedFrame> frames;
};

inline std::vector<std::byte> pixels_of(const KinoraImage& image) {
  std::vector<std::byte> out;
  const std::size_t row = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels) *
                          (image.pixel_type == KINORA_PIXEL_U16 ? 2 : 1);
  for (int v = 0; image.data != nullptr && v < image.height; ++v) {
    const auto* from = static_cast<const std::byte*>(image.data) + image.row_bytes * static_cast<std::size_t>(v);
    out.insert(out.end(), from, from + row);
  }
  return out;
}

inline CopiedFrame copy_of(const host::ReadFrame& read) {
  CopiedFrame copy;
  copy.problem = read.problem;
  if (!read.problem.empty()) return copy;
  const KinoraFrame& frame = read.frame;
  copy.time = frame.time;
  copy.depth_unit = frame.depth_unit;
  copy.has_pose = frame.has_pose != 0;
  std::copy(std::begin(frame.camera_to_world), std::end(frame.camera_to_world), copy.pose.begin());
  copy.color = pixels_of(frame.color);
  copy.depth = pixels_of(frame.depth);
  copy.infrared = pixels_of(frame.infrared);
  copy.confidence = pixels_of(frame.confidence);
  copy.labels = pixels_of(frame.labels);
  const auto* jpeg = static_cast<const std::byte*>(frame.color_jpeg);
  copy.jpeg.assign(jpeg, jpeg + frame.color_jpeg_bytes);
  return copy;
}

/// Throws what reading throws.
inline CopiedCapture read_capture(const std::filesystem::path& path, const std::string& format = "",
                                  const host::Options& options = {}) {
  static const host::PluginTable plugins = host::PluginTable::builtin();
  const KinoraFormat& chosen = format.empty() ? plugins.recognise(path) : plugins.find(format);
  host::FrameReader reader(chosen, path, options);
  CopiedCapture copy;
  copy.format = chosen.name;
  copy.info = reader.info();
  for (std::size_t i = 0; i < copy.info.warning_count; ++i) copy.warnings.emplace_back(copy.info.warnings[i]);
  copy.info.warnings = nullptr;
  copy.info.labels = nullptr;
  while (const auto read = reader.next()) copy.frames.push_back(copy_of(*read));
  return copy;
}

} // namespace kinora::test
