#include "clip/payloads/confidence_codec.h"

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "core/error.h"

namespace kinora::clip {
namespace {

using fields::Confidence;
using testing::random_confidence;
using testing::random_field;

constexpr const char* kLocation = "a.mkv: track 3";

Confidence decode(const Bytes& payload, const fields::Occupancy& occupancy) {
  AllocationBudget budget(payload.size());
  return decode_confidence(payload, occupancy, kLocation, budget);
}

void expect_corrupt(const Bytes& payload, const fields::Occupancy& occupancy) {
  try {
    decode(payload, occupancy);
    FAIL() << "decoded without an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_EQ(std::string(error.what()).rfind(kLocation, 0), 0U) << error.what();
  }
}

TEST(ConfidenceCodec, GivesBackEveryLevel) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const fields::Occupancy occupancy = random_field(seed).occupancy;
    const Confidence confidence = random_confidence(occupancy, seed);
    ASSERT_GT(confidence.levels().size(), 0U);
    EXPECT_EQ(decode(encode_confidence(confidence), occupancy).levels(), confidence.levels());
  }
}

TEST(ConfidenceCodec, NeedsAFewBytesForWhatWasNeverSeen) {
  fields::Occupancy all(64);
  std::fill(all.words().begin(), all.words().end(), ~std::uint64_t{0});
  const Confidence nothing(all);
  ASSERT_EQ(nothing.levels().size(), 16U * 16 * 16);
  EXPECT_LT(encode_confidence(nothing).size(), 100U);
}

TEST(ConfidenceCodec, HoldsAFieldThatFillsNothing) {
  const fields::Occupancy nothing(64);
  EXPECT_EQ(decode(encode_confidence(Confidence(nothing)), nothing).levels().size(), 0U);
}

TEST(ConfidenceCodec, RefusesWhatIsCutOrGoesOn) {
  const fields::Occupancy occupancy = random_field(1).occupancy;
  const Bytes payload = encode_confidence(random_confidence(occupancy, 1));
  // The last bytes may be zeros that a reader would add.
  for (std::size_t size = 0; size + 8 < payload.size(); size += 7) {
    expect_corrupt(Bytes(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size)), occupancy);
  }
  Bytes longer = payload;
  longer.resize(payload.size() + 9);
  expect_corrupt(longer, occupancy);
}

TEST(ConfidenceCodec, RefusesOtherVersions) {
  const fields::Occupancy occupancy = random_field(1).occupancy;
  Bytes payload = encode_confidence(random_confidence(occupancy, 1));
  payload[0] = std::byte{2};
  expect_corrupt(payload, occupancy);
}

TEST(ConfidenceCodec, RefusesMoreMemoryThanItMayTake) {
  const fields::Occupancy occupancy = random_field(1).occupancy;
  const Bytes payload = encode_confidence(random_confidence(occupancy, 1));
  AllocationBudget budget(0);
  ASSERT_TRUE(budget.try_take(std::uint64_t{256} << 20));
  EXPECT_THROW(decode_confidence(payload, occupancy, kLocation, budget), Error);
}

} // namespace
} // namespace kinora::clip
