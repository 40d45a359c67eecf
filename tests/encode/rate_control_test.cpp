#include "encode/rate_control.h"

#include <cmath>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "container/ebml_builder.h"
#include "support/source_folder.h"

namespace kinora::encode {
namespace {

class RateControl : public testing::Test {
protected:
  static clip::Clip load() {
    return clip::read_clip(test::source_folder() / "tests" / "conformance" / "clip_fields_3_and_4.mkv");
  }
  /// Of the file, with these steps.
  std::size_t stored(const clip::Clip& clip, const clip::StorageOptions& options = {}) const {
    clip::write_clip(clip, folder_ / "a.mkv", options);
    return static_cast<std::size_t>(std::filesystem::file_size(folder_ / "a.mkv"));
  }
  /// Squared, of all parameters that are stored.
  double error_of(const clip::Clip& clip) const {
    const clip::Clip back = clip::read_clip(folder_ / "a.mkv");
    double error = 0;
    for (std::size_t l = 0; l < clip.layers.size(); ++l) {
      const auto& before = clip.layers[l].field.table;
      for (std::size_t i = 0; i < before.size(); ++i) error += std::pow(before[i] - back.layers[l].field.table[i], 2);
    }
    return error;
  }
  container::testing::TemporaryFolder folder_;
  Progress silent_;
};

TEST_F(RateControl, FilesTakeWhatTheyMayAndMoreIsBetter) {
  const clip::Clip clip = load();
  const std::size_t usual = stored(clip);
  const RateChoice limits = choose_rounding(clip, usual, 0, silent_);
  ASSERT_LT(limits.fewest_bytes, limits.most_bytes);
  double last_error = HUGE_VAL;
  for (const double share : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const double wanted =
        static_cast<double>(limits.fewest_bytes) + share * static_cast<double>(limits.most_bytes - limits.fewest_bytes);
    const RateChoice choice = choose_rounding(clip, usual, static_cast<std::size_t>(wanted), silent_);
    const auto bytes = static_cast<double>(stored(clip, {choice.fields}));
    EXPECT_NEAR(bytes, static_cast<double>(choice.bytes), 0.002 * wanted) << share;
    EXPECT_NEAR(bytes, wanted, 0.05 * wanted) << share;
    const double error = error_of(clip);
    EXPECT_LT(error, last_error) << share;
    last_error = error;
  }
}

TEST_F(RateControl, TakesTheCheapestWhereTheBytesAreTooFew) {
  const clip::Clip clip = load();
  const RateChoice choice = choose_rounding(clip, stored(clip), 1, silent_);
  EXPECT_EQ(choice.bytes, choice.fewest_bytes);
  EXPECT_LT(stored(clip, {choice.fields}), stored(clip));
}

TEST_F(RateControl, ChoosesTheSameAgain) {
  const clip::Clip clip = load();
  const std::size_t usual = stored(clip);
  const RateChoice choice = choose_rounding(clip, usual, usual, silent_);
  const RateChoice again = choose_rounding(clip, usual, usual, silent_);
  ASSERT_EQ(choice.bytes, again.bytes);
  stored(clip, {choice.fields});
  const double error = error_of(clip);
  stored(clip, {again.fields});
  EXPECT_EQ(error_of(clip), error);
}

} // namespace
} // namespace kinora::encode
