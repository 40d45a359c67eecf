// Claims about a deformation graph in bytes.
#include "clip/payloads/graph_codec.h"

#include <gtest/gtest.h>

#include "clip/coding/node_quantiser.h"
#include "clip/sample_motion.h"
#include "container/little_endian.h"
#include "core/error.h"
#include "core/random.h"

namespace kinora::clip {
namespace {

using motion::DeformationGraph;

DeformationGraph graph_of(std::vector<Eigen::Vector3d> nodes) { return {std::move(nodes), 0.05, 0.1}; }

DeformationGraph scattered(std::uint64_t seed, std::size_t nodes) {
  Random random(seed);
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < nodes; ++i) positions.emplace_back(random.normal(), random.normal(), random.normal());
  if (nodes > 2) positions[2] = positions[0]; // two in one place
  return graph_of(std::move(positions));
}

/// Version 1, written by its table.
Bytes plain(const DeformationGraph& graph) {
  Bytes out;
  container::put(out, std::uint32_t{1});
  container::put(out, static_cast<std::uint32_t>(graph.nodes().size()));
  container::put(out, graph.weight_radius());
  container::put(out, graph.influence_radius());
  for (const Eigen::Vector3d& node : graph.nodes()) {
    for (const std::int32_t coordinate : quantise_rest(node)) container::put(out, coordinate);
  }
  return out;
}

void expect_same(const DeformationGraph& a, const DeformationGraph& b, double tolerance) {
  ASSERT_EQ(a.nodes().size(), b.nodes().size());
  EXPECT_EQ(a.weight_radius(), b.weight_radius());
  EXPECT_EQ(a.influence_radius(), b.influence_radius());
  for (std::size_t i = 0; i < a.nodes().size(); ++i)
    EXPECT_LE((a.nodes()[i] - b.nodes()[i]).cwiseAbs().maxCoeff(), tolerance) << i;
}

std::vector<DeformationGraph> hard_graphs() {
  const double far = 1024; // metres: as far as they may be
  return {scattered(1, 1), scattered(2, 2), scattered(3, 300),
          graph_of({{far, -far, 0}, {-far, far, 0}, {far, far, far}}),
          graph_of(std::vector(5, Eigen::Vector3d(0.1, 0.2, 0.3)))};
}

TEST(GraphCodec, KeepsNodesToHalfAMicrometre) {
  for (const DeformationGraph& graph : hard_graphs()) {
    // Half of 2⁻²⁰ m; a step more where two nodes are two kilometres apart.
    const double tolerance = graph.nodes()[0].x() > 1000 ? 1.5 / kRestUnits : 0.5 / kRestUnits;
    expect_same(*decode_graph(encode_graph(graph), "a.mkv"), graph, tolerance);
  }
}

TEST(GraphCodec, EncodesWhatItDecodedToTheSameBytes) {
  for (const DeformationGraph& graph : hard_graphs()) {
    const Bytes bytes = encode_graph(graph);
    EXPECT_EQ(encode_graph(*decode_graph(bytes, "a.mkv")), bytes);
  }
}

TEST(GraphCodec, TakesTwoThirdsOfVersionOneForAWalker) {
  testing::WalkerOptions options;
  options.frames = 1;
  const motion::Motion walker = testing::walker(options);
  EXPECT_LT(encode_graph(*walker.graph()).size(), 0.67 * static_cast<double>(plain(*walker.graph()).size()));
}

TEST(GraphCodec, ReadsVersionOne) {
  for (const DeformationGraph& graph : hard_graphs())
    expect_same(*decode_graph(plain(graph), "a.mkv"), graph, 0.5 / kRestUnits);
}

TEST(GraphCodec, RejectsGraphsOutsideTheirLimits) {
  for (const Bytes& good : {encode_graph(scattered(6, 5)), plain(scattered(6, 5))}) {
    const auto expect_corrupt = [&good](std::size_t at, const std::vector<int>& values) {
      Bytes bad = good;
      for (const int value : values) bad[at++] = static_cast<std::byte>(value);
      EXPECT_THROW(decode_graph(bad, "a.mkv"), Error) << "byte " << at;
    };
    expect_corrupt(0, {3});                             // version
    expect_corrupt(4, {0});                             // no node
    expect_corrupt(4, {60});                            // more than there are
    expect_corrupt(7, {0xFF});                          // far more
    expect_corrupt(8, {0, 0, 0, 0, 0, 0, 0, 0});        // a radius of zero
    expect_corrupt(8, {0, 0, 0, 0, 0, 0, 0xF8, 0x7F});  // not a number
    expect_corrupt(16, {0, 0, 0, 0, 0, 0, 0xF0, 0x7F}); // infinite
    EXPECT_THROW(decode_graph({}, "a.mkv"), Error);
    EXPECT_THROW(decode_graph(std::span(good).first(23), "a.mkv"), Error);
    Bytes longer = good;
    longer.resize(good.size() + 5);
    EXPECT_THROW(decode_graph(longer, "a.mkv"), Error);
  }
  Bytes far = plain(scattered(6, 5));
  EXPECT_THROW(decode_graph(std::span(far).first(far.size() - 1), "a.mkv"), Error);
  far[27] = std::byte{0x7F}; // a node beyond a kilometre
  EXPECT_THROW(decode_graph(far, "a.mkv"), Error);
}

TEST(GraphCodec, RefusesToStoreWhatIsTooFarOrTooLarge) {
  EXPECT_THROW(encode_graph(graph_of({{0, 0, 5000}})), Error);
  EXPECT_THROW(encode_graph(DeformationGraph({{0, 0, 0}}, 1e-9, 0.1)), Error);
  EXPECT_THROW(encode_graph(graph_of(std::vector(kMaxNodes + 1, Eigen::Vector3d(0, 0, 1)))), Error);
}

} // namespace
} // namespace kinora::clip
