// Small capture folders in a temporary directory, for tests that break them.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "core/sample_images.h"

namespace kinora::test {

namespace fs = std::filesystem;

/// A folder of this program alone, removed at the end.
class TemporaryFolder {
public:
  TemporaryFolder() {
    path_ = fs::temp_directory_path() / ("kinora_" + std::to_string(getpid()) + "_" + std::to_string(count_++));
    fs::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

  void write(const fs::path& name, std::span<const std::byte> bytes) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream file(path_ / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  void write(const fs::path& name, const std::string& text) const { write(name, std::as_bytes(std::span(text))); }
  void remove(const fs::path& name) const { fs::remove_all(path_ / name); }

private:
  static inline int count_ = 0;
  fs::path path_;
};

inline std::string six_digits(int number) {
  const std::string digits = std::to_string(number);
  return std::string(6 - digits.size(), '0') + digits;
}

constexpr int kSampleWidth = 16;
constexpr int kSampleHeight = 12;
constexpr const char* kSampleIntrinsics = R"({"width": 16, "height": 12, "fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5,
 "depth_factor": 1000, "fps": 30})";

inline Bytes color_bytes(int seed) { return encode_png(sample_color(kSampleWidth, kSampleHeight, 3, seed)); }
inline Bytes depth_bytes(int seed) {
  return encode_png16(sample_depth(kSampleWidth, kSampleHeight, static_cast<std::uint16_t>(1000 + 100 * seed)));
}

/// color/NNNNNN.png, depth/NNNNNN.png and intrinsics.json. Depth of frame i starts at 1 + i/10 metres.
inline void write_numbered(const TemporaryFolder& folder, int frames) {
  folder.write("intrinsics.json", kSampleIntrinsics);
  for (int i = 0; i < frames; ++i) {
    folder.write("color/" + six_digits(i) + ".png", color_bytes(i));
    folder.write("depth/" + six_digits(i) + ".png", depth_bytes(i));
  }
}

/// rgb.txt and depth.txt 5 ms apart at 30 frames per second, images and intrinsics.json.
inline void write_tum(const TemporaryFolder& folder, int frames) {
  folder.write("intrinsics.json", kSampleIntrinsics);
  std::string colors = "# time file\n";
  std::string depths = "# time file\n";
  for (int i = 0; i < frames; ++i) {
    const double time = 100 + i / 30.0;
    colors += std::to_string(time) + " rgb/" + std::to_string(time) + ".png\n";
    depths += std::to_string(time + 0.005) + " depth/" + std::to_string(time + 0.005) + ".png\n";
    folder.write("rgb/" + std::to_string(time) + ".png", color_bytes(i));
    folder.write("depth/" + std::to_string(time + 0.005) + ".png", depth_bytes(i));
  }
  folder.write("rgb.txt", colors);
  folder.write("depth.txt", depths);
}

/// frames/frame-NNNNNN.* from number 150 on and camera-intrinsics.txt above; the camera moves 1 cm per frame along x.
inline void write_3dmatch(const TemporaryFolder& folder, int frames) {
  folder.write("camera-intrinsics.txt", " 2.0e+001\t 0\t 7.5\t\n 0\t 20\t 5.5\n 0 0 1\n");
  for (int i = 0; i < frames; ++i) {
    const std::string stem = "frames/frame-" + six_digits(150 + i);
    folder.write(stem + ".color.png", color_bytes(i));
    folder.write(stem + ".depth.png", depth_bytes(i));
    folder.write(stem + ".pose.txt", " 1.0e+000\t 0\t 0\t " + std::to_string(i) +
                                         "e-002\t\r\n 0\t 1\t 0\t 0\t\r\n 0\t 0\t 1\t 0\t\r\n 0\t 0\t 0\t 1\t\r\n");
  }
}

} // namespace kinora::test
