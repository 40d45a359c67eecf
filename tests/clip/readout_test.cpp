#include "clip/readout.h"

#include <gtest/gtest.h>

namespace kinora::clip {
namespace {

using Json = nlohmann::json;

TEST(StoredReadout, IsWhatWasStored) {
  for (const double seconds : {0.0271, -0.0093}) {
    Json metadata;
    store_readout(seconds, metadata);
    EXPECT_EQ(stored_readout(Json::parse(metadata.dump())), seconds);
  }
}

TEST(StoredReadout, OfRowsThatAreReadAtOnceTakesNothing) {
  Json metadata = Json::object();
  store_readout(0, metadata);
  EXPECT_TRUE(metadata.empty());
  EXPECT_EQ(stored_readout(metadata), 0);
}

TEST(StoredReadout, ThatCannotBeUnderstoodIsNone) {
  for (const char* text : {"7", "[]", "{}", R"({"readout_s": "0.02"})", R"({"readout_s": [0.02]})",
                           R"({"readout_s": 1e300})", R"({"readout_s": null})"}) {
    EXPECT_EQ(stored_readout({{"rolling_shutter", Json::parse(text)}}), 0) << text;
  }
}

TEST(ReadoutOfFrames, IsHowTheCameraMovesMeanwhile) {
  Clip clip;
  const Twist velocity = (Twist() << 0.1, 0.2, -0.1, 0.3, 0.5, -0.2).finished();
  for (int f = 0; f < 5; ++f) {
    clip.times.push_back(0.04 * f);
    clip.camera_to_world.push_back(exp_se3(0.04 * f * velocity));
  }
  EXPECT_TRUE(readout_of_frames(clip).empty()) << "nothing is said of it";
  store_readout(0.02, clip.metadata);
  const std::vector<Twist> readout = readout_of_frames(clip);
  ASSERT_EQ(readout.size(), 5U);
  for (const Twist& twist : readout) EXPECT_LT((twist - 0.02 * velocity).norm(), 1e-9);
  clip.camera_to_world.resize(1);
  EXPECT_TRUE(readout_of_frames(clip).empty()) << "a camera that stands still";
}

} // namespace
} // namespace kinora::clip
