#include "ros/camera_topics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/float_depth.h"
#include "core/error.h"
#include "ros/messages.h"
#include "ros/ros_images.h"

namespace kinora::formats {
namespace {

bool has(const std::string& text, const char* word) { return text.find(word) != std::string::npos; }

std::string without_suffix(std::string text, std::string_view suffix) {
  if (text.ends_with(suffix)) text.resize(text.size() - suffix.size());
  return text;
}

/// The part before the last '/'.
std::string parent_of(const std::string& topic) { return topic.substr(0, std::min(topic.rfind('/'), topic.size())); }

/// A topic with images.
struct Candidate {
  CameraTopic topic;
  std::string name;
  bool is_depth = false;
  bool is_color = false;
  int rank = 0; ///< the largest is taken
};

class TopicSearch {
public:
  explicit TopicSearch(MessageReader& reader) : reader_(reader), log_(reader.log()) {
    for (std::size_t i = 0; i < log_.messages.size(); ++i) first_.try_emplace(log_.messages[i].channel, i);
  }

  CameraTopics find(const std::string& color, const std::string& depth) {
    find_candidates();
    CameraTopics topics;
    topics.color = choose(color, &Candidate::is_color, "colour");
    topics.depth = choose(depth, &Candidate::is_depth, "depth");
    calibrate(topics.color, topics);
    calibrate(topics.depth, topics);
    topics.depth_unit = depth_unit(topics.depth);
    relate(topics);
    return topics;
  }

private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw Error(ErrorCode::kCorruptInput, reader_.name() + ": " + problem);
  }
  const std::string& name_of(const CameraTopic& topic) const { return log_.channels[topic.channel].topic; }

  /// The first message of a channel, with its bytes in first_bytes_.
  MessageBytes first_of(std::size_t channel) {
    first_bytes_ = reader_.read(log_.messages[first_.at(channel)]);
    return {first_bytes_, log_.channels[channel].encoding, reader_.name() + ", " + log_.channels[channel].topic};
  }

  std::optional<std::size_t> channel_called(const std::string& topic, const char* type) const {
    for (const auto& [channel, message] : first_)
      if (log_.channels[channel].topic == topic && log_.channels[channel].type == type) return channel;
    return std::nullopt;
  }

  void find_candidates() {
    for (const auto& [channel, message] : first_) {
      const Channel& entry = log_.channels[channel];
      const bool compressed = entry.type == "sensor_msgs/CompressedImage";
      if ((!compressed && entry.type != "sensor_msgs/Image") || entry.encoding == MessageEncoding::kOther) continue;
      try {
        add_candidate(channel, compressed);
      } catch (const Error&) {
        continue; // another topic may do
      }
    }
  }

  void add_candidate(std::size_t channel, bool compressed) {
    const ImageMessage image = image_of(first_of(channel), compressed);
    Candidate candidate;
    candidate.name = log_.channels[channel].topic;
    candidate.topic = {channel, compressed, image.encoding, image.header.frame_id, {}, {}};
    const bool infrared = has(candidate.name, "nfra") || has(candidate.name, "/ir");
    const bool confidence = has(candidate.name, "onfidence");
    candidate.is_depth = !infrared && !confidence && is_depth_encoding(image.encoding, compressed);
    candidate.is_color = !infrared && !confidence && is_color_encoding(image.encoding, compressed);
    candidate.rank = (compressed ? 0 : 1) +
                     (has(candidate.name, "aligned") || has(candidate.name, "registered") ? 4 : 0) +
                     (candidate.is_color && image.encoding != "mono8" ? 2 : 0) +
                     (candidate.is_color && has(candidate.name, "rect") ? 1 : 0) +
                     (candidate.is_color && has(candidate.name, "depth") ? -8 : 0);
    candidates_.push_back(std::move(candidate));
  }

  CameraTopic choose(const std::string& wanted, bool Candidate::*fits, const char* what) const {
    const Candidate* best = nullptr;
    for (const Candidate& candidate : candidates_) {
      if (!(candidate.*fits) || (!wanted.empty() && candidate.name != wanted)) continue;
      if (best == nullptr || candidate.rank > best->rank) best = &candidate;
    }
    if (best != nullptr) return best->topic;
    std::string there;
    for (const Candidate& candidate : candidates_) there += (there.empty() ? "" : ", ") + candidate.name;
    fail(std::string("has no ") + what + " images" + (wanted.empty() ? "" : " under " + wanted) +
         "; topics with images: " + (there.empty() ? "none" : there));
  }

