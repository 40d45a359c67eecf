// Recordings of an Azure Kinect, and of Orbbec's cameras that record as it does: Matroska with colour, depth, infrared.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "azure_kinect/kinect_calibration.h"
#include "common/capture_info.h"
#include "common/frame_pairs.h"
#include "common/video_file.h"

namespace kinora::formats {

/// Not thread-safe. Images of a frame stay valid until the next call.
class KinectReader {
public:
  /// Throws Error: kNotRecognised, kCorruptInput, kMissingComponent.
  explicit KinectReader(const std::filesystem::path& path);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  struct Stream {
    VideoStream description;
    std::unique_ptr<VideoReader> video;
  };
  std::optional<Stream> open_stream(const VideoDescription& file, const char* title) const;
  DepthImage16 read_gray(Stream& stream, std::size_t number) const;
  [[noreturn]] void fail(const std::string& problem) const;

  std::filesystem::path path_;
  std::optional<Stream> color_stream_;
  std::optional<Stream> depth_stream_;
  std::optional<Stream> infrared_stream_;
  KinectCalibration calibration_;
  LensMap color_map_;
  LensMap depth_map_;
  std::vector<FramePair> frames_; ///< of colour and depth
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  std::size_t next_ = 0;
  ColorImage color_;
  DepthImage16 depth_;
  DepthImage16 infrared_;
};

/// Whether a file is one of these, by what its Matroska says: tracks COLOR and DEPTH.
bool is_kinect_recording(const VideoDescription& file);

} // namespace kinora::formats
