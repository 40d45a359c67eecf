#include "clip/payloads/confidence_codec.h"

#include <algorithm>
#include <bit>

#include "clip/coding/range_coder.h"
#include "container/little_endian.h"

namespace kinora::clip {

using fields::Confidence;

namespace {

constexpr std::uint8_t kVersion = 1;

/// The blocks beside a block that come before it: one along each axis, at most.
class BlocksBefore {
public:
  BlocksBefore(const Confidence& confidence, std::size_t cell) {
    const auto side = static_cast<std::size_t>(confidence.blocks().resolution());
    const int x = static_cast<int>(cell % side);
    const int y = static_cast<int>(cell / side % side);
    const int z = static_cast<int>(cell / (side * side));
    for (const int block :
         {confidence.block_at(x - 1, y, z), confidence.block_at(x, y - 1, z), confidence.block_at(x, y, z - 1)}) {
      if (block >= 0) known_[count_++] = &confidence.levels()[static_cast<std::size_t>(block)];
    }
  }
  /// Mean of their levels, rounded down; 0 without any.
  int mean(std::size_t normal) const {
    int sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += (*known_[i])[normal];
    return sum / std::max(static_cast<int>(count_), 1);
  }

private:
  std::array<const Confidence::Levels*, 3> known_{};
  std::size_t count_ = 0;
};

// Writes or reads all levels.
template <class Coder> void code_levels(Coder& coder, Confidence& confidence, const std::string& location) {
  std::array<IntegerModel, Confidence::kMax + 1> models; // by what is expected
  const std::vector<std::uint64_t>& words = confidence.blocks().words();
  std::size_t block = 0;
  for (std::size_t w = 0; w < words.size(); ++w) {
    for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1, ++block) {
      const BlocksBefore before(confidence, w * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
      for (std::size_t n = 0; n < Confidence::kNormals; ++n) {
        std::uint8_t& level = confidence.levels()[block][n];
        const int expected = before.mean(n);
        const auto found =
            std::int64_t{expected} + code_integer(coder, models[static_cast<std::size_t>(expected)], level - expected);
        if (found < 0 || found > Confidence::kMax) {
          throw Error(ErrorCode::kCorruptInput, fmt::format("{}: a level of confidence is out of range", location));
        }
        level = static_cast<std::uint8_t>(found);
      }
    }
  }
}

std::uint64_t memory_of(const fields::Occupancy& blocks) {
  return blocks.count() * Confidence::kNormals +
         blocks.words().size() * (sizeof(std::uint64_t) + sizeof(std::uint32_t));
}

} // namespace

Bytes encode_confidence(const Confidence& confidence) {
  Bytes out;
  container::put(out, kVersion);
  RangeEncoder encoder;
  Confidence written = confidence; // one syntax for both directions
  code_levels(encoder, written, "a clip to be written");
  const Bytes code = encoder.finish();
  out.insert(out.end(), code.begin(), code.end());
  return out;
}

Confidence decode_confidence(std::span<const std::byte> payload, const fields::Occupancy& occupancy,
                             const std::string& location, AllocationBudget& budget) {
  if (payload.empty() || container::get<std::uint8_t>(payload, 0) != kVersion) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: confidence has no version that this Kinora reads ({})", location, kVersion));
  }
  budget.take(memory_of(coarsened(occupancy, Confidence::kBlock)), location);
  Confidence confidence(occupancy);
  RangeDecoder decoder(payload.subspan(1), location);
  code_levels(decoder, confidence, location);
  decoder.finish();
  return confidence;
}

std::uint64_t decoding_memory(const Confidence& confidence) { return memory_of(confidence.blocks()); }

} // namespace kinora::clip
