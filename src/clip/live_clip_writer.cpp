#include "clip/live_clip_writer.h"

#include <algorithm>
#include <functional>
#include <string_view>

#include "clip/clip_layout.h"
#include "clip/codec_ids.h"
#include "clip/payloads/births_codec.h"
#include "clip/payloads/confidence_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/payloads/pose_codec.h"
#include "core/error.h"

namespace kinora::clip {

namespace {

std::size_t hash_of(std::span<const std::byte> bytes) {
  return std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::size_t hash_of(const motion::Motion::Deformation& deformation) {
  return hash_of(std::as_bytes(std::span(deformation.node_to_world))) + static_cast<std::size_t>(deformation.health);
}

container::FileHead live_head(const Intrinsics& intrinsics) {
  container::FileHead head;
  head.kind = std::string(kLiveClipKind);
  head.tracks.push_back({kUpdateTrack, std::string(kUpdateCodec), "updates", {}});
  head.attachments.push_back(
      {kCalibrationFile, "application/json", "Intrinsics of the capture camera", to_json(intrinsics)});
  return head;
}

container::WriterOptions durable() {
  container::WriterOptions options;
  options.durable = true;
  return options;
}

} // namespace

void GrowingMotion::keep_if_same(const Bytes& graph, const std::vector<std::size_t>& hashes) {
  const auto is_same = [](const CodedFrame& frame, std::size_t hash) { return frame.hash == hash; };
  if (graph == graph_ && frames_.size() <= hashes.size() &&
      std::equal(frames_.begin(), frames_.end(), hashes.begin(), is_same))
    return;
  frames_.clear();
  frames_in_key_ = 0;
  encoder_.reset();
}

void GrowingMotion::update(const motion::Motion& motion) {
  std::vector<std::size_t> hashes;
  if (motion.kind() != motion::MotionKind::kDeforming) {
    std::vector<Bytes> poses;
    for (const motion::Motion::Pose& pose : motion.poses()) {
      poses.push_back(encode_pose(pose));
      hashes.push_back(hash_of(poses.back()));
    }
    keep_if_same({}, hashes);
    graph_.clear();
    for (std::size_t f = frames_.size(); f < poses.size(); ++f)
      frames_.push_back({hashes[f], {true, std::move(poses[f])}});
    return;
  }
  for (const motion::Motion::Deformation& deformation : motion.deformations()) hashes.push_back(hash_of(deformation));
  Bytes graph = encode_graph(*motion.graph());
  keep_if_same(graph, hashes);
  graph_ = std::move(graph);
  if (!encoder_) encoder_.emplace(*motion.graph());
  for (std::size_t f = frames_.size(); f < hashes.size(); ++f)
    frames_.push_back({hashes[f], encoder_->encode(motion.deformations()[f])});
}

void GrowingMotion::update(const std::vector<SE3>& path) {
  std::vector<motion::Motion::Pose> poses;
  poses.reserve(path.size());
  for (const SE3& pose : path) poses.push_back({pose, motion::Health::kTracked});
  update(motion::Motion::rigid(std::move(poses)));
}

Bytes GrowingMotion::coded(std::size_t first) const {
  Bytes out;
  for (std::size_t f = first; f < frames_.size(); ++f)
    append_frame(out, {frames_[f].coded.key, frames_[f].coded.bytes});
  return out;
}

/// The parts own their bytes until the update is put together.
struct LiveClipWriter::Parts {
  UpdateView view;
  std::vector<std::unique_ptr<Bytes>> bytes;

  void add(UpdatePart what, std::uint16_t track, std::uint32_t from_key, Bytes part) {
    bytes.push_back(std::make_unique<Bytes>(std::move(part)));
    view.parts.push_back({what, track, from_key, *bytes.back()});
  }
  void add_motion(std::uint16_t track, bool key, GrowingMotion& motion) {
    if (key) motion.begin_key();
    const std::size_t in_key = key ? 0 : motion.frames_in_key();
    if (in_key == 0 && !motion.graph().empty()) add(UpdatePart::kGraph, track, 0, motion.graph());
    add(UpdatePart::kMotion, track, static_cast<std::uint32_t>(in_key), motion.coded(in_key));
  }
};

LiveClipWriter::LiveClipWriter(const std::filesystem::path& path, const Intrinsics& intrinsics)
    : writer_(path, live_head(intrinsics), durable()) {
  writer_.flush();
}

void LiveClipWriter::add_layer(const Layer& layer, const LayerDescription& tracks, bool key, Parts& parts) {
  LayerState& state = layers_[layer.name];
  const bool is_difference = !key && state.key_field.config == layer.field.config && !state.key_field.table.empty();
  parts.add(UpdatePart::kField, tracks.field_track, is_difference ? 1 : 0,
            is_difference ? encode_field_difference(layer.field, state.key_field) : encode_field(layer.field));
  if (key) {
    AllocationBudget budget(layer.field.table.size() * sizeof(float));
    state.key_field = decode_field(parts.view.parts.back().bytes, "a field that was just encoded", budget);
  }
  if (tracks.motion_track != 0) {
    state.motion.update(layer.motion);
    parts.add_motion(tracks.motion_track, key, state.motion);
  }
  if (layer.confidence)
    parts.add(UpdatePart::kConfidence, tracks.confidence_track, 0, encode_confidence(*layer.confidence));
  if (layer.joints) parts.add(UpdatePart::kJoints, tracks.joints_track, 0, encode_joints(*layer.joints));
  if (tracks.births_track != 0)
    parts.add(UpdatePart::kBirths, tracks.births_track, 0, encode_births(layer.births, *layer.motion.graph()));
}

Bytes LiveClipWriter::encode(const Clip& clip, bool key) {
  const ClipDescription description = describe(clip);
  Parts parts;
  parts.view.key = key ? keys_ : keys_ - 1;
  parts.add(UpdatePart::kDescription, 0, 0, compress(to_json(description)));
  parts.add(UpdatePart::kMetadata, 0, 0, compress(to_json(clip.metadata)));
  if (key) {
    std::erase_if(layers_, [&](const auto& known) {
      return std::ranges::none_of(clip.layers, [&](const Layer& layer) { return layer.name == known.first; });
    });
  }
  camera_.update(clip.camera_to_world);
  parts.add_motion(description.camera_track, key, camera_);
  for (std::size_t l = 0; l < clip.layers.size(); ++l) add_layer(clip.layers[l], description.layers[l], key, parts);
  return encode_update(parts.view);
}

void LiveClipWriter::write(const Clip& clip) {
  check_storable(clip);
  const bool key = keys_ == 0 || update_bytes_ > key_bytes_;
  const Bytes bytes = encode(clip, key);
  if (key) {
    ++keys_;
    key_bytes_ = bytes.size();
    update_bytes_ = 0;
  } else {
    update_bytes_ += bytes.size();
  }
  writer_.write(kUpdateTrack, describe(clip).times_ns.back(), key, bytes);
  writer_.flush();
  ++updates_;
}

} // namespace kinora::clip
