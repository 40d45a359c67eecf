// Frames with every kind of picture, and small recordings of them.
#pragma once

#include <filesystem>
#include <vector>

#include "core/random.h"
#include "host/interface_struct.h"
#include "record/recorder.h"

namespace kinora::test {

/// A frame that owns its pictures: noise, which a coder must not change.
struct SampleFrame {
  static constexpr int kWidth = 12, kHeight = 10;

  explicit SampleFrame(int number, bool has_pose = true) {
    Random random(static_cast<std::uint64_t>(number) + 1);
    const auto fill = [&random](auto& values, std::size_t count, std::uint32_t below) {
      values.resize(count);
      for (auto& value : values) value = static_cast<std::remove_reference_t<decltype(value)>>(random.below(below));
    };
    constexpr std::size_t kPixels = kWidth * kHeight;
    fill(color, 3 * kPixels, 256);
    fill(depth, kPixels, 65536);
    fill(infrared, kPixels, 65536);
    fill(confidence, kPixels, 256);
    fill(labels, kPixels, 3);
    frame.index = number;
    frame.time = 100.1 + number / 30.0;
    frame.depth_unit = 0.0002;
    frame.color = view(color.data(), 3, KINORA_PIXEL_U8);
    frame.depth = view(depth.data(), 1, KINORA_PIXEL_U16);
    frame.infrared = view(infrared.data(), 1, KINORA_PIXEL_U16);
    frame.confidence = view(confidence.data(), 1, KINORA_PIXEL_U8);
    frame.labels = view(labels.data(), 1, KINORA_PIXEL_U8);
    frame.has_pose = has_pose ? 1 : 0;
    for (int i = 0; i < 16; ++i) frame.camera_to_world[i] = number + i / 3.0;
  }
  SampleFrame(const SampleFrame&) = delete;
  SampleFrame& operator=(const SampleFrame&) = delete;

  std::vector<std::uint8_t> color, confidence, labels;
  std::vector<std::uint16_t> depth, infrared;
  KinoraFrame frame = host::make_struct<KinoraFrame>();

private:
  static KinoraImage view(const void* data, int channels, KinoraPixelType type) {
    KinoraImage image{};
    image.width = kWidth;
    image.height = kHeight;
    image.channels = channels;
    image.pixel_type = type;
    image.row_bytes = static_cast<std::size_t>(kWidth * channels) * (type == KINORA_PIXEL_U16 ? 2 : 1);
    image.data = data;
    return image;
  }
};

inline recording::Description sample_description() {
  recording::Description description;
  description.start_time = 100.1;
  description.frames_per_second = 29.97;
  description.camera.width = SampleFrame::kWidth;
  description.camera.height = SampleFrame::kHeight;
  description.camera.fx = description.camera.fy = 20.0 / 3;
  description.camera.cx = 5.5;
  description.camera.cy = 4.5;
  description.has_poses = true;
  description.has_masks = true;
  description.labels = {{1, "anna", "deforming"}, {2, "box", "rigid"}};
  description.source_format = "sample";
  return description;
}

inline void write_sample_recording(const std::filesystem::path& path, int frames) {
  const SampleFrame first(0);
  record::Recorder recorder(path, sample_description(), first.frame);
  for (int i = 0; i < frames; ++i) recorder.write(SampleFrame(i).frame);
  recorder.finish();
}

} // namespace kinora::test
