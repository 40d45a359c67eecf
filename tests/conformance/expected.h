// What the files of this folder decode to: bits that no later version, and no machine, may change.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "clip/clip.h"
#include "clip/coding/node_quantiser.h"
#include "container/crc32c.h"

namespace kinora::conformance {

/// Of table, density net, colour net as little-endian floats, and of a layer's motion as integers.
using Checksums = std::array<std::uint32_t, 4>;

template <class Values> std::uint32_t checksum_of(const Values& values) {
  return container::crc32c(std::as_bytes(std::span(values)));
}

/// Health, translation in micrometres and rotation matrix in units of 2⁻¹⁶.
inline std::vector<std::int32_t> numbers_of(const motion::Motion::Pose& pose) {
  std::vector<std::int32_t> numbers{static_cast<std::int32_t>(pose.health)};
  const auto put = [&numbers](double value, double units) {
    numbers.push_back(static_cast<std::int32_t>(std::floor(value * units + 0.5)));
  };
  for (int row = 0; row < 3; ++row) put(pose.canonical_to_world.translation()[row], 1e6);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) put(pose.canonical_to_world.linear()(row, column), 1 << 16);
  }
  return numbers;
}

/// Health and state of each node.
inline std::vector<std::int32_t> numbers_of(const motion::Motion::Deformation& deformation,
                                            const std::vector<clip::RestPosition>& rest) {
  std::vector<std::int32_t> numbers{static_cast<std::int32_t>(deformation.health)};
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const clip::NodeState state = clip::quantise(deformation.node_to_world[i], rest[i], clip::kFineSteps);
    numbers.insert(numbers.end(), state.position.begin(), state.position.end());
    numbers.insert(numbers.end(), state.rotation.begin(), state.rotation.end());
  }
  return numbers;
}

/// 0 of a layer that stands still.
inline std::uint32_t checksum_of_motion(const motion::Motion& motion) {
  std::vector<std::int32_t> numbers;
  const auto append = [&numbers](const std::vector<std::int32_t>& more) {
    numbers.insert(numbers.end(), more.begin(), more.end());
  };
  if (motion.kind() == motion::MotionKind::kStill) return 0;
  if (motion.kind() == motion::MotionKind::kRigid) {
    for (const motion::Motion::Pose& pose : motion.poses()) append(numbers_of(pose));
  } else {
    const std::vector<clip::RestPosition> rest = clip::quantise_rest(motion.graph()->nodes());
    for (const motion::Motion::Deformation& deformation : motion.deformations()) append(numbers_of(deformation, rest));
  }
  return checksum_of(numbers);
}

inline Checksums checksums(const clip::Layer& layer) {
  return {checksum_of(layer.field.table), checksum_of(layer.field.density_net), checksum_of(layer.field.color_net),
          checksum_of_motion(layer.motion)};
}

struct Expected {
  const char* file;
  const char* holds;
  std::size_t frames;
  std::array<Checksums, 3> layers;
  const char* away = "[[], [], []]";   ///< of each layer the spans of frames at which it is away, as JSON
  const char* births = "[[], [], []]"; ///< of each layer the frames at which its nodes are born, as JSON
};

/// The same of a layer.
inline nlohmann::json away_of(const clip::Layer& layer) {
  nlohmann::json spans = nlohmann::json::array();
  for (const motion::FrameSpan& span : layer.presence.away()) spans.push_back({span.begin, span.end});
  return spans;
}

inline constexpr std::array<Expected, 6> kExpected{
    {{"clip_fields_3_and_4.mkv",
      "fields of versions 3 and 4, a deformation of version 1",
      4,
      {{{0x713C3E6F, 0x9F46A76E, 0x62145567, 0},
        {0x8AD07818, 0x37BF03A1, 0x5BF0AF95, 0x307F1E22},
        {0xD7BE131F, 0xF1CFE6F4, 0x3176A5A6, 0xB70F9054}}}},
     {"clip_fields_5_deformation_2.mkv",
      "fields of version 5, a deformation of version 2 with two key payloads",
      33,
      {{{0xC9089161, 0x46C1D11D, 0x0BDBECF9, 0},
        {0x23B68E14, 0x7EEEC424, 0xA6EB23F8, 0x1CECBEDA},
        {0xAE3B0047, 0x53FF395F, 0xCCDB6F7D, 0x6242A567}}}},
     {"clip_fields_7.mkv",
      "the same clip with its fields in versions 7 and 8",
      33,
      {{{0xC9089161, 0x46C1D11D, 0x0BDBECF9, 0},
        {0x23B68E14, 0x7EEEC424, 0xA6EB23F8, 0x1CECBEDA},
        {0xAE3B0047, 0x53FF395F, 0xCCDB6F7D, 0x6242A567}}}},
     {"clip_corner_cases.mkv",
      "turns with equal, zero and negative largest components, places at the edge, a level of which all entries "
      "count as touched",
      33,
      {{{0x27F2D4EE, 0x9EF6EC58, 0x423C1C93, 0},
        {0xEED45E8D, 0xCAEEED0F, 0x12C219B7, 0x711547F7},
        {0xD9B6E2AB, 0x898A4C09, 0xE20CE61F, 0xBFFA9317}}}},
     {"clip_graph_2_poses_2.mkv",
      "the same clip with its graph and its poses in version 2",
      33,
      {{{0xC9089161, 0x46C1D11D, 0x0BDBECF9, 0},
        {0x23B68E14, 0x7EEEC424, 0xA6EB23F8, 0x1CECBEDA},
        {0xAE3B0047, 0x53FF395F, 0xCCDB6F7D, 0x6242A567}}}},
     {"clip_away.mkv",
      "layers that are away at times, and nodes that are born late or not at all",
      12,
      {{{0xF3BB3F2D, 0xB8A43ED7, 0xD3DBF2EA, 0},
        {0x2D2E7FC1, 0xD6EECC48, 0xA4B2D7CE, 0x976D45C3},
        {0xBCA9D0B6, 0x5B8AA68E, 0x66A048B1, 0x20C5D47B}}},
      "[[[1, 12]], [[0, 3], [4, 5], [8, 12]], []]",
      "[[], [], [0, 0, 0, 0, 0, 0, 0, 0, 5, 5, 5, 5, 5, 5, 5, 5, 12, 11, 10, 9, 8]]"}}};

} // namespace kinora::conformance
