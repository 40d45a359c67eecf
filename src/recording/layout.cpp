#include "recording/layout.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::recording {
namespace {

using Json = nlohmann::json;
using container::get;
using container::get_double;
using container::put;

constexpr std::uint8_t kRecordVersion = 1;
constexpr std::uint8_t kHasPose = 1;
constexpr std::uint8_t kHasHostTime = 2;
constexpr std::size_t kFixedBytes = 40;
constexpr std::size_t kPoseBytes = 16 * sizeof(double);
constexpr std::size_t kPartBytes = 8;
constexpr std::uint32_t kSoundPart = 5; // where parts say their stream

Json json_of(const KinoraCamera& camera) {
  return {{"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", std::vector<double>(std::begin(camera.distortion), std::end(camera.distortion))}};
}

KinoraCamera camera_from(const Json& json) {
  KinoraCamera camera{};
  json.at("width").get_to(camera.width);
  json.at("height").get_to(camera.height);
  json.at("fx").get_to(camera.fx);
  json.at("fy").get_to(camera.fy);
  json.at("cx").get_to(camera.cx);
  json.at("cy").get_to(camera.cy);
  const auto distortion = json.at("distortion").get<std::array<double, 5>>();
  std::copy(distortion.begin(), distortion.end(), camera.distortion);
  if (camera.width < 1 || camera.height < 1 || camera.width > 16384 || camera.height > 16384)
    throw std::invalid_argument("a picture must have 1 to 16384 pixels on a side");
  return camera;
}

Description description_from(const Json& json) {
  if (json.at("version").get<int>() != 1) throw std::invalid_argument("the version is unknown; install a newer Kinora");
  Description out;
  json.at("start_time").get_to(out.start_time);
  json.at("frames_per_second").get_to(out.frames_per_second);
  out.camera = camera_from(json.at("camera"));
  json.at("has_poses").get_to(out.has_poses);
  json.at("has_masks").get_to(out.has_masks);
  for (const Json& label : json.at("labels"))
    out.labels.push_back(
        {label.at("label").get<int>(), label.at("name").get<std::string>(), label.at("kind").get<std::string>()});
  if (json.contains("depth_camera")) {
    out.depth_camera = camera_from(json.at("depth_camera"));
    json.at("depth_to_color").get_to(out.depth_to_color);
  }
  json.at("source_format").get_to(out.source_format);
  return out;
}

} // namespace

const char* track_name(Stream stream) {
  constexpr const char* kNames[kStreams] = {"capture color", "capture depth", "capture infrared", "capture confidence",
                                            "capture labels"};
  return kNames[static_cast<std::size_t>(stream)];
}

Description description_of(const KinoraCaptureInfo& info, const std::string& source_format) {
  Description out;
  out.start_time = info.start_time;
  out.frames_per_second = info.frames_per_second;
  out.camera = info.camera;
  out.has_poses = info.has_poses != 0;
  out.has_masks = info.has_masks != 0;
  for (std::size_t i = 0; i < info.label_count; ++i)
    out.labels.push_back({info.labels[i].label, info.labels[i].name, info.labels[i].kind});
  if (info.has_depth_camera != 0) {
    out.depth_camera = info.depth_camera;
    std::copy(std::begin(info.depth_to_color), std::end(info.depth_to_color), out.depth_to_color.begin());
  }
  out.source_format = source_format;
  return out;
}

std::string to_json(const Description& description) {
  Json json = {{"version", 1},
               {"start_time", description.start_time},
               {"frames_per_second", description.frames_per_second},
               {"camera", json_of(description.camera)},
               {"has_poses", description.has_poses},
               {"has_masks", description.has_masks},
               {"labels", Json::array()},
               {"source_format", description.source_format}};
  for (const Label& label : description.labels)
    json["labels"].push_back({{"label", label.label}, {"name", label.name}, {"kind", label.kind}});
  if (description.depth_camera) {
    json["depth_camera"] = json_of(*description.depth_camera);
    json["depth_to_color"] = description.depth_to_color;
  }
  return json.dump(1) + "\n";
}

Description description_from_json(std::string_view text, const std::string& source) {
  try {
    return description_from(Json::parse(text));
  } catch (const std::exception& error) { // of the JSON library, which names no file
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: {} cannot be understood: {}", source, kDescriptionName, error.what()));
  }
}

container::Bytes encode_record(const FrameRecord& record) {
  container::Bytes out;
  put(out, kRecordVersion);
  put(out,
      static_cast<std::uint8_t>((record.camera_to_world ? kHasPose : 0) | (record.host_time_ns ? kHasHostTime : 0)));
  put(out, static_cast<std::uint16_t>(record.parts.size() + record.sound.size()));
  put(out, record.dropped_before);
  put(out, record.index);
  put(out, record.time);
  put(out, record.host_time_ns.value_or(0));
  put(out, record.depth_unit);
  if (record.camera_to_world)
    for (const double value : *record.camera_to_world) put(out, value);
  for (const Part& part : record.parts) {
    put(out, static_cast<std::uint32_t>(part.stream));
    put(out, part.checksum);
  }
  for (const std::uint32_t checksum : record.sound) {
    put(out, kSoundPart);
    put(out, checksum);
  }
  for (const char letter : record.problem) out.push_back(static_cast<std::byte>(letter));
  return out;
}

FrameRecord decode_record(std::span<const std::byte> bytes, const std::string& location) {
  const auto fail = [&location](const char* why) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: a frame's record {}", location, why));
  };
  if (bytes.size() < kFixedBytes) fail("is cut short");
  if (get<std::uint8_t>(bytes, 0) != kRecordVersion) fail("has an unknown version; install a newer Kinora");
  FrameRecord record;
  const auto flags = get<std::uint8_t>(bytes, 1);
  const std::size_t parts = get<std::uint16_t>(bytes, 2);
  record.dropped_before = get<std::uint32_t>(bytes, 4);
  record.index = get<std::int64_t>(bytes, 8);
  record.time = get_double(bytes, 16);
  if ((flags & kHasHostTime) != 0) record.host_time_ns = get<std::int64_t>(bytes, 24);
  record.depth_unit = get_double(bytes, 32);
  std::size_t at = kFixedBytes;
  const std::size_t needed = at + ((flags & kHasPose) != 0 ? kPoseBytes : 0) + parts * kPartBytes;
  if (bytes.size() < needed) fail("is cut short");
  if ((flags & kHasPose) != 0) {
    record.camera_to_world.emplace();
    for (double& value : *record.camera_to_world) {
      value = get_double(bytes, at);
      at += sizeof(double);
    }
  }
  for (std::size_t i = 0; i < parts; ++i, at += kPartBytes) {
    const auto stream = get<std::uint32_t>(bytes, at);
    if (stream < kStreams) record.parts.push_back({static_cast<Stream>(stream), get<std::uint32_t>(bytes, at + 4)});
    if (stream == kSoundPart) record.sound.push_back(get<std::uint32_t>(bytes, at + 4));
  }
  record.problem.assign(reinterpret_cast<const char*>(bytes.data()) + at, bytes.size() - at);
  if (!std::isfinite(record.time)) fail("has a time that is no number");
  return record;
}

} // namespace kinora::recording
