#include "clip/payloads/field_codec.h"

#include <gtest/gtest.h>

#include "clip/payloads/touched_entries.h"
#include "clip/sample_clip.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {
namespace {

using fields::Field;
using fields::FieldConfig;
using testing::random_field;

constexpr const char* kLocation = "a.mkv: byte 5";

Field decode(const Bytes& payload) {
  AllocationBudget budget(payload.size());
  return decode_field(payload, kLocation, budget);
}

void expect_corrupt(const Bytes& payload) {
  try {
    decode(payload);
    FAIL() << "decoded without an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_EQ(std::string(error.what()).rfind(kLocation, 0), 0U) << error.what();
  }
}

TEST(FieldCodec, KeepsConfigurationAndOccupancyExactly) {
  const Field field = random_field(1);
  const Field back = decode(encode_field(field));
  EXPECT_EQ(back.config.box.origin, field.config.box.origin);
  EXPECT_EQ(back.config.box.side, field.config.box.side);
  EXPECT_EQ(back.config.levels, field.config.levels);
  EXPECT_EQ(back.config.log2_table_size, field.config.log2_table_size);
  EXPECT_EQ(back.config.coarsest_resolution, field.config.coarsest_resolution);
  EXPECT_EQ(back.config.finest_resolution, field.config.finest_resolution);
  EXPECT_EQ(back.config.occupancy_resolution, field.config.occupancy_resolution);
  EXPECT_EQ(back.occupancy.words(), field.occupancy.words());
}

TEST(FieldCodec, KeepsTouchedParametersAndForgetsTheOthers) {
  const Field field = random_field(2);
  const Field back = decode(encode_field(field));
  const auto levels = fields::grid_levels(field.config);
  const auto touched = touched_entries(field.config, field.occupancy);
  std::vector<bool> is_touched(field.table.size() / FieldConfig::kFeatures);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    double error = 0;
    double power = 0;
    for (const std::uint32_t entry : touched[l]) {
      is_touched[levels[l].offset + entry] = true;
      for (std::size_t i = (levels[l].offset + entry) * FieldConfig::kFeatures, f = 0; f < FieldConfig::kFeatures;
           ++f, ++i) {
        error += std::pow(back.table[i] - field.table[i], 2);
        power += std::pow(field.table[i], 2);
      }
    }
    EXPECT_GT(power, 0);
    EXPECT_LT(std::sqrt(error / power), l < levels.size() / 2 ? 0.09 : 0.35) << l; // steps of 1/4 to 1/8, 1 to 1/2
  }
  for (std::size_t i = 0; i < field.table.size(); ++i) {
    if (!is_touched[i / FieldConfig::kFeatures]) {
      EXPECT_EQ(back.table[i], 0);
    }
  }
  for (std::size_t i = 0; i < field.density_net.size(); ++i) {
    EXPECT_NEAR(back.density_net[i], field.density_net[i], 0x1p-6);
  }
  for (std::size_t i = 0; i < field.color_net.size(); ++i) {
    EXPECT_NEAR(back.color_net[i], field.color_net[i], 0x1p-6);
  }
}

TEST(FieldCodec, GivesCoarseLevelsFirstAndInTheEndTheSameField) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Field whole = quantised(random_field(seed));
    const auto levels = fields::grid_levels(whole.config);
    const std::vector<Bytes> payloads = encode_field_coarse_first(random_field(seed), usual_rounding(whole.config));
    ASSERT_EQ(payloads.size(), 1 + levels.size() / 2);
    FieldDecoder decoder;
    for (std::size_t p = 0; p < payloads.size(); ++p) {
      AllocationBudget budget(payloads[p].size());
      EXPECT_FALSE(decoder.is_whole());
      decoder.take(payloads[p], kLocation, budget);
      const Field& field = *decoder.field();
      EXPECT_EQ(field.occupancy.words(), whole.occupancy.words());
      EXPECT_EQ(field.color_net, whole.color_net);
      const std::size_t there = levels.size() / 2 + p;
      const std::size_t end =
          (there == levels.size() ? whole.table.size() / FieldConfig::kFeatures : std::size_t{levels[there].offset}) *
          FieldConfig::kFeatures;
      EXPECT_TRUE(
          std::equal(field.table.begin(), field.table.begin() + static_cast<std::ptrdiff_t>(end), whole.table.begin()));
      EXPECT_TRUE(std::all_of(field.table.begin() + static_cast<std::ptrdiff_t>(end), field.table.end(),
                              [](float value) { return value == 0; }));
    }
    EXPECT_TRUE(decoder.is_whole());
  }
}

