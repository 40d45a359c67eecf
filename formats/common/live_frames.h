// Frames of a live camera, whose colour and depth pictures come one by one.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "core/image.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// A frame is a colour and a depth picture within 20 ms. Half a second of frames is kept; older ones are lost if nobody
/// asks. Pictures may be added from any thread.
class LiveFrames {
public:
  /// Of the camera `address`, until `seconds` after the first frame. Throws Error(kUsage).
  LiveFrames(std::string address, double seconds);

  /// `time`: seconds on the camera's clock.
  void add(double time, ColorImage color);
  void add(double time, DepthImage16 depth);

  /// How many frames there will be, if the camera gives so many per second.
  void fill_info(KinoraCaptureInfo& info, double frames_per_second) const;
  /// Waits for the next frame; the first has the time 0. KINORA_OK, or KINORA_END when the time is over. Throws
  /// Error(kFailure) if the camera gives none for two seconds. Images stay valid until the next call.
  KinoraStatus next(KinoraFrame& frame);

private:
  struct Pair {
    double time = 0;
    ColorImage color;
    DepthImage16 depth;
  };
  template <class Picture> struct Stamped {
    double time;
    Picture picture;
  };

  void pair_up();

  std::string address_;
  double seconds_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::optional<Stamped<ColorImage>> color_; ///< the last one, if it has no partner yet; under mutex_, as what follows
  std::optional<Stamped<DepthImage16>> depth_;
  std::optional<double> first_time_;
  std::deque<Pair> waiting_;
  Pair given_;
  std::int64_t next_ = 0;
};

} // namespace kinora::formats
