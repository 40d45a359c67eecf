// Files of every version that was ever written, and what they must decode to: no later version may break them.
#include "conformance/expected_fields.h"

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "support/source_folder.h"

namespace kinora::conformance {
namespace {

void expect_fields(const ExpectedFields& expected) {
  const clip::Clip clip = clip::read_clip(test::source_folder() / "tests" / "conformance" / expected.file);
  ASSERT_EQ(clip.layers.size(), expected.layers.size());
  EXPECT_EQ(clip.times.size(), expected.frames);
  for (std::size_t l = 0; l < expected.layers.size(); ++l) {
    EXPECT_EQ(checksums(clip.layers[l].field), expected.layers[l]) << clip.layers[l].name;
  }
}

TEST(Conformance, FieldsOfVersions3And4DecodeToTheSameBits) { expect_fields(kExpectedFields[0]); }

} // namespace
} // namespace kinora::conformance
