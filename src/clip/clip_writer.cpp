// write_clip: what stands in which track and attachment.
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "clip/clip_description.h"
#include "clip/clip_io.h"
#include "clip/clip_layout.h"
#include "clip/codec_ids.h"
#include "clip/coding/allocation_budget.h"
#include "clip/payloads/births_codec.h"
#include "clip/payloads/confidence_codec.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/payloads/pose_codec.h"
#include "container/writer.h"
#include "core/error.h"

namespace kinora::clip {

namespace {

using container::Payload;

// As the reader will, so that no file is written that cannot be read.
void check_readable(const Bytes& clip_json, const Bytes& calibration) {
  try {
    parse_clip_description(clip_json, kClipFile);
    parse_intrinsics(calibration, kCalibrationFile);
  } catch (const Error& error) {
    refuse_to_store(error.what());
  }
}

container::FileHead head_of(const Clip& clip, const ClipDescription& description) {
  container::FileHead head;
  head.kind = std::string(kClipKind);
  head.tracks.push_back({description.camera_track, std::string(kCameraCodec), "camera", {}});
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    const LayerDescription& layer = description.layers[l];
    head.tracks.push_back({layer.field_track, std::string(kFieldCodec), "field " + layer.name, {}});
    if (layer.motion_track != 0) {
      const auto& graph = clip.layers[l].motion.graph();
      head.tracks.push_back({layer.motion_track, std::string(kMotionCodec), "motion " + layer.name,
                             graph ? encode_graph(*graph) : Bytes{}});
    }
    if (layer.confidence_track != 0) {
      head.tracks.push_back({layer.confidence_track, std::string(kConfidenceCodec), "confidence " + layer.name, {}});
    }
    if (layer.joints_track != 0) {
      head.tracks.push_back({layer.joints_track, std::string(kJointsCodec), "joints " + layer.name, {}});
    }
    if (layer.births_track != 0) {
      head.tracks.push_back({layer.births_track, std::string(kBirthsCodec), "births " + layer.name, {}});
    }
  }
  if (clip.sound) {
    head.tracks.push_back(clip.sound->track);
    head.tracks.back().id = container::kSoundTrack;
    head.tracks.back().name = container::kSoundName;
  }
  constexpr const char* kJson = "application/json";
  head.attachments = {
      {kClipFile, kJson, "Timeline and layers", to_json(description)},
      {kCalibrationFile, kJson, "Intrinsics of the capture camera", to_json(clip.intrinsics)},
      {kCompressedMetadataFile, "application/zstd", "How the clip was made", compress(to_json(clip.metadata))}};
  check_readable(head.attachments[0].bytes, head.attachments[1].bytes);
  head.duration_ns = description.times_ns.back();
  return head;
}

// In the order of the file: by time; at the first, where camera and layers are comes before the fields, and the coarse
// levels of all fields before the finer ones, so that a picture can be shown early and becomes sharper.
std::vector<Payload> payloads_of(const Clip& clip, const ClipDescription& description, const StorageOptions& options) {
  std::vector<Payload> payloads;
  const auto add = [&payloads](std::uint16_t track, std::int64_t time, bool key, Bytes bytes) {
    payloads.push_back({track, time, key, std::move(bytes)});
  };
  std::vector<MotionEncoder> motions;
  for (const Layer& layer : clip.layers) motions.emplace_back(layer.motion);
  const auto add_poses = [&](std::size_t frame) {
    const std::int64_t time = description.times_ns[frame];
    if (frame < clip.camera_to_world.size()) {
      add(description.camera_track, time, true, encode_camera(clip.camera_to_world[frame]));
    }
    for (std::size_t l = 0; l < clip.layers.size(); ++l) {
      if (description.layers[l].motion_track == 0) continue;
      auto [key, bytes] = motions[l].encode(frame);
      add(description.layers[l].motion_track, time, key, std::move(bytes));
    }
  };
  add_poses(0);
  std::vector<std::vector<Bytes>> fields;
  std::size_t most_payloads = 0;
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    const Layer& layer = clip.layers[l];
    const LayerDescription& tracks = description.layers[l];
    fields.push_back(encode_field_coarse_first(layer.field, options.fields.empty() ? usual_rounding(layer.field.config)
                                                                                   : options.fields.at(l)));
    most_payloads = std::max(most_payloads, fields.back().size());
    add(tracks.field_track, description.times_ns.front(), true, std::move(fields.back().front()));
    if (layer.confidence) {
      add(tracks.confidence_track, description.times_ns.front(), true, encode_confidence(*layer.confidence));
    }
    if (layer.joints) add(tracks.joints_track, description.times_ns.front(), true, encode_joints(*layer.joints));
    if (tracks.births_track != 0) {
      add(tracks.births_track, description.times_ns.front(), true, encode_births(layer.births, *layer.motion.graph()));
    }
  }
  for (std::size_t finer = 1; finer < most_payloads; ++finer) {
    for (std::size_t l = 0; l < clip.layers.size(); ++l) {
      if (finer < fields[l].size())
        add(description.layers[l].field_track, description.times_ns.front(), false, std::move(fields[l][finer]));
    }
  }
  for (std::size_t frame = 1; frame < clip.times.size(); ++frame) add_poses(frame);
  if (clip.sound) {
    for (const Payload& packet : clip.sound->packets) add(container::kSoundTrack, packet.time_ns, true, packet.bytes);
    std::ranges::stable_sort(payloads, {}, &Payload::time_ns);
  }
  return payloads;
}

