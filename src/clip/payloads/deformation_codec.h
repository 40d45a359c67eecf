// The motion of a deforming layer as the payloads of a S_KINORA/MOTION track, and back. docs/container.md specifies
// them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "clip/coding/node_quantiser.h"
#include "clip/coding/zstd_codec.h"
#include "clip/payloads/deformation_rounding.h"
#include "clip/payloads/deformation_syntax.h"
#include "motion/motion.h"

namespace kinora::clip {

/// Every so many frames a payload is understood without those before it.
inline constexpr std::size_t kKeyInterval = 30;

/// Memory that a motion takes once it is decoded.
std::uint64_t decoding_memory(const motion::DeformationGraph& graph, std::size_t frames);

/// What writer and reader know after each payload, and the syntax of one, which is the same for both.
class DeformationCoding {
protected:
  explicit DeformationCoding(const motion::DeformationGraph& graph);
  /// `all_fine`: version 1 of payloads.
  template <class Coder>
  void code(Coder& coder, bool key, bool all_fine, std::vector<NodeState>& nodes, const std::string& location);

  std::vector<RestPosition> rest_;

private:
  NodePredictor predictor_;
  std::vector<NodeState> last_;
  std::vector<NodeTurn> turns_;
  std::vector<NodeSurprise> surprises_; // the last of each node
  DeformationModels models_;
};

/// Deformations, frame after frame, into payloads, rounded as DeformationRounding does. Not thread-safe.
class DeformationEncoder : DeformationCoding {
public:
  /// Throws Error(kFailure) if the graph cannot be stored.
  explicit DeformationEncoder(const motion::DeformationGraph& graph) : DeformationCoding(graph), rounding_(graph) {}

  struct Coded {
    bool key;
    Bytes bytes;
  };
  /// Throws Error(kFailure) if a transform is not rigid, or not finite, or carries its node too far away.
  Coded encode(const motion::Motion::Deformation& deformation);

private:
  DeformationRounding rounding_;
  std::size_t frame_ = 0;
};

/// The reverse, in the same order; it may begin at any key payload. Safe for untrusted input. Not thread-safe.
class DeformationDecoder : DeformationCoding {
public:
  explicit DeformationDecoder(const motion::DeformationGraph& graph) : DeformationCoding(graph) {}

  /// Throws Error(kCorruptInput) naming `location`; then nothing but a key payload may follow.
  motion::Motion::Deformation decode(std::span<const std::byte> payload, bool key, const std::string& location);

private:
  bool started_ = false;
};

} // namespace kinora::clip
