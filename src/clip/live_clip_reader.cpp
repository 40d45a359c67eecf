#include "clip/live_clip_reader.h"

#include <algorithm>

#include <fmt/format.h>

#include "clip/clip_description.h"
#include "clip/payloads/births_codec.h"
#include "clip/payloads/confidence_codec.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/payloads/pose_codec.h"
#include "clip/payloads/update_codec.h"
#include "core/error.h"

namespace kinora::clip {

namespace {

using motion::Motion;
using motion::MotionKind;

/// Frames of a motion, and how to go on behind them.
struct DecodedMotion {
  std::vector<Motion::Pose> poses;
  std::shared_ptr<const motion::DeformationGraph> graph; ///< if it deforms
  std::optional<DeformationDecoder> decoder;
  std::vector<Motion::Deformation> deformations;
};

/// A clip as of one update.
struct DecodedUpdate {
  Clip clip;
  DecodedMotion camera;
  std::vector<DecodedMotion> motions; ///< one per layer
};

class UpdateDecoder {
public:
  /// `base`: the key update that this one is understood with; null if it is one itself.
  UpdateDecoder(std::span<const std::byte> payload, std::string location, const DecodedUpdate* base,
                AllocationBudget budget)
      : location_(std::move(location)), base_(base), budget_(budget), parts_(decode_update(payload, location_).parts) {}

  DecodedUpdate decode(const Intrinsics& intrinsics) {
    const ClipDescription description = parse_clip_description(decompressed(UpdatePart::kDescription), location_);
    DecodedUpdate out;
    out.clip.intrinsics = intrinsics;
    out.clip.metadata = parse_json(decompressed(UpdatePart::kMetadata), location_);
    constexpr double kNanoseconds = 1e9;
    for (const std::int64_t time : description.times_ns)
      out.clip.times.push_back(static_cast<double>(time) / kNanoseconds);
    out.clip.capture_frames = description.capture_frames;
    out.clip.held_out = description.held_out;
    const std::size_t frames = out.clip.times.size();
    out.camera = motion_of(description.camera_track, MotionKind::kRigid, description.camera_moves ? frames : 1,
                           base_ == nullptr ? nullptr : &base_->camera);
    for (const Motion::Pose& pose : out.camera.poses) out.clip.camera_to_world.push_back(pose.canonical_to_world);
    for (const LayerDescription& layer : description.layers) {
      out.motions.push_back(motion_of_layer(layer, frames));
      out.clip.layers.push_back(decode_layer(layer, out.motions.back(), frames));
    }
    return out;
  }

private:
  [[noreturn]] void corrupt(const std::string& why) const {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location_, why));
  }

  const PartView* find(UpdatePart what, std::uint16_t track) const {
    const auto is_it = [&](const PartView& part) { return part.what == what && part.track == track; };
    const auto found = std::find_if(parts_.begin(), parts_.end(), is_it);
    return found == parts_.end() ? nullptr : &*found;
  }

  const PartView& part(UpdatePart what, std::uint16_t track) const {
    const PartView* const found = find(what, track);
    if (found == nullptr) corrupt(fmt::format("an update lacks part {} of track {}", static_cast<int>(what), track));
    return *found;
  }

  Bytes decompressed(UpdatePart what) {
    constexpr std::uint64_t kMaxBytes = std::uint64_t{64} << 20;
    const std::span<const std::byte> frame = part(what, 0).bytes;
    const std::uint64_t size = decompressed_size(frame, location_);
    if (size > kMaxBytes) corrupt("an update's description is too large");
    budget_.take(size, location_);
    return decompress(frame, static_cast<std::size_t>(size), location_);
  }

  /// Its place among the layers of the key update.
  std::optional<std::size_t> in_base(const std::string& name) const {
    if (base_ == nullptr) return std::nullopt;
    const std::vector<Layer>& layers = base_->clip.layers;
    const auto found =
        std::find_if(layers.begin(), layers.end(), [&](const Layer& layer) { return layer.name == name; });
    if (found == layers.end()) return std::nullopt;
    return static_cast<std::size_t>(found - layers.begin());
  }