  void calibrate(CameraTopic& topic, CameraTopics& topics) {
    const std::string base = without_suffix(without_suffix(name_of(topic), "/compressed"), "/compressedDepth");
    constexpr const char* kType = "sensor_msgs/CameraInfo";
    auto channel = channel_called(parent_of(base) + "/camera_info", kType);
    if (!channel) channel = channel_called(parent_of(parent_of(base)) + "/info/camera_info", kType); // librealsense
    if (!channel) fail("has no camera_info beside " + name_of(topic) + "; record it too");
    const CameraInfoMessage info = camera_info_of(first_of(*channel));
    topic.intrinsics = {static_cast<int>(std::min(info.width, 100'000U)),
                        static_cast<int>(std::min(info.height, 100'000U)),
                        info.k[0],
                        info.k[4],
                        info.k[2],
                        info.k[5]};
    topic.intrinsics.validate(reader_.name() + ", " + log_.channels[*channel].topic);
    if (has(base, "rect")) return; // the lens is straightened already
    double d[5] = {};
    std::copy_n(info.d.begin(), std::min<std::size_t>(info.d.size(), 5), d);
    const bool more =
        info.d.size() > 5 && std::any_of(info.d.begin() + 5, info.d.end(), [](double k) { return k != 0; });
    const bool known = !more && info.distortion_model != "equidistant" && !has(info.distortion_model, "kannala") &&
                       std::all_of(std::begin(d), std::end(d), [](double k) { return std::abs(k) < 100; });
    if (known)
      topic.distortion = {d[0], d[1], d[2], d[3], d[4]};
    else
      topics.warnings.push_back(reader_.name() + ": the lens of " + name_of(topic) + " is described as " +
                                info.distortion_model + ", which is not applied; use rectified images");
  }

  /// librealsense's bags say it.
  double depth_unit(const CameraTopic& depth) {
    if (is_float_depth(depth.encoding)) return kFloatDepthUnit;
    for (const auto& [channel, message] : first_) {
      const std::string& topic = log_.channels[channel].topic;
      if (log_.channels[channel].type != "std_msgs/Float32" || !has(topic, "Depth") || !has(topic, "Units")) continue;
      const float unit = float32_of(first_of(channel));
      if (unit > 0 && unit <= 1) return std::stod(short_text(unit));
    }
    return 0.001;
  }

  /// 0.001F as the double 0.001.
  static std::string short_text(float value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.7g", static_cast<double>(value));
    return text;
  }

  void relate(CameraTopics& topics) {
    const std::string& name = name_of(topics.depth);
    if (has(name, "aligned") || has(name, "registered") || topics.depth.frame_id == topics.color.frame_id) {
      if (!has(name, "/device_")) return; // librealsense gives all images one frame
    }
    topics.depth_to_color = from_librealsense(topics);
    if (!topics.depth_to_color) topics.depth_to_color = from_transforms(topics);
    if (!topics.depth_to_color)
      fail(name + " is not registered to " + name_of(topics.color) +
           ", and no transform says how the two cameras stand; record /tf_static too, or aligned depth");
  }

  /// /device_0/sensor_0/Depth_0/tf/0 carries points of a common origin to the stream.
  std::optional<SE3> from_librealsense(const CameraTopics& topics) {
    const auto origin_to = [this](const CameraTopic& topic) {
      return channel_called(parent_of(parent_of(name_of(topic))) + "/tf/0", "geometry_msgs/Transform");
    };
    const auto color = origin_to(topics.color);
    const auto depth = origin_to(topics.depth);
    if (!color || !depth) return std::nullopt;
    const SE3 to_color = transform_of(first_of(*color));
    return to_color * transform_of(first_of(*depth)).inverse();
  }

  std::optional<SE3> from_transforms(const CameraTopics& topics) {
    read_transforms();
    const auto color = to_root(topics.color.frame_id);
    const auto depth = to_root(topics.depth.frame_id);
    if (color.first != depth.first) return std::nullopt;
    return color.second.inverse() * depth.second;
  }

  void read_transforms() {
    constexpr std::size_t kMaxMessages = 1000; // they repeat
    std::size_t count = 0;
    for (const LoggedMessage& message : log_.messages) {
      const Channel& channel = log_.channels[message.channel];
      if (without_suffix(channel.topic, "_static") != "/tf" || channel.encoding == MessageEncoding::kOther) continue;
      if (++count > kMaxMessages) return;
      const std::vector<std::byte> bytes = reader_.read(message);
      for (TransformMessage& one : transforms_of({bytes, channel.encoding, reader_.name() + ", " + channel.topic}))
        if (const std::string child = one.child; !tree_.contains(child)) tree_.emplace(child, std::move(one));
    }
  }

  /// The root above a frame of coordinates, and the way there.
  std::pair<std::string, SE3> to_root(std::string frame) const {
    constexpr int kMaxDepth = 100; // a damaged tree may have rings
    SE3 way = SE3::Identity();
    for (int depth = 0; depth < kMaxDepth; ++depth) {
      const auto parent = tree_.find(frame);
      if (parent == tree_.end()) break;
      way = parent->second.child_to_parent * way;
      frame = parent->second.parent;
    }
    return {frame, way};
  }

  MessageReader& reader_;
  const MessageLog& log_;
  std::map<std::size_t, std::size_t> first_; ///< message of each channel
  std::vector<std::byte> first_bytes_;
  std::vector<Candidate> candidates_;
  std::map<std::string, TransformMessage> tree_; ///< by child
};

} // namespace

CameraTopics find_camera_topics(MessageReader& reader, const std::string& color, const std::string& depth) {
  return TopicSearch(reader).find(color, depth);
}

} // namespace kinora::formats
