// The ROS messages that a capture is made of, out of their bytes.
// Sources: http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes (ROS 1); OMG DDS-XTypes 1.3,
// section 7.4, plain CDR (ROS 2); the .msg files of std_msgs, sensor_msgs, geometry_msgs and tf2_msgs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/se3.h"
#include "ros/message_log.h"

namespace kinora::formats {

/// The bytes of a message, and where it comes from, for errors.
struct MessageBytes {
  std::span<const std::byte> bytes;
  MessageEncoding encoding = MessageEncoding::kRos1;
  std::string source;
};

struct Header {
  double stamp = 0; ///< seconds; 0 if the sender gave none
  std::string frame_id;
};

/// sensor_msgs/Image, or sensor_msgs/CompressedImage: then `encoding` is its format and height, width and step are 0.
struct ImageMessage {
  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;
  bool big_endian = false;
  std::uint32_t step = 0;          ///< bytes from one row to the next
  std::span<const std::byte> data; ///< points into the message
};

struct CameraInfoMessage {
  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;
  double k[9] = {};
};

struct TransformMessage {
  std::string parent;
  std::string child;
  SE3 child_to_parent = SE3::Identity();
};

/// All throw Error(kCorruptInput), naming the message's source, if it is too short or its numbers make no sense.
ImageMessage image_of(const MessageBytes& message, bool compressed);
/// The time stamp alone: of messages that begin with a header.
double stamp_of(const MessageBytes& message);
CameraInfoMessage camera_info_of(const MessageBytes& message);
std::vector<TransformMessage> transforms_of(const MessageBytes& message); ///< tf2_msgs/TFMessage
SE3 transform_of(const MessageBytes& message);                            ///< geometry_msgs/Transform
float float32_of(const MessageBytes& message);                            ///< std_msgs/Float32

} // namespace kinora::formats
