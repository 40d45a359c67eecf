// Frames out of a ROS log: colour and depth images paired by time.
#pragma once

#include <string>
#include <vector>

#include "common/capture_info.h"
#include "common/frame_pairs.h"
#include "ros/camera_topics.h"
#include "ros/messages.h"

namespace kinora::formats {

/// Not thread-safe. Images of a frame stay valid until the next call.
class LogReader {
public:
  /// Throws Error(kCorruptInput) if there is no pair of colour and depth.
  LogReader(MessageReader messages, const std::string& color_topic, const std::string& depth_topic);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  struct Stamped {
    double time; ///< the sender's, or where it gives none when the message was logged
    std::size_t message;
  };
  struct Frame {
    double time;
    std::size_t color; ///< message
    std::size_t depth;
  };

  std::vector<Stamped> stamped_messages(const CameraTopic& topic);
  void pair_messages();
  MessageBytes bytes_of(std::size_t message, std::vector<std::byte>& bytes);
  void read_color(std::size_t message, KinoraFrame& frame);

  MessageReader messages_;
  CameraTopics topics_;
  WarningTable warnings_;
  std::vector<Frame> frames_;
  double frames_per_second_ = 30;
  std::size_t next_ = 0;
  std::vector<std::byte> color_bytes_;
  std::vector<std::byte> depth_bytes_;
  ColorImage color_;
  DepthImage16 depth_;
};

} // namespace kinora::formats
