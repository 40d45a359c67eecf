#include "clip/readout.h"

#include <gtest/gtest.h>

namespace kinora::clip {
namespace {

using Json = nlohmann::json;

TEST(StoredReadout, IsWhatWasStored) {
  for (const Readout& readout : {Readout{0.0271, -0.001}, Readout{-0.0093, 0}}) {
    Json metadata;
    store_readout(readout, metadata);
    EXPECT_EQ(stored_readout(Json::parse(metadata.dump())).color, readout.color);
    EXPECT_EQ(stored_readout(Json::parse(metadata.dump())).depth, readout.depth);
  }
}

TEST(StoredReadout, OfRowsThatAreReadAtOnceTakesNothing) {
  Json metadata = Json::object();
  store_readout({}, metadata);
  EXPECT_TRUE(metadata.empty());
  EXPECT_EQ(stored_readout(metadata).color, 0);
}

TEST(StoredReadout, ThatCannotBeUnderstoodIsNone) {
  for (const char* text : {"7", "[]", "{}", R"({"readout_s": "0.02"})", R"({"readout_s": [0.02]})",
                           R"({"readout_s": 1e300, "depth_readout_s": -1e300})", R"({"readout_s": null})"}) {
    const Readout readout = stored_readout({{"rolling_shutter", Json::parse(text)}});
    EXPECT_EQ(readout.color, 0) << text;
    EXPECT_EQ(readout.depth, 0) << text;
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
  store_readout({0.02, 0.01}, clip.metadata);
  const std::vector<ReadoutMotion> readout = readout_of_frames(clip);
  ASSERT_EQ(readout.size(), 5U);
  for (const ReadoutMotion& motion : readout) {
    EXPECT_LT((motion.color - 0.02 * velocity).norm(), 1e-9);
    EXPECT_LT((motion.depth - 0.01 * velocity).norm(), 1e-9);
  }
  clip.camera_to_world.resize(1);
  EXPECT_TRUE(readout_of_frames(clip).empty()) << "a camera that stands still";
}

} // namespace
} // namespace kinora::clip
