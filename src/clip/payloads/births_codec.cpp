#include "clip/payloads/births_codec.h"

#include <array>

#include <fmt/format.h>

#include "clip/coding/node_quantiser.h"
#include "clip/coding/range_coder.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::put;

namespace {

constexpr std::uint8_t kVersion = 1;

/// A node is expected to be born with the nearest of those that come before it. Where those around it were not born
/// together, it is less sure.
template <class Coder>
void code_births(Coder& coder, const motion::DeformationGraph& graph, std::size_t frames, const std::string& location,
                 std::vector<std::uint32_t>& births) {
  const NodePredictor nodes(quantise_rest(graph.nodes()));
  std::array<IntegerModel, 2> models;
  for (const std::uint32_t node : nodes.order()) {
    const std::span<const std::uint32_t> neighbours = nodes.neighbours(node);
    const std::uint32_t expected = neighbours.empty() ? 0 : births[neighbours.front()];
    const bool is_sure = neighbours.empty() || births[neighbours.back()] == expected;
    const auto difference = static_cast<std::int32_t>(std::int64_t{births[node]} - expected);
    const std::int64_t birth = std::int64_t{expected} + code_integer(coder, models[is_sure ? 0 : 1], difference);
    if (birth < 0 || birth > static_cast<std::int64_t>(frames))
      throw Error(ErrorCode::kCorruptInput, fmt::format("{}: node {} is born outside of the clip", location, node));
    births[node] = static_cast<std::uint32_t>(birth);
  }
}

} // namespace

Bytes encode_births(const motion::NodeBirths& births, const motion::DeformationGraph& graph) {
  std::vector<std::uint32_t> frames = births.frames();
  if (births.are_at_the_start()) frames.resize(graph.nodes().size(), 0);
  if (frames.size() != graph.nodes().size())
    throw Error(ErrorCode::kFailure, "the births of a layer's nodes are not as many as these");
  RangeEncoder coder;
  code_births(coder, graph, std::size_t{1} << 30, "births", frames);
  Bytes out;
  put(out, kVersion);
  const Bytes coded = coder.finish();
  out.insert(out.end(), coded.begin(), coded.end());
  return out;
}

motion::NodeBirths decode_births(std::span<const std::byte> payload, const motion::DeformationGraph& graph,
                                 std::size_t frames, const std::string& location, AllocationBudget& budget) {
  if (payload.empty()) throw Error(ErrorCode::kCorruptInput, fmt::format("{}: births are too short", location));
  if (const auto version = get<std::uint8_t>(payload, 0); version != kVersion) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: births have version {}; this Kinora reads version {}", location, version, kVersion));
  }
  std::vector<std::uint32_t> births(graph.nodes().size());
  budget.take(births.size() * sizeof(std::uint32_t), location);
  RangeDecoder coder(payload.subspan(1), location);
  code_births(coder, graph, frames, location, births);
  coder.finish();
  return motion::NodeBirths(std::move(births));
}

} // namespace kinora::clip
