// Recordings of the app Record3D (.r3d): an archive of JPEG colour, depth in LZFSE, its confidence, and poses.
// Source: https://github.com/marek-simonik/record3d and https://record3d.app (exported .r3d)
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/capture_info.h"

struct zip;

namespace kinora::formats {

/// What the archive's "metadata" says.
struct Record3dMetadata {
  Intrinsics color; ///< of all frames
  int depth_width = 0;
  int depth_height = 0;
  double frames_per_second = 60;
  std::vector<double> times; ///< of each frame, or empty
  std::vector<SE3> poses;    ///< camera to world, of each frame, or empty
};

/// Throws Error(kCorruptInput), naming `source`.
Record3dMetadata read_record3d_metadata(std::span<const std::byte> json, const std::string& source);

/// Not thread-safe. Images of a frame stay valid until the next call.
class Record3dReader {
public:
  /// Throws Error: kNotRecognised, kCorruptInput.
  explicit Record3dReader(const std::filesystem::path& path);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  struct CloseArchive {
    void operator()(zip* archive) const;
  };

  bool has(const std::string& name) const;
  std::vector<std::byte> read(const std::string& name) const;
  std::vector<std::byte> read_packed(const std::string& name, std::size_t bytes_per_pixel) const;
  void count_frames();
  double time_of(std::size_t frame) const;

  std::string name_;
  std::unique_ptr<zip, CloseArchive> archive_;
  Record3dMetadata metadata_;
  std::size_t frames_ = 0;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  std::size_t next_ = 0;
  std::vector<std::byte> color_bytes_;
  ColorImage color_;
  DepthImage16 depth_;
  Image<std::uint8_t> confidence_;
};

} // namespace kinora::formats
