#include "clip/payloads/graph_codec.h"

#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

#include "clip/coding/node_quantiser.h"
#include "clip/coding/range_coder.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::get_double;
using container::put;
using motion::DeformationGraph;

namespace {

constexpr std::uint8_t kPlainVersion = 1;
constexpr std::uint8_t kVersion = 2;
constexpr std::size_t kHeaderBytes = 24;
constexpr std::size_t kPlainNodeBytes = 12;
constexpr double kSmallestRadius = 1e-4; // metres
constexpr double kLargestRadius = 1e3;

using Nodes = std::vector<RestPosition>;

[[noreturn]] void reject(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

bool is_radius(double metres) { return metres >= kSmallestRadius && metres <= kLargestRadius; }

bool is_near(std::int64_t coordinate) { return coordinate >= -kFarthestRest && coordinate <= kFarthestRest; }

/// The nearest of the nodes before `i`, of equally near ones the last.
std::size_t nearest_before(const Nodes& nodes, std::size_t i) {
  std::size_t nearest = 0;
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t k = 0; k < i; ++k) {
    const std::uint64_t distance = squared_distance(nodes[k], nodes[i]);
    if (distance > least) continue;
    least = distance;
    nearest = k;
  }
  return nearest;
}

/// Each node as its difference to one before it. `start_of` says which one, to a writer.
template <class Coder, class StartOf>
void code(Coder& coder, Nodes& nodes, const StartOf& start_of, const std::string& location) {
  IntegerModel back_model;
  std::array<IntegerModel, 3> models;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    RestPosition start{};
    if (i > 0) {
      const std::int32_t back = code_integer(coder, back_model, static_cast<std::int32_t>(i - 1 - start_of(i)));
      if (back < 0 || static_cast<std::size_t>(back) >= i) reject(location, "a node of a graph lies beside none");
      start = nodes[i - 1 - static_cast<std::size_t>(back)];
    }
    for (std::size_t a = 0; a < 3; ++a) {
      constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max(); // a micrometre less than from end to end
      const std::int64_t difference = std::clamp(std::int64_t{nodes[i][a]} - start[a], -kMost, kMost);
      const std::int64_t coordinate =
          start[a] + std::int64_t{code_integer(coder, models[a], static_cast<std::int32_t>(difference))};
      if (!is_near(coordinate)) reject(location, "a node of a graph is too far away");
      nodes[i][a] = static_cast<std::int32_t>(coordinate);
    }
  }
}

Nodes decode_nodes(std::span<const std::byte> bytes, std::size_t count, const std::string& location) {
  Nodes nodes(count);
  RangeDecoder coder(bytes, location);
  code(
      coder, nodes, [](std::size_t) { return 0; }, location);
  coder.finish();
  return nodes;
}

Nodes plain_nodes(std::span<const std::byte> bytes, std::size_t count, const std::string& location) {
  if (bytes.size() != kPlainNodeBytes * count)
    reject(location, fmt::format("{} bytes are no graph of {} nodes", bytes.size(), count));
  Nodes nodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      nodes[i][a] = get<std::int32_t>(bytes, kPlainNodeBytes * i + 4 * a);
      if (!is_near(nodes[i][a])) reject(location, "a node of a graph is too far away");
    }
  }
  return nodes;
}

} // namespace

Bytes encode_graph(const DeformationGraph& graph) {
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorCode::kFailure, fmt::format("a deformation graph cannot be stored: {}", why));
  };
  if (graph.nodes().size() > kMaxNodes) {
    refuse(fmt::format("it has {} nodes, and {} are the most", graph.nodes().size(), kMaxNodes));
  }
  if (!is_radius(graph.weight_radius()) || !is_radius(graph.influence_radius())) {
    refuse(fmt::format("its radii are {} m and {} m", graph.weight_radius(), graph.influence_radius()));
  }
  Nodes nodes = quantise_rest(graph.nodes());
  Bytes out;
  put(out, kVersion);
  put(out, std::uint8_t{0});
  put(out, std::uint16_t{0});
  put(out, static_cast<std::uint32_t>(nodes.size()));
  put(out, graph.weight_radius());
  put(out, graph.influence_radius());
  RangeEncoder coder;
  code(
      coder, nodes, [&nodes](std::size_t i) { return nearest_before(nodes, i); }, "a graph");
  const Bytes coded = coder.finish();
  out.insert(out.end(), coded.begin(), coded.end());
  return out;
}

std::shared_ptr<const DeformationGraph> decode_graph(std::span<const std::byte> private_data,
                                                     const std::string& location) {
  if (private_data.size() < kHeaderBytes) reject(location, "the private data of a deforming layer has no graph");
  const auto version = get<std::uint8_t>(private_data, 0);
  if (version != kPlainVersion && version != kVersion) {
    reject(location, fmt::format("a graph has version {}; this Kinora reads versions {} and {}", version, kPlainVersion,
                                 kVersion));
  }
  const auto count = get<std::uint32_t>(private_data, 4);
  if (count == 0 || count > kMaxNodes) reject(location, fmt::format("a graph of {} nodes", count));
  const double weight_radius = get_double(private_data, 8);
  const double influence_radius = get_double(private_data, 16);
  if (!is_radius(weight_radius) || !is_radius(influence_radius))
    reject(location, "a radius of a graph is out of range");
  const auto bytes = private_data.subspan(kHeaderBytes);
  std::vector<Eigen::Vector3d> nodes;
  for (const RestPosition& rest :
       version == kPlainVersion ? plain_nodes(bytes, count, location) : decode_nodes(bytes, count, location)) {
    nodes.push_back(dequantise(rest));
  }
  return std::make_shared<const DeformationGraph>(std::move(nodes), weight_radius, influence_radius);
}

} // namespace kinora::clip
