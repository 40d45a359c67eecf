#include "clip/exposure.h"

#include <gtest/gtest.h>

namespace kinora::clip {
namespace {

using Json = nlohmann::json;

const Exposure kSome = {{3, {{0.5F, 1, 2}}}, {7, {{2, 1, 0.5F}}}};

TEST(StoredExposure, IsWhatWasStored) {
  Json metadata;
  store_exposure(kSome, metadata);
  EXPECT_EQ(stored_exposure(metadata), kSome);
  EXPECT_TRUE(stored_exposure(Json::parse(metadata.dump())) == kSome);
}

TEST(StoredExposure, OfEvenFramesTakesNothing) {
  Json metadata = Json::object();
  store_exposure({}, metadata);
  EXPECT_TRUE(metadata.empty());
  EXPECT_TRUE(stored_exposure(metadata).empty());
}

TEST(StoredExposure, ThatCannotBeUnderstoodIsNone) {
  for (const char* text : {R"(7)", R"([])", R"({})", R"({"frames": 3})", R"({"frames": [1], "red": [1], "green": [1]})",
                           R"({"frames": [1], "red": [1, 2], "green": [1], "blue": [1]})",
                           R"({"frames": [1], "red": ["1"], "green": [1], "blue": [1]})",
                           R"({"frames": [1], "red": [0], "green": [1], "blue": [1]})",
                           R"({"frames": [1], "red": [-1], "green": [1], "blue": [1]})",
                           R"({"frames": [1], "red": [1e30], "green": [1], "blue": [1]})",
                           R"({"frames": ["a"], "red": [1], "green": [1], "blue": [1]})",
                           R"({"frames": {"a": 1}, "red": [1], "green": [1], "blue": [1]})"}) {
    EXPECT_TRUE(stored_exposure({{"exposure", Json::parse(text)}}).empty()) << text;
  }
}

TEST(GainAt, IsBetweenThoseThatAreKnownAndTheNearestBeyond) {
  EXPECT_EQ(gain_at({}, 5), ColorGain{});
  EXPECT_EQ(gain_at(kSome, 0), kSome.at(3));
  EXPECT_EQ(gain_at(kSome, 3), kSome.at(3));
  EXPECT_EQ(gain_at(kSome, 9), kSome.at(7));
  const ColorGain middle = gain_at(kSome, 5);
  for (const float factor : middle.factors) EXPECT_NEAR(factor, 1, 1e-6);
  EXPECT_NEAR(gain_at(kSome, 4).factors[2], std::sqrt(2.0F), 1e-5);
}

} // namespace
} // namespace kinora::clip