TEST(FieldCodec, RefusesLevelsThatDoNotFollowAndKeepsWhatItHas) {
  const std::vector<Bytes> payloads =
      encode_field_coarse_first(random_field(4), usual_rounding(testing::small_config()));
  const auto refuses = [](FieldDecoder& decoder, const Bytes& payload) {
    AllocationBudget budget(payload.size());
    try {
      decoder.take(payload, kLocation, budget);
      return false;
    } catch (const Error& error) {
      return error.code() == ErrorCode::kCorruptInput;
    }
  };
  FieldDecoder decoder;
  EXPECT_TRUE(refuses(decoder, payloads[1])); // before the field
  EXPECT_FALSE(refuses(decoder, payloads[0]));
  EXPECT_TRUE(refuses(decoder, payloads[0]));
  EXPECT_TRUE(refuses(decoder, payloads[2])); // before the level that it follows
  const auto coarse = decoder.field()->table;
  Bytes longer = payloads[1];
  longer.resize(longer.size() + 9);
  EXPECT_TRUE(refuses(decoder, longer));
  EXPECT_TRUE(refuses(decoder, Bytes(payloads[1].begin(), payloads[1].begin() + 3)));
  EXPECT_EQ(decoder.field()->table, coarse);
  EXPECT_FALSE(refuses(decoder, payloads[1]));
  EXPECT_TRUE(refuses(decoder, payloads[1]));
  EXPECT_FALSE(refuses(decoder, payloads[2]));
  EXPECT_TRUE(decoder.is_whole());
  expect_corrupt(payloads[0]); // which is not a whole field
}

TEST(FieldCodec, EncodesWhatItDecodedToTheSameBytes) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Bytes payload = encode_field(random_field(seed));
    EXPECT_EQ(encode_field(decode(payload)), payload) << seed;
    EXPECT_EQ(encode_field(quantised(random_field(seed))), payload) << seed;
  }
}

/// The same field after a bit more training.
Field trained_on(Field field, std::uint64_t seed) {
  Random random(seed, 4);
  for (float& value : field.table) {
    if (random.below(4) == 0) value *= 1.3F;
  }
  for (float& value : field.density_net) value += static_cast<float>(0.02 * random.normal());
  field.occupancy.set(1, 2, 3, !field.occupancy.at(1, 2, 3));
  return field;
}

TEST(FieldCodec, DifferenceGivesTheFieldItselfInFewerBytes) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Field base = quantised(random_field(seed));
    const Field field = trained_on(random_field(seed), seed);
    const Bytes difference = encode_field_difference(field, base);
    AllocationBudget budget(difference.size());
    const Field back = decode_field_difference(difference, base, kLocation, budget);
    const Field expected = quantised(field);
    EXPECT_EQ(back.table, expected.table) << seed;
    EXPECT_EQ(back.density_net, expected.density_net) << seed;
    EXPECT_EQ(back.color_net, expected.color_net) << seed;
    EXPECT_EQ(back.occupancy.words(), expected.occupancy.words()) << seed;
    EXPECT_EQ(back.sharpness, expected.sharpness) << seed;
    EXPECT_LT(difference.size(), encode_field(field).size() * 3 / 4) << seed;
  }
}

TEST(FieldCodec, DifferenceNeedsItsBase) {
  const Field base = quantised(random_field(2));
  const Bytes difference = encode_field_difference(base, base);
  EXPECT_LT(difference.size(), encode_field(base).size() / 20);
  expect_corrupt(difference);
  Field other(testing::small_config());
  other.config.box.side *= 2;
  EXPECT_THROW(encode_field_difference(base, other), Error);
  AllocationBudget budget(difference.size());
  EXPECT_THROW(decode_field_difference(difference, other, kLocation, budget), Error);
  EXPECT_THROW(decode_field_difference(encode_field(base), base, kLocation, budget), Error); // it is none
}

