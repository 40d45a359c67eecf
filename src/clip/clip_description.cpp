#include "clip/clip_description.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::clip {

using nlohmann::json;

namespace {

constexpr int kVersion = 1;
constexpr int kDeepestNesting = 64;
constexpr std::size_t kMaxLayers = 255;
constexpr std::size_t kLongestName = 255;

Bytes text_of(const json& value, int indent) {
  const std::string text = value.dump(indent, ' ', false, json::error_handler_t::replace);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

void check_version(const json& value, const std::string& location) {
  if (!value.is_object()) corrupt(location, "is not a JSON object");
  const auto version = value.find("version");
  if (version == value.end() || !version->is_number_integer()) corrupt(location, "has no version");
  if (*version != kVersion) {
    throw Error(ErrorCode::kNotRecognised,
                fmt::format("{}: has version {}; this Kinora reads version {}, use a newer one", location,
                            version->dump(), kVersion));
  }
}

const json& member(const json& object, const char* name, const std::string& location) {
  const auto found = object.find(name);
  if (found == object.end()) corrupt(location, fmt::format("has no \"{}\"", name));
  return *found;
}

// An integer within the range of T, and at least `min_value`.
template <class T> T integer(const json& value, T min_value, const char* name, const std::string& location) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<T>::max());
  const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <= kMax
                                               : value.is_number_integer() && value.get<std::int64_t>() >= min_value;
  if (!fits) corrupt(location, fmt::format("\"{}\" holds a number that is out of range", name));
  const T result = value.get<T>();
  if (result < min_value) corrupt(location, fmt::format("\"{}\" holds a number that is out of range", name));
  return result;
}

double number(const json& object, const char* name, const std::string& location) {
  const json& value = member(object, name, location);
  if (!value.is_number()) corrupt(location, fmt::format("\"{}\" is not a number", name));
  return value.get<double>();
}

const json& array(const json& object, const char* name, const std::string& location) {
  const json& value = member(object, name, location);
  if (!value.is_array()) corrupt(location, fmt::format("\"{}\" is not an array", name));
  return value;
}

std::uint16_t track(const json& object, const char* name, std::set<std::uint16_t>& taken, const std::string& location) {
  const auto id = integer<std::uint16_t>(member(object, name, location), 1, name, location);
  if (!taken.insert(id).second) corrupt(location, fmt::format("track {} is named twice", id));
  return id;
}

motion::Presence parse_away(const json& layer, std::size_t frames, const std::string& location) {
  if (!layer.contains("away")) return {};
  std::vector<motion::FrameSpan> spans;
  for (const json& span : array(layer, "away", location)) {
    if (!span.is_array() || span.size() != 2) corrupt(location, "\"away\" holds something else than pairs of frames");
    spans.push_back(
        {integer<std::uint32_t>(span[0], 0, "away", location), integer<std::uint32_t>(span[1], 0, "away", location)});
    if (spans.back().end > frames) corrupt(location, "a layer is away at a frame that the clip does not have");
  }
  try {
    return motion::Presence::away_during(std::move(spans));
  } catch (const Error& error) {
    corrupt(location, error.what());
  }
}

LayerDescription parse_layer(const json& object, std::set<std::uint16_t>& taken, std::size_t frames,
                             const std::string& location) {
  if (!object.is_object()) corrupt(location, "a layer is not an object");
  LayerDescription layer;
  const json& name = member(object, "name", location);
  if (!name.is_string()) corrupt(location, "a layer's name is not a text");
  layer.name = name.get<std::string>();
  if (layer.name.empty() || layer.name.size() > kLongestName) corrupt(location, "a layer's name is empty or too long");
  layer.label = integer<int>(member(object, "label", location), 0, "label", location);
  layer.field_track = track(object, "field_track", taken, location);
  const json& kind = member(object, "kind", location);
  using motion::MotionKind;
  const std::array kinds{MotionKind::kStill, MotionKind::kRigid, MotionKind::kDeforming};
  const auto* const known =
      std::find_if(kinds.begin(), kinds.end(), [&kind](MotionKind k) { return kind == motion::name_of(k); });
  if (known == kinds.end()) {
    corrupt(location, fmt::format("layer {} moves in a way that this Kinora does not know", layer.name));
  }
  layer.kind = *known;
  if (layer.kind != MotionKind::kStill) layer.motion_track = track(object, "motion_track", taken, location);
  if (object.contains("confidence_track")) layer.confidence_track = track(object, "confidence_track", taken, location);
  if (object.contains("joints_track")) {
    if (layer.kind != MotionKind::kDeforming)
      corrupt(location, fmt::format("layer {} has joints, but does not deform", layer.name));
    layer.joints_track = track(object, "joints_track", taken, location);
  }
  if (object.contains("births_track")) {
    if (layer.kind != MotionKind::kDeforming)
      corrupt(location, fmt::format("layer {} has births, but does not deform", layer.name));
    layer.births_track = track(object, "births_track", taken, location);
  }
  layer.presence = parse_away(object, frames, location);
  return layer;
}

