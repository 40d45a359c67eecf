// Made clip_corner_cases.mkv, what ordinary clips hardly ever meet, and clip_away.mkv. Files of the corpus stay as they
// were once written, so this shows what is in them, and how to make the next. usage: corner_cases corner_cases|away
// OUT.mkv
#include <array>
#include <cstdio>
#include <memory>
#include <string_view>
#include <vector>

#include "clip/clip_io.h"
#include "clip/coding/node_quantiser.h"
#include "clip/sample_clip.h"

using namespace kinora;

namespace {

constexpr std::size_t kNodes = 9;
constexpr std::size_t kFrames = 33; // two key payloads

// So many cells of a low slab that all entries count as touched, also those of vertices far above it.
fields::Field slab() {
  fields::FieldConfig config;
  config.levels = 2;
  config.log2_table_size = 8;
  config.coarsest_resolution = 3;
  config.finest_resolution = 5;
  config.occupancy_resolution = 256;
  fields::Field field(config);
  for (int z = 0; z < 40; ++z) {
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 256; ++x) field.occupancy.set(x, y, z);
    }
  }
  Random random(1);
  for (auto* values : {&field.density_net, &field.color_net}) {
    for (float& value : *values) value = static_cast<float>(random.below(65)) / 64 - 0.5F;
  }
  for (float& value : field.table) value = static_cast<float>(random.below(65)) / 64 - 0.5F;
  return field;
}

// Quarter and half turns, of which components are equal in size, or nothing, of either sign; of every third node
// others.
std::array<std::int32_t, 4> rotation(std::size_t node, Random& random) {
  std::array<std::int32_t, 4> q{};
  const std::size_t largest = random.below(4);
  q[largest] = clip::kQuaternionUnits;
  for (std::size_t c = 0; c < 4; ++c) {
    if (c == largest) continue;
    q[c] = node % 3 == 2 ? static_cast<std::int32_t>(random.below(4095)) - 2047
                         : (static_cast<std::int32_t>(random.below(3)) - 1) * clip::kQuaternionUnits;
  }
  const std::size_t first = clip::largest_component(q);
  if (q[first] < 0) {
    for (std::int32_t& component : q) component = -component;
  }
  return q;
}

// The last node wanders at the edge of where nodes may be.
std::int32_t coordinate(std::size_t node, Random& random) {
  const auto offset = static_cast<std::int32_t>(random.below(20000));
  if (node + 1 < kNodes) return offset - 10000;
  return (random.below(2) == 0 ? 1 : -1) * (clip::kFarthestLive - offset);
}

motion::Motion tumbling() {
  Random random(2);
  std::vector<Eigen::Vector3d> nodes; // on a lattice: many are equally near
  for (std::size_t i = 0; i < kNodes; ++i) {
    const std::size_t row = i / 3;
    nodes.emplace_back(0.0625 * static_cast<double>(i % 3), 0.0625 * static_cast<double>(row), 1);
  }
  const std::vector<clip::RestPosition> rest = clip::quantise_rest(nodes);
  std::vector<motion::Motion::Deformation> deformations(kFrames);
  for (motion::Motion::Deformation& deformation : deformations) {
    for (std::size_t i = 0; i < kNodes; ++i) {
      clip::NodeState state;
      for (std::int32_t& number : state.position) number = coordinate(i, random);
      state.rotation = rotation(i, random);
      deformation.node_to_world.push_back(clip::dequantise(state, rest[i]));
    }
    deformation.health = static_cast<motion::Health>(random.below(3));
  }
  return motion::Motion::deforming(std::make_shared<const motion::DeformationGraph>(nodes, 0.05, 0.1), deformations);
}

clip::Clip corner_cases() {
  fields::FieldConfig small = clip::testing::small_config();
  small.levels = 2;
  small.log2_table_size = 4;
  small.finest_resolution = 12;
  clip::Clip clip = clip::testing::sample_clip(1, kFrames, false);
  clip.layers[0].field = slab();
  clip.layers[0].confidence.reset();
  clip.layers[1].field = clip::testing::random_field(1, small);
  clip.layers.push_back({"person", 1, clip::testing::random_field(2, small), tumbling()});
  return clip;
}

// Layers that begin and end: one that is there in the first frame and then no more, one of every kind of span.
clip::Clip away() {
  clip::Clip clip = clip::testing::bending_clip(1, 12, true);
  clip.layers[0].presence = motion::Presence::away_during({{1, 12}});
  clip.layers[1].presence = motion::Presence::away_during({{0, 3}, {4, 5}, {8, 12}});
  std::vector<std::uint32_t> births(clip.layers[2].motion.graph()->nodes().size());
  for (std::size_t n = 0; n < births.size(); ++n)
    births[n] = static_cast<std::uint32_t>(n < 8 ? 0 : n < 16 ? 5 : 28 - n); // 12: not born
  clip.layers[2].births = motion::NodeBirths(std::move(births));
  return clip;
}

} // namespace

int main(int argc, char** argv) {
  const std::string_view which = argc == 3 ? argv[1] : "";
  if (which != "corner_cases" && which != "away") {
    std::fprintf(stderr, "usage: corner_cases corner_cases|away OUT.mkv\n");
    return 2;
  }
  try {
    clip::write_clip(which == "away" ? away() : corner_cases(), argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "corner_cases: %s\n", error.what());
    return 1;
  }
  return 0;
}