TEST(FieldCodec, KeepsGeometryAndSharpness) {
  EXPECT_EQ(decode(encode_field(random_field(2))).config.geometry, fields::Geometry::kDensity);
  const Field field = random_field(3);
  const Field back = decode(encode_field(field));
  EXPECT_EQ(back.config.geometry, fields::Geometry::kSignedDistance);
  EXPECT_NEAR(back.sharpness, field.sharpness, field.sharpness * 0x1p-11);
}

TEST(FieldCodec, RejectsASharpnessOutsideItsLimits) {
  Bytes payload = encode_field(random_field(1));
  for (const int high_byte : {0x4A, 0xCA, 0x7C, 0x7E}) { // 12, −12, infinity, not a number
    payload[14] = std::byte{0};
    payload[15] = static_cast<std::byte>(high_byte);
    expect_corrupt(payload);
  }
}

TEST(FieldCodec, StoresAnEmptyFieldInAFewKilobytes) {
  const Field field(testing::small_config());
  const Bytes payload = encode_field(field);
  EXPECT_LT(payload.size(), 1000U);
  EXPECT_EQ(decode(payload).table, field.table);
}

TEST(FieldCodec, RejectsPayloadsCutAnywhere) {
  const Bytes payload = encode_field(random_field(3));
  for (std::size_t size = 0; size < payload.size(); size += 1 + size / 50) {
    expect_corrupt(Bytes(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size)));
  }
}

TEST(FieldCodec, RejectsBytesBehindTheEnd) {
  Bytes payload = encode_field(random_field(3));
  payload.push_back(std::byte{0});
  expect_corrupt(payload);
}

TEST(FieldCodec, RejectsEveryHeaderOutsideItsLimits) {
  const Bytes good = encode_field(random_field(4));
  const auto with = [&good](std::size_t at, std::initializer_list<int> values) {
    Bytes bad = good;
    std::size_t i = at;
    for (const int v : values) bad[i++] = static_cast<std::byte>(v);
    return bad;
  };
  expect_corrupt(with(0, {1}));           // version
  expect_corrupt(with(0, {6}));           // version
  expect_corrupt(with(1, {0}));           // levels
  expect_corrupt(with(1, {255}));         // levels
  expect_corrupt(with(2, {31}));          // table size
  expect_corrupt(with(3, {4}));           // features
  expect_corrupt(with(4, {0, 0}));        // coarsest resolution
  expect_corrupt(with(6, {255, 255}));    // finest resolution
  expect_corrupt(with(8, {0, 128}));      // occupancy resolution
  expect_corrupt(with(10, {32}));         // hidden width
  expect_corrupt(with(23, {0x7F, 0xF8})); // a box that is not a number
  expect_corrupt(with(46, {0xF8, 0x7F})); // a side that is not a number
  expect_corrupt(with(48, {2}));          // geometry
  expect_corrupt(with(49, {127}));        // exponent of a matrix
  expect_corrupt(with(56, {200}));        // resolution of a level
  expect_corrupt(with(58, {127}));        // exponent of a level
}

// The announced size of the occupancy must be that of its resolution: a bomb is refused before it is unpacked.
TEST(FieldCodec, RefusesCompressedDataThatAnnouncesAnotherSize) {
  const Bytes bomb = compress(Bytes(100'000'000));
  EXPECT_THROW(decompress(bomb, 1000, kLocation), Error);
  EXPECT_THROW(decompress(bomb, 100'000'001, kLocation), Error);
  EXPECT_THROW(decompress({}, 0, kLocation), Error);
}

TEST(FieldCodec, RefusesToAllocateMoreThanTheBudget) {
  FieldConfig config = testing::small_config();
  config.log2_table_size = 20;
  config.finest_resolution = 8192;
  config.coarsest_resolution = 128;
  config.levels = 8;
  const Bytes payload = encode_field(Field(config));
  EXPECT_LT(payload.size(), 1000U);
  expect_corrupt(payload);
}

TEST(FieldCodec, RefusesToStoreWhatIsNotFinite) {
  Field field = random_field(6);
  field.color_net[3] = std::nanf("");
  EXPECT_THROW(encode_field(field), Error);
  field = random_field(6);
  for (float& v : field.table) v = INFINITY;
  EXPECT_THROW(encode_field(field), Error);
}

TEST(FieldCodec, RefusesToStoreParametersThatDoNotFitTheConfiguration) {
  Field field = random_field(7);
  field.table.pop_back();
  EXPECT_THROW(encode_field(field), Error);
}

} // namespace
} // namespace kinora::clip
