#include "core/metrics.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/golden_metrics.h"

namespace kinora {
namespace {

std::uint32_t noise(std::uint32_t seed, std::uint32_t i) {
  std::uint32_t x = i * 747796405U + seed * 2891336453U;
  x ^= x >> 16;
  x *= 2246822519U;
  x ^= x >> 13;
  return x >> 24;
}

struct Pictures {
  ColorImage render, truth;
  LabelImage mask;
};

std::uint8_t alpha_of(const std::string& kind, std::uint32_t i, bool in_mask) {
  if (kind == "half") return 127;
  if (kind == "as_mask") return in_mask ? 255 : 0;
  const std::array<std::uint32_t, 5> choices = {0, 127, 128, 255, noise(9, i)};
  return static_cast<std::uint8_t>(choices[noise(8, i) % 5]);
}

// The twin of pictures() in make_golden_metrics.py: change both or neither.
Pictures pictures(const GoldenMetrics& golden) {
  const int width = golden.width;
  const int height = golden.height;
  Pictures p{ColorImage(width, height, golden.channels), ColorImage(width, height, 3), LabelImage(width, height)};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::uint32_t i = static_cast<std::uint32_t>(v * width + u);
      const int dx = 2 * u - width;
      const int dy = 2 * v - height;
      if (std::string(golden.mask) == "disc") {
        p.mask.at(u, v) = 4 * (dx * dx + dy * dy) < (width * width + height * height) / 2 ? 2 : 0;
      } else {
        p.mask.at(u, v) = u + v < 4 ? 1 : 0;
      }
      for (int c = 0; c < 3; ++c) {
        const std::uint32_t channel = static_cast<std::uint32_t>(c);
        const int value =
            static_cast<int>((static_cast<std::uint32_t>(u * 5 + v * 3 + c * 40) + noise(1 + channel, i) % 32) % 256);
        const int added = static_cast<int>(noise(5 + channel, i)) % (2 * golden.amplitude + 1) - golden.amplitude;
        p.truth.at(u, v, c) = static_cast<std::uint8_t>(value);
        p.render.at(u, v, c) = static_cast<std::uint8_t>(std::clamp(value + added, 0, 255));
      }
      if (golden.channels == 4) p.render.at(u, v, 3) = alpha_of(golden.alpha, i, p.mask.at(u, v) != 0);
    }
  }
  if (std::string(golden.mask) == "none") p.mask = {};
  return p;
}

TEST(Metrics, EqualTheReferenceScriptToFourDigits) {
  constexpr double kFourDigits = 5e-5;
  for (const GoldenMetrics& golden : kGoldenMetrics) {
    SCOPED_TRACE(golden.name);
    const Pictures p = pictures(golden);
    const ImageMetrics found = compare_images(p.render, p.truth, p.mask);
    EXPECT_NEAR(found.psnr_box, golden.expected.psnr_box, kFourDigits);
    EXPECT_NEAR(found.ssim_box, golden.expected.ssim_box, kFourDigits);
    EXPECT_NEAR(found.psnr_full, golden.expected.psnr_full, kFourDigits);
    EXPECT_NEAR(found.ssim_full, golden.expected.ssim_full, kFourDigits);
    EXPECT_NEAR(found.psnr_inside, golden.expected.psnr_inside, kFourDigits);
    EXPECT_NEAR(found.mae_box, golden.expected.mae_box, kFourDigits);
    EXPECT_NEAR(found.iou, golden.expected.iou, kFourDigits);
  }
}

ErrorCode code_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorCode::kUsage;
}

TEST(Metrics, RejectPicturesOfDifferentSize) {
  EXPECT_EQ(code_of([] { compare_images(ColorImage(4, 3, 3), ColorImage(3, 4, 3)); }), ErrorCode::kFailure);
  EXPECT_EQ(code_of([] { compare_images(ColorImage(4, 3, 3), ColorImage(4, 3, 3), LabelImage(4, 4, 1, 1)); }),
            ErrorCode::kFailure);
  EXPECT_EQ(code_of([] { compare_images(ColorImage(), ColorImage()); }), ErrorCode::kFailure);
}

TEST(Metrics, RejectAMaskWithoutForeground) {
  EXPECT_EQ(code_of([] { compare_images(ColorImage(4, 3, 3), ColorImage(4, 3, 3), LabelImage(4, 3)); }),
            ErrorCode::kFailure);
}

TEST(Metrics, PsnrOfOneGreyLevelIs48Decibel) {
  EXPECT_NEAR(psnr_from_mse(1.0), 48.1308, 1e-4);
  EXPECT_NEAR(psnr_from_mse(255.0 * 255.0), 0.0, 1e-12);
  EXPECT_EQ(psnr_from_mse(0.0), 100.0);
}

TEST(Metrics, PsnrOverARegionCountsItsPixelsAlone) {
  ColorImage a(3, 2, 3, 100);
  ColorImage b(3, 2, 3, 100);
  LabelImage region(3, 2);
  region.at(1, 0) = 7;
  for (int c = 0; c < 3; ++c) b.at(1, 0, c) = 101;
  for (int c = 0; c < 3; ++c) b.at(2, 1, c) = 255;
  const std::optional<double> psnr = psnr_over(a, b, region);
  ASSERT_TRUE(psnr.has_value());
  EXPECT_NEAR(*psnr, 48.1308, 1e-4);
  EXPECT_EQ(psnr_over(a, b, LabelImage(3, 2)), std::nullopt);
}

} // namespace
} // namespace kinora