// As the reader will, which trusts no file.
void check_memory(const Clip& clip, const std::vector<Payload>& payloads) {
  std::uint64_t bytes = 0;
  for (const Payload& payload : payloads) bytes += payload.bytes.size();
  AllocationBudget budget(bytes);
  for (const Layer& layer : clip.layers) {
    if (!budget.try_take(decoding_memory(layer.field.config))) {
      refuse_to_store(fmt::format(
          "the table of layer {} is far larger than what is in it; train it with a smaller table", layer.name));
    }
    if (layer.confidence && !budget.try_take(decoding_memory(*layer.confidence))) {
      refuse_to_store(fmt::format("layer {} fills far more space than its field needs; train it again", layer.name));
    }
    if (layer.joints && !budget.try_take(decoding_memory(*layer.joints))) {
      refuse_to_store(fmt::format("layer {} has far more joints than its motion needs", layer.name));
    }
    if (layer.motion.graph() && !budget.try_take(decoding_memory(*layer.motion.graph(), clip.times.size()))) {
      refuse_to_store(fmt::format("layer {} has far more nodes than its motion needs; give it fewer", layer.name));
    }
  }
}

motion::JointPaths stored_joints(const motion::JointPaths& joints) {
  const Bytes bytes = encode_joints(joints);
  AllocationBudget budget(bytes.size());
  return decode_joints(bytes, joints.positions.size(), "joints", budget);
}

motion::Motion stored_motion(const Layer& layer) {
  const motion::Motion& motion = layer.motion;
  if (motion.kind() == motion::MotionKind::kStill) return motion;
  MotionEncoder encoder(motion);
  if (motion.kind() == motion::MotionKind::kRigid) {
    std::vector<motion::Motion::Pose> poses;
    for (std::size_t frame = 0; frame < motion.poses().size(); ++frame) {
      poses.push_back(decode_pose(encoder.encode(frame).bytes, layer.name));
    }
    return motion::Motion::rigid(std::move(poses));
  }
  auto graph = decode_graph(encode_graph(*motion.graph()), layer.name);
  DeformationDecoder decoder(*graph);
  std::vector<motion::Motion::Deformation> deformations;
  for (std::size_t frame = 0; frame < motion.deformations().size(); ++frame) {
    const auto [key, bytes] = encoder.encode(frame);
    deformations.push_back(decoder.decode(bytes, key, layer.name));
  }
  return motion::Motion::deforming(std::move(graph), std::move(deformations));
}

} // namespace

void write_clip(const Clip& clip, const std::filesystem::path& path, const StorageOptions& options) {
  check_storable(clip);
  const ClipDescription description = describe(clip);
  const container::FileHead head = head_of(clip, description);
  const std::vector<Payload> payloads = payloads_of(clip, description, options);
  check_memory(clip, payloads); // all that can be refused is, before a file is made
  container::Writer writer(path, head);
  for (const Payload& payload : payloads) writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
  writer.finish();
}

Clip as_stored(const Clip& clip) {
  check_storable(clip);
  Clip stored = clip;
  for (SE3& pose : stored.camera_to_world) pose = decode_pose(encode_camera(pose), "camera").canonical_to_world;
  for (Layer& layer : stored.layers) {
    layer.field = quantised(layer.field);
    layer.motion = stored_motion(layer);
    if (layer.joints) layer.joints = stored_joints(*layer.joints);
  }
  return stored;
}

} // namespace kinora::clip
