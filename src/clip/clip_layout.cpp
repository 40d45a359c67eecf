#include "clip/clip_layout.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "clip/payloads/pose_codec.h"
#include "core/error.h"

namespace kinora::clip {

namespace {

std::vector<std::int64_t> times_in_ns(const std::vector<double>& times) {
  constexpr double kNanoseconds = 1e9;
  constexpr double kLongest = 1e6; // seconds; far beyond, a double in seconds is coarser than a nanosecond
  std::vector<std::int64_t> result;
  for (const double time : times) {
    if (!(time >= 0 && time < kLongest)) refuse_to_store(fmt::format("the time {} s is out of range", time));
    result.push_back(std::llrint(time * kNanoseconds));
    if (result.size() > 1 && result.back() <= result[result.size() - 2])
      refuse_to_store("the frames' times do not increase");
  }
  return result;
}

bool is_utf8(const std::string& text) {
  try {
    nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
  return true;
}

} // namespace

void refuse_to_store(const std::string& why) {
  throw Error(ErrorCode::kFailure, fmt::format("a clip cannot be stored: {}", why));
}

void check_storable(const Clip& clip) {
  const std::size_t frames = clip.times.size();
  if (frames == 0) refuse_to_store("it has no frame");
  if (clip.capture_frames.size() != frames || clip.held_out.size() != frames) {
    refuse_to_store("its frames, their numbers in the capture and their held-out marks differ in number");
  }
  if (clip.camera_to_world.size() != 1 && clip.camera_to_world.size() != frames) {
    refuse_to_store(fmt::format("{} camera poses for {} frames", clip.camera_to_world.size(), frames));
  }
  std::set<std::string> names;
  for (const Layer& layer : clip.layers) {
    if (!is_utf8(layer.name)) refuse_to_store("a layer's name is not UTF-8");
    if (!names.insert(layer.name).second) refuse_to_store(fmt::format("two layers are named {}", layer.name));
    const std::size_t moved = std::max(layer.motion.poses().size(), layer.motion.deformations().size());
    if (layer.motion.kind() != motion::MotionKind::kStill && moved != frames) {
      refuse_to_store(fmt::format("layer {} moves in {} of {} frames", layer.name, moved, frames));
    }
    if (layer.joints &&
        (layer.motion.kind() != motion::MotionKind::kDeforming || layer.joints->positions.size() != frames)) {
      refuse_to_store(fmt::format("the joints of layer {} are not of its motion", layer.name));
    }
    if (const auto& away = layer.presence.away(); !away.empty() && away.back().end > frames)
      refuse_to_store(fmt::format("layer {} is away at frames that are not there", layer.name));
    if (const auto& births = layer.births.frames(); !births.empty()) {
      if (!layer.motion.graph() || births.size() != layer.motion.graph()->nodes().size())
        refuse_to_store(fmt::format("the births of layer {} are not of its motion", layer.name));
      if (*std::max_element(births.begin(), births.end()) > frames)
        refuse_to_store(fmt::format("a node of layer {} is born behind the last frame", layer.name));
    }
    if (layer.confidence &&
        layer.confidence->blocks().words() != fields::Confidence(layer.field.occupancy).blocks().words()) {
      refuse_to_store(fmt::format("the confidence of layer {} is of another field", layer.name));
    }
  }
}

ClipDescription describe(const Clip& clip) {
  ClipDescription description;
  description.times_ns = times_in_ns(clip.times);
  description.capture_frames = clip.capture_frames;
  description.held_out = clip.held_out;
  description.camera_moves = clip.camera_to_world.size() > 1;
  std::uint16_t next_track = 1;
  description.camera_track = next_track++;
  for (const Layer& layer : clip.layers) {
    LayerDescription entry{layer.name, layer.label, layer.motion.kind(), next_track++, 0};
    if (entry.kind != motion::MotionKind::kStill) entry.motion_track = next_track++;
    if (layer.confidence) entry.confidence_track = next_track++;
    if (layer.joints) entry.joints_track = next_track++;
    if (!layer.births.are_at_the_start()) entry.births_track = next_track++;
    entry.presence = layer.presence;
    description.layers.push_back(std::move(entry));
  }
  return description;
}

Bytes encode_camera(const SE3& camera_to_world) { return encode_pose({camera_to_world, motion::Health::kTracked}); }

MotionEncoder::MotionEncoder(const motion::Motion& motion) : motion_(motion) {
  if (motion.graph()) deformation_.emplace(*motion.graph());
}

DeformationEncoder::Coded MotionEncoder::encode(std::size_t frame) {
  if (deformation_) return deformation_->encode(motion_.deformations()[frame]);
  return {true, encode_pose(motion_.poses()[frame])};
}

} // namespace kinora::clip
