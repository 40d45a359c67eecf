#include "clip/payloads/deformation_codec.h"

#include <algorithm>

#include <fmt/format.h>

#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::put;
using motion::DeformationGraph;
using motion::Motion;

namespace {

constexpr std::uint8_t kAllFineVersion = 1;
constexpr std::uint8_t kPayloadVersion = 2;
constexpr std::size_t kPayloadHeaderBytes = 2;

[[noreturn]] void reject(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

bool is_valid(const NodeState& node) {
  const auto is_near = [](std::int32_t coordinate) {
    return coordinate >= -kFarthestLive && coordinate <= kFarthestLive;
  };
  const auto is_component = [](std::int32_t component) {
    return component >= -kQuaternionUnits && component <= kQuaternionUnits;
  };
  return std::all_of(node.position.begin(), node.position.end(), is_near) &&
         std::all_of(node.rotation.begin(), node.rotation.end(), is_component) &&
         node.rotation[largest_component(node.rotation)] == kQuaternionUnits;
}

} // namespace

std::uint64_t decoding_memory(const DeformationGraph& graph, std::size_t frames) {
  return std::uint64_t{frames} * (sizeof(Motion::Deformation) + graph.nodes().size() * sizeof(DualQuaternion));
}

DeformationCoding::DeformationCoding(const DeformationGraph& graph)
    : rest_(quantise_rest(graph.nodes())), predictor_(rest_), turns_(rest_.size()) {}

template <class Coder>
void DeformationCoding::code(Coder& coder, bool key, bool all_fine, std::vector<NodeState>& nodes,
                             const std::string& location) {
  if (key) {
    models_ = {};
    surprises_.assign(rest_.size(), {});
  }
  const std::vector<NodeState>& reference = key ? predictor_.rest() : last_;
  NodeSyntax<Coder> syntax(coder, models_, all_fine);
  for (const std::uint32_t i : predictor_.order()) {
    const NodeSurprise activity = activity_around(predictor_.neighbours(i), i, surprises_);
    surprises_[i] = syntax.code(predictor_.predict(i, reference, nodes, turns_), activity, nodes[i]);
    if (!is_valid(nodes[i])) reject(location, fmt::format("node {} is turned or moved impossibly", i));
    turns_[i] = NodeTurn(reference[i], nodes[i]);
  }
  last_ = nodes;
}

DeformationEncoder::Coded DeformationEncoder::encode(const Motion::Deformation& deformation) {
  const bool key = frame_++ % kKeyInterval == 0;
  std::vector<NodeState> nodes = rounding_.rounded(deformation.node_to_world, rest_);
  Bytes out;
  put(out, kPayloadVersion);
  put(out, static_cast<std::uint8_t>(deformation.health));
  RangeEncoder coder;
  code(coder, key, false, nodes, "a deformation");
  const Bytes coded = coder.finish();
  out.insert(out.end(), coded.begin(), coded.end());
  return {key, std::move(out)};
}

Motion::Deformation DeformationDecoder::decode(std::span<const std::byte> payload, bool key,
                                               const std::string& location) {
  if (payload.size() < kPayloadHeaderBytes) reject(location, "a deformation is too short");
  const auto version = get<std::uint8_t>(payload, 0);
  if (version != kAllFineVersion && version != kPayloadVersion) {
    reject(location, fmt::format("a deformation has version {}; this Kinora reads versions {} and {}", version,
                                 kAllFineVersion, kPayloadVersion));
  }
  const auto health = get<std::uint8_t>(payload, 1);
  if (health > static_cast<std::uint8_t>(motion::Health::kLost)) {
    reject(location, "a deformation is neither tracked nor held nor lost");
  }
  if (!key && !started_) reject(location, "a deformation without an earlier one to which it refers");
  RangeDecoder coder(payload.subspan(kPayloadHeaderBytes), location);
  std::vector<NodeState> nodes(rest_.size());
  code(coder, key, version == kAllFineVersion, nodes, location);
  coder.finish();
  started_ = true;
  Motion::Deformation deformation;
  deformation.health = static_cast<motion::Health>(health);
  deformation.node_to_world.reserve(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) deformation.node_to_world.push_back(dequantise(nodes[i], rest_[i]));
  return deformation;
}

} // namespace kinora::clip
