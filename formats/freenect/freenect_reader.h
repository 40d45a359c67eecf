// Frames of a Kinect while it sees them.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/capture_info.h"
#include "core/image.h"

struct _freenect_context;
struct _freenect_device;

namespace kinora::formats {

/// Colour and depth of 640x480 pixels, depth in millimetres and registered to colour by the camera's own calibration. A
/// thread listens to the camera and keeps half a second of frames; older ones are lost if nobody asks. Its callbacks,
/// and everything else, may come from different threads, one at a time.
class FreenectReader {
public:
  /// `address`: "freenect:N", N from 0; without N the first. Throws Error: kUsage, kMissingComponent without a camera.
  FreenectReader(const std::string& address, double seconds, double focal_length);
  ~FreenectReader();
  FreenectReader(const FreenectReader&) = delete;
  FreenectReader& operator=(const FreenectReader&) = delete;

  void fill_info(KinoraCaptureInfo& info) const;
  /// Waits for the next frame. KINORA_OK, or KINORA_END when the time is over. Throws Error(kFailure) if the camera
  /// gives none for two seconds.
  KinoraStatus next(KinoraFrame& frame);

private:
  struct Pair {
    double time = 0;
    ColorImage color;
    DepthImage16 depth;
  };
  template <class Pixels> struct Stamped {
    std::uint32_t ticks;
    Pixels pixels;
  };

  void open(int number);
  void close();
  void listen();
  void take_depth(const void* pixels, std::uint32_t ticks);
  void take_color(const void* pixels, std::uint32_t ticks);
  void pair_up();

  std::string address_;
  double seconds_;
  double focal_length_;
  _freenect_context* context_ = nullptr;
  _freenect_device* device_ = nullptr;
  std::optional<Stamped<ColorImage>> color_; ///< the last one, if it has no partner yet
  std::optional<Stamped<DepthImage16>> depth_;
  std::optional<std::uint32_t> last_ticks_;
  double clock_ = 0; ///< seconds since the first frame

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Pair> waiting_; ///< under mutex_
  std::atomic<bool> stopping_ = false;
  std::thread listener_;
  Pair given_;
  std::int64_t next_ = 0;
};

} // namespace kinora::formats
