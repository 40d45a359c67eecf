// Frames of a Kinect while it sees them.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "common/live_frames.h"

struct _freenect_context;
struct _freenect_device;

namespace kinora::formats {

/// Colour and depth of 640x480 pixels, depth in millimetres and registered to colour by the camera's own calibration. A
/// thread listens to the camera. The functions may be called from different threads, one at a time.
class FreenectReader {
public:
  /// `address`: "freenect:N", N from 0; without N the first. Throws Error: kUsage, kMissingComponent without a camera.
  FreenectReader(const std::string& address, double seconds, double focal_length);
  ~FreenectReader();
  FreenectReader(const FreenectReader&) = delete;
  FreenectReader& operator=(const FreenectReader&) = delete;

  void fill_info(KinoraCaptureInfo& info) const;
  /// As LiveFrames::next.
  KinoraStatus next(KinoraFrame& frame);

private:
  void open(int number);
  void close();
  void listen();
  double seconds_at(std::uint32_t ticks);
  void take_depth(const void* pixels, std::uint32_t ticks);
  void take_color(const void* pixels, std::uint32_t ticks);

  std::string address_;
  double focal_length_;
  LiveFrames frames_;
  _freenect_context* context_ = nullptr;
  _freenect_device* device_ = nullptr;
  std::optional<std::uint32_t> last_ticks_;
  double clock_ = 0; ///< seconds since the first picture
  std::atomic<bool> stopping_ = false;
  std::thread listener_;
};

} // namespace kinora::formats