  DecodedMotion motion_of_layer(const LayerDescription& layer, std::size_t frames) {
    if (layer.kind == MotionKind::kStill) return {};
    const auto known = in_base(layer.name);
    return motion_of(layer.motion_track, layer.kind, frames, known ? &base_->motions[*known] : nullptr);
  }

  DecodedMotion motion_of(std::uint16_t track, MotionKind kind, std::size_t frames, const DecodedMotion* before) {
    const PartView& stored = part(UpdatePart::kMotion, track);
    DecodedMotion out;
    if (stored.from_key != 0) {
      if (before == nullptr || (before->graph != nullptr) != (kind == MotionKind::kDeforming))
        corrupt("a motion goes on from one that is not there");
      out = *before;
      if (out.poses.size() + out.deformations.size() != stored.from_key)
        corrupt("a motion goes on from another frame than the last of its key update");
    } else if (kind == MotionKind::kDeforming) {
      out.graph = decode_graph(part(UpdatePart::kGraph, track).bytes, location_);
      out.decoder.emplace(*out.graph);
    }
    const std::vector<FrameView> coded = frames_of(stored.bytes, location_);
    if (stored.from_key + coded.size() != frames)
      corrupt(fmt::format("a motion of {} frames where the clip has {}", stored.from_key + coded.size(), frames));
    budget_.take(kind == MotionKind::kDeforming ? decoding_memory(*out.graph, frames)
                                                : frames * 2 * sizeof(Motion::Pose),
                 location_);
    for (const FrameView& frame : coded) {
      if (kind == MotionKind::kDeforming) {
        out.deformations.push_back(out.decoder->decode(frame.bytes, frame.key, location_));
      } else {
        out.poses.push_back(decode_pose(frame.bytes, location_));
      }
    }
    return out;
  }

  Layer decode_layer(const LayerDescription& description, const DecodedMotion& motion, std::size_t frames) {
    Layer layer;
    layer.name = description.name;
    layer.label = description.label;
    layer.presence = description.presence;
    const PartView& field = part(UpdatePart::kField, description.field_track);
    const auto known = in_base(layer.name);
    if (field.from_key != 0 && !known) corrupt("a field is stored as the difference to one that is not there");
    layer.field = field.from_key == 0
                      ? decode_field(field.bytes, location_, budget_)
                      : decode_field_difference(field.bytes, base_->clip.layers[*known].field, location_, budget_);
    if (description.kind == MotionKind::kRigid) layer.motion = Motion::rigid(motion.poses);
    if (description.kind == MotionKind::kDeforming) layer.motion = Motion::deforming(motion.graph, motion.deformations);
    if (description.confidence_track != 0) {
      layer.confidence = decode_confidence(part(UpdatePart::kConfidence, description.confidence_track).bytes,
                                           layer.field.occupancy, location_, budget_);
    }
    if (description.joints_track != 0) {
      layer.joints =
          decode_joints(part(UpdatePart::kJoints, description.joints_track).bytes, frames, location_, budget_);
    }
    if (description.births_track != 0) {
      layer.births = decode_births(part(UpdatePart::kBirths, description.births_track).bytes, *motion.graph, frames,
                                   location_, budget_);
    }
    return layer;
  }

  std::string location_;
  const DecodedUpdate* base_;
  AllocationBudget budget_;
  std::vector<PartView> parts_;
};

} // namespace

bool LiveClipDecoder::take(container::Payload payload) {
  const std::uint32_t key = decode_update(payload.bytes, location_of(payload)).key;
  if (payload.key) {
    key_ = std::move(payload);
    key_number_ = key;
    update_.reset();
    return true;
  }
  if (!key_ || key != key_number_) return false;
  update_ = std::move(payload);
  return true;
}

Clip LiveClipDecoder::decode(const Intrinsics& intrinsics) const {
  if (!key_)
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: no update in it is whole; nothing can be shown", name_));
  DecodedUpdate key = UpdateDecoder(key_->bytes, location_of(*key_), nullptr, budget_).decode(intrinsics);
  if (!update_) return std::move(key.clip);
  return UpdateDecoder(update_->bytes, location_of(*update_), &key, budget_).decode(intrinsics).clip;
}

std::string LiveClipDecoder::location_of(const container::Payload& payload) const {
  return fmt::format("{}: byte {}", name_, payload.offset);
}

} // namespace kinora::clip
