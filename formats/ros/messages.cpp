#include "ros/messages.h"

#include <cmath>

#include "common/byte_reader.h"

namespace kinora::formats {
namespace {

/// Values in the order of the .msg file. CDR aligns each number to its size; ROS 1 does not.
class Fields {
public:
  explicit Fields(const MessageBytes& message)
      : reader_(message.bytes, message.source), aligned_(message.encoding == MessageEncoding::kCdr) {
    if (!aligned_) return;
    const auto head = reader_.bytes(kCdrHead);
    if (head[0] != std::byte{0} || head[1] != std::byte{1}) reader_.fail("is not little-endian CDR");
  }

  template <class Number> Number number() {
    if (aligned_) {
      const std::size_t over = (reader_.position() - kCdrHead) % sizeof(Number);
      if (over != 0) (void)reader_.bytes(sizeof(Number) - over);
    }
    return reader_.number<Number>();
  }

  std::string text() {
    std::string text = reader_.text(number<std::uint32_t>());
    if (aligned_ && text.ends_with('\0')) text.pop_back();
    return text;
  }

  std::span<const std::byte> bytes() { return reader_.bytes(number<std::uint32_t>()); }

  /// The length of a list whose elements take at least `element_bytes` each.
  std::uint32_t count(std::size_t element_bytes) {
    const auto count = number<std::uint32_t>();
    if (count > reader_.left() / element_bytes) reader_.fail("a list in the message goes beyond its end");
    return count;
  }

  double finite() {
    const auto value = number<double>();
    if (!std::isfinite(value)) reader_.fail("a number is not finite");
    return value;
  }

  Header header() {
    if (!aligned_) (void)number<std::uint32_t>(); // ROS 1 counts messages
    const auto seconds = number<std::uint32_t>();
    const auto nanoseconds = number<std::uint32_t>();
    return {static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds), text()};
  }

  SE3 transform() {
    Eigen::Vector3d t;
    for (double& value : t) value = finite();
    Eigen::Vector4d q; // x y z w
    for (double& value : q) value = finite();
    if (!(std::abs(q.norm() - 1) < 1e-2)) reader_.fail("a rotation is no unit quaternion");
    SE3 transform = SE3::Identity();
    transform.linear() = Eigen::Quaterniond(q).normalized().toRotationMatrix();
    transform.translation() = t;
    return transform;
  }

private:
  static constexpr std::size_t kCdrHead = 4;
  ByteReader reader_;
  bool aligned_;
};

} // namespace

ImageMessage image_of(const MessageBytes& message, bool compressed) {
  Fields fields(message);
  ImageMessage image;
  image.header = fields.header();
  if (!compressed) {
    image.height = fields.number<std::uint32_t>();
    image.width = fields.number<std::uint32_t>();
  }
  image.encoding = fields.text();
  if (!compressed) {
    image.big_endian = fields.number<std::uint8_t>() != 0;
    image.step = fields.number<std::uint32_t>();
  }
  image.data = fields.bytes();
  return image;
}

double stamp_of(const MessageBytes& message) { return Fields(message).header().stamp; }

CameraInfoMessage camera_info_of(const MessageBytes& message) {
  Fields fields(message);
  CameraInfoMessage info;
  info.header = fields.header();
  info.height = fields.number<std::uint32_t>();
  info.width = fields.number<std::uint32_t>();
  info.distortion_model = fields.text();
  info.d.resize(fields.count(sizeof(double)));
  for (double& value : info.d) value = fields.finite();
  for (double& value : info.k) value = fields.finite();
  return info;
}

std::vector<TransformMessage> transforms_of(const MessageBytes& message) {
  Fields fields(message);
  std::vector<TransformMessage> transforms;
  const auto count = fields.count(sizeof(double) * 7);
  for (std::uint32_t i = 0; i < count; ++i) {
    TransformMessage transform;
    transform.parent = fields.header().frame_id;
    transform.child = fields.text();
    transform.child_to_parent = fields.transform();
    transforms.push_back(std::move(transform));
  }
  return transforms;
}

SE3 transform_of(const MessageBytes& message) { return Fields(message).transform(); }

float float32_of(const MessageBytes& message) { return Fields(message).number<float>(); }

} // namespace kinora::formats