void parse_frames(const json& root, ClipDescription& clip, const std::string& location) {
  for (const json& value : array(root, "times_ns", location)) {
    const auto time = integer<std::int64_t>(value, 0, "times_ns", location);
    if (!clip.times_ns.empty() && time <= clip.times_ns.back()) corrupt(location, "the frames' times do not increase");
    clip.times_ns.push_back(time);
  }
  if (clip.times_ns.empty()) corrupt(location, "the clip has no frame");
  for (const json& value : array(root, "capture_frames", location)) {
    clip.capture_frames.push_back(integer<int>(value, 0, "capture_frames", location));
  }
  if (clip.capture_frames.size() != clip.times_ns.size()) {
    corrupt(location,
            fmt::format("{} frames have {} numbers in the capture", clip.times_ns.size(), clip.capture_frames.size()));
  }
  clip.held_out.assign(clip.times_ns.size(), false);
  for (const json& value : array(root, "held_out", location)) {
    const auto frame = integer<std::uint32_t>(value, 0, "held_out", location);
    if (frame >= clip.held_out.size()) corrupt(location, "a frame was held out that the clip does not have");
    clip.held_out[frame] = true;
  }
}

} // namespace

Bytes to_json(const ClipDescription& clip) {
  json held_out = json::array();
  for (std::size_t i = 0; i < clip.held_out.size(); ++i) {
    if (clip.held_out[i]) held_out.push_back(i);
  }
  json layers = json::array();
  for (const LayerDescription& layer : clip.layers) {
    json entry = {{"name", layer.name},
                  {"label", layer.label},
                  {"kind", motion::name_of(layer.kind)},
                  {"field_track", layer.field_track}};
    if (layer.kind != motion::MotionKind::kStill) entry["motion_track"] = layer.motion_track;
    if (layer.confidence_track != 0) entry["confidence_track"] = layer.confidence_track;
    if (layer.joints_track != 0) entry["joints_track"] = layer.joints_track;
    if (layer.births_track != 0) entry["births_track"] = layer.births_track;
    for (const motion::FrameSpan& span : layer.presence.away()) entry["away"].push_back({span.begin, span.end});
    layers.push_back(std::move(entry));
  }
  return text_of({{"version", kVersion},
                  {"times_ns", clip.times_ns},
                  {"capture_frames", clip.capture_frames},
                  {"held_out", std::move(held_out)},
                  {"camera", {{"track", clip.camera_track}, {"moves", clip.camera_moves}}},
                  {"layers", std::move(layers)}},
                 -1);
}

Bytes to_json(const Intrinsics& intrinsics) {
  return text_of({{"version", kVersion},
                  {"width", intrinsics.width},
                  {"height", intrinsics.height},
                  {"fx", intrinsics.fx},
                  {"fy", intrinsics.fy},
                  {"cx", intrinsics.cx},
                  {"cy", intrinsics.cy}},
                 1);
}

Bytes to_json(const json& metadata) { return text_of(metadata, 1); }

ClipDescription parse_clip_description(std::span<const std::byte> text, const std::string& location) {
  const json root = parse_json(text, location);
  check_version(root, location);
  ClipDescription clip;
  parse_frames(root, clip, location);
  std::set<std::uint16_t> taken;
  const json& camera = member(root, "camera", location);
  if (!camera.is_object()) corrupt(location, "\"camera\" is not an object");
  clip.camera_track = track(camera, "track", taken, location);
  const json& moves = member(camera, "moves", location);
  if (!moves.is_boolean()) corrupt(location, "\"moves\" is neither true nor false");
  clip.camera_moves = moves.get<bool>();
  std::set<std::string> names;
  for (const json& object : array(root, "layers", location)) {
    clip.layers.push_back(parse_layer(object, taken, clip.times_ns.size(), location));
    if (!names.insert(clip.layers.back().name).second) {
      corrupt(location, fmt::format("two layers are named {}", clip.layers.back().name));
    }
    if (clip.layers.size() > kMaxLayers) corrupt(location, "there are more than 255 layers");
  }
  return clip;
}

Intrinsics parse_intrinsics(std::span<const std::byte> text, const std::string& location) {
  const json root = parse_json(text, location);
  check_version(root, location);
  Intrinsics intrinsics;
  intrinsics.width = integer<int>(member(root, "width", location), 1, "width", location);
  intrinsics.height = integer<int>(member(root, "height", location), 1, "height", location);
  intrinsics.fx = number(root, "fx", location);
  intrinsics.fy = number(root, "fy", location);
  intrinsics.cx = number(root, "cx", location);
  intrinsics.cy = number(root, "cy", location);
  intrinsics.validate(location);
  return intrinsics;
}

json parse_json(std::span<const std::byte> text, const std::string& location) {
  // Nested deeper, a text could exhaust the stack of whoever walks through it.
  const auto refuse_depth = [&location](int depth, json::parse_event_t /*event*/, json& /*parsed*/) {
    if (depth > kDeepestNesting) corrupt(location, "is nested too deeply");
    return true;
  };
  const auto* const first = reinterpret_cast<const char*>(text.data());
  try {
    return json::parse(first, first + text.size(), refuse_depth);
  } catch (const json::exception& error) {
    corrupt(location, fmt::format("is not JSON ({})", error.what()));
  }
}

} // namespace kinora::clip
