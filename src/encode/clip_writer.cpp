// write_clip: what stands in which track and attachment.
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "container/writer.h"
#include "core/error.h"
#include "encode/allocation_budget.h"
#include "encode/clip_description.h"
#include "encode/clip_io.h"
#include "encode/codec_ids.h"
#include "encode/field_codec.h"
#include "encode/pose_codec.h"

namespace kinora::encode {

namespace {

using container::Payload;

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::kFailure, fmt::format("a clip cannot be stored: {}", why));
}

std::vector<std::int64_t> times_in_ns(const std::vector<double>& times) {
  constexpr double kNanoseconds = 1e9;
  constexpr double kLongest = 1e6; // seconds; far beyond, a double in seconds is coarser than a nanosecond
  std::vector<std::int64_t> result;
  for (const double time : times) {
    if (!(time >= 0 && time < kLongest)) refuse(fmt::format("the time {} s is out of range", time));
    result.push_back(std::llrint(time * kNanoseconds));
    if (result.size() > 1 && result.back() <= result[result.size() - 2]) refuse("the frames' times do not increase");
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

void check(const Clip& clip) {
  const std::size_t frames = clip.times.size();
  if (frames == 0) refuse("it has no frame");
  if (clip.capture_frames.size() != frames || clip.held_out.size() != frames) {
    refuse("its frames, their numbers in the capture and their held-out marks differ in number");
  }
  if (clip.camera_to_world.size() != 1 && clip.camera_to_world.size() != frames) {
    refuse(fmt::format("{} camera poses for {} frames", clip.camera_to_world.size(), frames));
  }
  std::set<std::string> names;
  for (const Layer& layer : clip.layers) {
    if (!is_utf8(layer.name)) refuse("a layer's name is not UTF-8");
    if (!names.insert(layer.name).second) refuse(fmt::format("two layers are named {}", layer.name));
    if (layer.motion.kind() == tracking::MotionKind::kRigid && layer.motion.poses().size() != frames) {
      refuse(fmt::format("layer {} has {} poses for {} frames", layer.name, layer.motion.poses().size(), frames));
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
    if (entry.kind != tracking::MotionKind::kStill) entry.motion_track = next_track++;
    description.layers.push_back(std::move(entry));
  }
  return description;
}

// As the reader will, so that no file is written that cannot be read.
void check_readable(const Bytes& clip_json, const Bytes& calibration) {
  try {
    parse_clip_description(clip_json, kClipFile);
    parse_intrinsics(calibration, kCalibrationFile);
  } catch (const Error& error) {
    refuse(error.what());
  }
}

container::FileHead head_of(const Clip& clip, const ClipDescription& description) {
  container::FileHead head;
  head.kind = std::string(kClipKind);
  head.tracks.push_back({description.camera_track, std::string(kCameraCodec), "camera", {}});
  for (const LayerDescription& layer : description.layers) {
    head.tracks.push_back({layer.field_track, std::string(kFieldCodec), "field " + layer.name, {}});
    if (layer.motion_track != 0)
      head.tracks.push_back({layer.motion_track, std::string(kMotionCodec), "motion " + layer.name, {}});
  }
  constexpr const char* kJson = "application/json";
  head.attachments = {{kClipFile, kJson, "Timeline and layers", to_json(description)},
                      {kCalibrationFile, kJson, "Intrinsics of the capture camera", to_json(clip.intrinsics)},
                      {kMetadataFile, kJson, "How the clip was made", to_json(clip.metadata)}};
  check_readable(head.attachments[0].bytes, head.attachments[1].bytes);
  head.duration_ns = description.times_ns.back();
  return head;
}

std::vector<Bytes> encode_fields(const Clip& clip) {
  std::vector<Bytes> payloads;
  std::uint64_t bytes = 0;
  for (const Layer& layer : clip.layers) {
    payloads.push_back(encode_field(layer.field));
    bytes += payloads.back().size();
  }
  AllocationBudget budget(bytes);
  for (const Layer& layer : clip.layers) {
    if (!budget.try_take(decoding_memory(layer.field.config))) {
      refuse(fmt::format("the table of layer {} is far larger than what is in it; train it with a smaller table",
                         layer.name));
    }
  }
  return payloads;
}

Bytes encode_camera(const SE3& camera_to_world) { return encode_pose({camera_to_world, tracking::Health::kTracked}); }

std::vector<Payload> payloads_of(const Clip& clip, const ClipDescription& description) {
  std::vector<Payload> payloads;
  const auto add = [&payloads](std::uint16_t track, std::int64_t time, Bytes bytes) {
    payloads.push_back({track, time, true, std::move(bytes)});
  };
  std::vector<Bytes> fields = encode_fields(clip);
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    add(description.layers[l].field_track, description.times_ns.front(), std::move(fields[l]));
  }
  for (std::size_t frame = 0; frame < clip.times.size(); ++frame) {
    const std::int64_t time = description.times_ns[frame];
    if (frame < clip.camera_to_world.size()) {
      add(description.camera_track, time, encode_camera(clip.camera_to_world[frame]));
    }
    for (std::size_t l = 0; l < clip.layers.size(); ++l) {
      if (description.layers[l].motion_track == 0) continue;
      add(description.layers[l].motion_track, time, encode_pose(clip.layers[l].motion.poses()[frame]));
    }
  }
  return payloads;
}

} // namespace

void write_clip(const Clip& clip, const std::filesystem::path& path) {
  check(clip);
  const ClipDescription description = describe(clip);
  const container::FileHead head = head_of(clip, description);
  const std::vector<Payload> payloads =
      payloads_of(clip, description); // all that can be refused is, before a file is made
  container::Writer writer(path, head);
  for (const Payload& payload : payloads) writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
  writer.finish();
}

Clip as_stored(const Clip& clip) {
  check(clip);
  Clip stored = clip;
  for (SE3& pose : stored.camera_to_world) pose = decode_pose(encode_camera(pose), "camera").canonical_to_world;
  for (Layer& layer : stored.layers) {
    layer.field = quantised(layer.field);
    if (layer.motion.kind() == tracking::MotionKind::kStill) continue;
    std::vector<tracking::Motion::Pose> poses;
    for (const tracking::Motion::Pose& pose : layer.motion.poses())
      poses.push_back(decode_pose(encode_pose(pose), layer.name));
    layer.motion = tracking::Motion::rigid(std::move(poses));
  }
  return stored;
}

} // namespace kinora::encode
