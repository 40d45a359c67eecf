// Clips that ask for as much memory as a file may: every layer has the largest table, all of it touched, and either the
// coarse levels of all fields come before the finer ones, or each field is one payload of the largest size in the
// oldest version that is read (3), whose parameters are unpacked whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "clip/clip_description.h"
#include "clip/codec_ids.h"
#include "clip/coding/zstd_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/field_header.h"
#include "clip/payloads/pose_codec.h"
#include "container/little_endian.h"
#include "container/writer.h"

namespace kinora::bench {

inline fields::Field largest_field() {
  fields::FieldConfig config;
  config.levels = fields::FieldLimits::kMaxLevels;
  config.log2_table_size = fields::FieldLimits::kMaxLog2TableSize;
  config.coarsest_resolution = 128; // no level has fewer entries than the largest
  config.finest_resolution = fields::FieldLimits::kMaxResolution;
  config.occupancy_resolution = fields::FieldLimits::kMaxOccupancyResolution;
  fields::Field field(config);
  for (std::uint64_t& word : field.occupancy.words()) word = ~std::uint64_t{0};
  return field;
}

/// `field` as version 3; noise among its parameters makes the payload as large as it may be.
inline clip::Bytes largest_packed_payload(const fields::Field& field) {
  constexpr std::ptrdiff_t kSizesAt = 48; // behind what version 5 begins with, too
  constexpr std::ptrdiff_t kLevelsAt = 56;
  clip::Bytes parameters(2 * field.parameter_count());
  std::mt19937 random(1);
  const std::size_t noise = clip::kMaxPayloadBytes - (std::size_t{64} << 10);
  for (std::size_t i = 0; i < noise; ++i) parameters[i] = static_cast<std::byte>(random());
  const clip::Bytes packed = clip::compress(parameters);
  const clip::Bytes occupancy = clip::compress(std::as_bytes(std::span(field.occupancy.words())));

  const clip::Bytes usual = clip::encode_field(field);
  clip::Bytes payload(usual.begin(), usual.begin() + kSizesAt);
  payload[0] = std::byte{clip::kZstdDensityVersion};
  container::put(payload, static_cast<std::uint32_t>(occupancy.size()));
  container::put(payload, static_cast<std::uint32_t>(packed.size()));
  payload.insert(payload.end(), usual.begin() + kLevelsAt, usual.begin() + kLevelsAt + 4 * field.config.levels);
  payload.insert(payload.end(), occupancy.begin(), occupancy.end());
  payload.insert(payload.end(), packed.begin(), packed.end());
  return payload;
}

/// An attachment that nobody asks for makes the file so large that its reader grants what it wants. `packed`: as
/// largest_packed_payload().
inline void write_largest_clip(const std::filesystem::path& path, std::size_t layers, bool packed) {
  const fields::Field field = largest_field();
  const std::vector<clip::Bytes> payloads =
      packed ? std::vector<clip::Bytes>{largest_packed_payload(field)}
             : clip::encode_field_coarse_first(field, clip::usual_rounding(field.config));
  clip::ClipDescription description;
  description.times_ns = {0};
  description.capture_frames = {0};
  description.held_out = {false};
  description.camera_track = 1;
  container::FileHead head;
  head.kind = clip::kClipKind;
  head.tracks.push_back({1, std::string(clip::kCameraCodec), "camera", {}});
  for (std::size_t l = 0; l < layers; ++l) {
    clip::LayerDescription layer;
    layer.name = "layer" + std::to_string(l);
    layer.field_track = static_cast<std::uint16_t>(2 + l);
    head.tracks.push_back({layer.field_track, std::string(clip::kFieldCodec), layer.name, {}});
    description.layers.push_back(layer);
  }
  const std::string json = "application/json";
  head.attachments.push_back({clip::kClipFile, json, "", clip::to_json(description)});
  head.attachments.push_back(
      {clip::kCalibrationFile, json, "", clip::to_json(Intrinsics{640, 480, 500, 500, 320, 240})});
  head.attachments.push_back({clip::kMetadataFile, json, "", clip::to_json(nlohmann::json::object())});
  const std::uint64_t wanted = layers * clip::decoding_memory(field.config);
  head.attachments.push_back({"padding", "application/octet-stream", "", clip::Bytes(wanted / 64)});
  container::Writer writer(path, head);
  writer.write(1, 0, true, clip::encode_pose({SE3::Identity(), motion::Health::kTracked}));
  for (std::size_t p = 0; p < payloads.size(); ++p) {
    for (std::size_t l = 0; l < layers; ++l) writer.write(static_cast<std::uint16_t>(2 + l), 0, p == 0, payloads[p]);
  }
  writer.finish();
}

} // namespace kinora::bench
