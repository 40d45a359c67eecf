// Files of every version that was ever written, and what they must decode to: no later version may break them.
#include "conformance/expected.h"

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "support/source_folder.h"

namespace kinora::conformance {
namespace {

class Conformance : public testing::TestWithParam<Expected> {};

TEST_P(Conformance, DecodesToTheSameBits) {
  const Expected& expected = GetParam();
  const clip::Clip clip = clip::read_clip(test::source_folder() / "tests" / "conformance" / expected.file);
  ASSERT_EQ(clip.layers.size(), expected.layers.size());
  EXPECT_EQ(clip.times.size(), expected.frames);
  for (std::size_t l = 0; l < expected.layers.size(); ++l) {
    EXPECT_EQ(checksums(clip.layers[l]), expected.layers[l]) << expected.holds << ": " << clip.layers[l].name;
    EXPECT_EQ(nlohmann::json(clip.layers[l].births.frames()), nlohmann::json::parse(expected.births)[l]);
    EXPECT_EQ(away_of(clip.layers[l]), nlohmann::json::parse(expected.away)[l]) << clip.layers[l].name;
  }
}

INSTANTIATE_TEST_SUITE_P(Corpus, Conformance, testing::ValuesIn(kExpected), [](const auto& entry) {
  const std::string file = entry.param.file;
  return file.substr(0, file.find('.'));
});

} // namespace
} // namespace kinora::conformance
