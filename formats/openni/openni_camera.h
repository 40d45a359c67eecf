// Frames of a camera that OpenNI 2 knows, while it sees them.
#pragma once

#include <OpenNI.h>

#include <string>
#include <vector>

#include "common/capture_info.h"
#include "common/live_frames.h"

namespace kinora::formats {

/// Depth is registered to colour by the camera where it can do so; else each has a camera of its own, in one place.
/// The functions may be called from different threads, one at a time.
class OpenNiCamera {
public:
  /// `address`: "openni:N", N from 0, without N the first; or "openni:URI". `focal_length` of colour in pixels; 0: as
  /// the camera says. Throws Error: kUsage, kMissingComponent without a camera.
  OpenNiCamera(const std::string& address, double seconds, double focal_length);
  ~OpenNiCamera();
  OpenNiCamera(const OpenNiCamera&) = delete;
  OpenNiCamera& operator=(const OpenNiCamera&) = delete;

  void fill_info(KinoraCaptureInfo& info) const;
  /// As LiveFrames::next.
  KinoraStatus next(KinoraFrame& frame);

private:
  struct Library { ///< is open; throws Error(kMissingComponent)
    explicit Library(const std::string& address);
    ~Library();
  };

  class Listener final : public openni::VideoStream::NewFrameListener { ///< of one stream
  public:
    explicit Listener(LiveFrames& frames) : frames_(frames) {}
    void onNewFrame(openni::VideoStream& stream) override;

  private:
    LiveFrames& frames_;
  };

  [[noreturn]] void fail(const std::string& why) const;
  std::string uri() const;
  void open();
  void open_stream(openni::VideoStream& stream, openni::SensorType sensor, openni::PixelFormat pixels);
  void start(openni::VideoStream& stream, Listener& listener);

  std::string address_;
  LiveFrames frames_;
  Listener depth_listener_{frames_};
  Listener color_listener_{frames_};
  Library library_;
  openni::Device device_;
  openni::VideoStream depth_;
  openni::VideoStream color_;
  bool registered_ = false;
  Intrinsics color_camera_;
  Intrinsics depth_camera_;
  double frames_per_second_ = 30;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
};

} // namespace kinora::formats
