#include "clip/coding/range_coder.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace kinora::clip {
namespace {

std::vector<std::int32_t> normal_integers(std::uint64_t seed, std::size_t count, double deviation) {
  Random random(seed);
  std::vector<std::int32_t> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(static_cast<std::int32_t>(std::lrint(random.normal() * deviation)));
  }
  return values;
}

std::vector<std::byte> encode(const std::vector<std::int32_t>& values) {
  RangeEncoder encoder;
  IntegerModel model;
  for (const std::int32_t value : values) EXPECT_EQ(code_integer(encoder, model, value), value);
  return encoder.finish();
}

std::vector<std::int32_t> decode(const std::vector<std::byte>& code, std::size_t count) {
  const std::string location = "a.mkv";
  RangeDecoder decoder(code, location);
  IntegerModel model;
  std::vector<std::int32_t> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(code_integer(decoder, model));
  decoder.finish();
  return values;
}

std::string hex(const std::vector<std::byte>& bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += fmt::format("{:02x}", std::to_integer<int>(byte));
  return text;
}

TEST(RangeCoder, GivesBackEveryInteger) {
  std::vector<std::vector<std::int32_t>> cases{{}, {0}, {1}, {-1}, {INT32_MAX, -INT32_MAX, 0, 1, INT32_MAX}};
  cases.emplace_back(5000, 0);
  for (int bit = 0; bit < 31; ++bit) cases.push_back({1 << bit, -(1 << bit), (1 << bit) - 1, 0});
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    cases.push_back(normal_integers(seed, 1 + seed * 13, std::exp2(static_cast<double>(seed) / 2)));
  }
  for (const auto& values : cases) EXPECT_EQ(decode(encode(values), values.size()), values);
}

TEST(RangeCoder, ComesWithinASeventhOfABitOfTheEntropy) {
  for (const double deviation : {2.0, 5.0, 20.0}) {
    constexpr std::size_t kCount = 20000;
    const double entropy = std::log2(deviation * std::sqrt(2 * std::acos(-1.0) * std::exp(1.0)));
    const double bits = 8.0 * static_cast<double>(encode(normal_integers(1, kCount, deviation)).size()) / kCount;
    EXPECT_NEAR(bits, entropy, 1.0 / 7) << "standard deviation " << deviation;
  }
}

TEST(RangeCoder, NeedsNextToNothingForWhatNeverChanges) {
  EXPECT_LT(encode(std::vector<std::int32_t>(10000, 0)).size(), 60U);
}

TEST(RangeCoder, NoticesACodeThatEndsTooEarlyOrTooLate) {
  const auto values = normal_integers(2, 500, 10);
  std::vector<std::byte> code = encode(values);
  code.resize(code.size() + 8);
  EXPECT_THROW(decode(code, values.size()), Error);
  code.resize(code.size() / 2);
  EXPECT_THROW(decode(code, values.size()), Error);
}

// What files hold that exist: a model that learns otherwise reads none of them.
TEST(RangeCoder, WritesTheBytesOfFilesThatExist) {
  std::vector<std::int32_t> values(96);
  for (int i = 0; i < 96; ++i) values[static_cast<std::size_t>(i)] = (i * i) % 23 - 11 + (i % 7 == 0 ? 40 : 0);
  EXPECT_EQ(hex(encode(values)),
            "c24a53046c4bd1703a980089796690355ebf78a699acadeca54a7c1023939bd88878c01825aac9822b0003a30ee83d0d"
            "44c7f59e7fb891eceef9733b8170c3640e");
  BitModel model;
  std::string probabilities;
  for (int i = 0; i < 48; ++i) {
    model.learn(i % 5 != 0);
    if (i % 8 == 7) probabilities += std::to_string(model.probability()) + " ";
  }
  EXPECT_EQ(probabilities, "2957 3011 3194 3165 3260 3225 ");
}

} // namespace
} // namespace kinora::clip
