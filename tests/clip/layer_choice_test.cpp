#include "clip/layer_choice.h"

#include <gtest/gtest.h>

#include "sample_clip.h"

namespace kinora::clip {
namespace {

class Warnings : public Progress {
public:
  void warn(const std::string& sentence) override { sentences.push_back(sentence); }
  std::vector<std::string> sentences;
};

TEST(LayerChoice, UnknownNamesAreIgnoredWithAWarningThatNamesTheLayersThereAre) {
  Warnings warnings;
  const std::vector<std::string> names{"object", "person", "object"};
  EXPECT_EQ(choose_layers(testing::sample_clip(1, 3, false), names, warnings), (LayerChoice{1}));
  ASSERT_EQ(warnings.sentences.size(), 1U);
  EXPECT_NE(warnings.sentences[0].find("\"person\""), std::string::npos);
  EXPECT_NE(warnings.sentences[0].find("background, object"), std::string::npos);
}

TEST(LayerChoice, IsInTheClipsOrder) {
  Warnings warnings;
  const Clip clip = testing::sample_clip(1, 3, false);
  const std::vector<std::string> names{"object", "background"};
  EXPECT_EQ(choose_layers(clip, names, warnings), all_layers(clip));
  EXPECT_TRUE(warnings.sentences.empty());
}

TEST(LayerChoice, OfAClipWithoutLayersIsEmpty) {
  EXPECT_TRUE(all_layers({}).empty());
  EXPECT_EQ(layer_names({}), "none");
}

} // namespace
} // namespace kinora::clip
