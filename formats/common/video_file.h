// Videos: FFmpeg's libav* read them, in a module (core/module.h) that is opened on first use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/image.h"

namespace kinora::formats {

/// A picture of a video: one of the three.
struct VideoPicture {
  ColorImage color;            ///< 3 channels sRGB
  DepthImage16 gray16;         ///< of videos with 16-bit grey pixels, bit by bit
  std::vector<std::byte> jpeg; ///< of Motion JPEG, as it is stored
};

struct VideoStream {
  int number = 0; ///< in the file
  std::string codec;
  std::map<std::string, std::string> tags;
  int width = 0; ///< 1 to 16384, of pictures as they are shown
  int height = 0;
  int quarter_turns = 0; ///< clockwise, 0 to 3, from the stored pixels to what is shown
  bool gray16 = false;
  std::vector<double> times; ///< of all pictures in order, seconds from the start of the file
};

struct VideoDescription {
  std::vector<VideoStream> streams; ///< with pictures, in the order of the file
  std::map<std::string, std::vector<std::byte>> attachments;
  std::map<std::string, std::string> tags;
};

/// One stream of a file, its pictures turned as the file says. Not thread-safe; different ones may be used at the same
/// time.
class VideoReader {
public:
  virtual ~VideoReader() = default;
  /// The picture with this number in `times`. Fast for one after the other; else it decodes from the key picture
  /// before. Throws Error(kCorruptInput), naming the file; another picture may be read then.
  virtual VideoPicture read(std::size_t number) = 0;
};

/// Reads the whole file's structure, and no picture. Nothing is read but this local file, and that as Matroska, MP4,
/// QuickTime or AVI. Throws Error: kCorruptInput, naming the path; kMissingComponent if the module is not installed.
VideoDescription describe_video(const std::filesystem::path& path);
/// `stream` of a description.
std::unique_ptr<VideoReader> open_video(const std::filesystem::path& path, const VideoStream& stream);

/// What the module exports: kinora_functions() returns one.
struct VideoModule {
  VideoDescription (*describe)(const std::filesystem::path& path);
  std::unique_ptr<VideoReader> (*open)(const std::filesystem::path& path, const VideoStream& stream);
};

} // namespace kinora::formats
