// Image metrics, equal to those of the project's reference script to four digits.
#pragma once

#include <optional>

#include "core/image.h"

namespace kinora {

/// PSNR in dB (peak 255, all channels), capped at 100 dB. SSIM: Gaussian 11×11, σ 1.5, K1 .01, K2 .03, L 255, per
/// channel, averaged (Wang et al. 2004), reflected border without the edge pixel. MAE in 0–255.
struct ImageMetrics {
  double psnr_box = 0; ///< bounding box of the mask grown by 8 pixels
  double ssim_box = 0;
  double psnr_full = 0; ///< the whole picture
  double ssim_full = 0;
  double psnr_inside = 0; ///< pixels in both silhouettes; 0 if there are none
  double mae_box = 0;
  double iou = 0; ///< of alpha > 0.5 with the mask
};

/// Compares a picture with the truth, both composited on black: the render (3 channels, or 4 with straight alpha) by
/// its alpha rounded to 8 bits, the truth (3 channels) by its mask (non-zero = foreground; empty image = everything).
/// Throws Error(kFailure) if sizes differ or the mask has no foreground. Thread-safe.
ImageMetrics compare_images(const ColorImage& render, const ColorImage& truth, const LabelImage& mask = {});

/// PSNR in dB from a mean squared error of values in 0–255, capped at 100 dB.
double psnr_from_mse(double mean_squared_error);

/// PSNR over the pixels where `region` is non-zero; nothing if there are none.
std::optional<double> psnr_over(const ColorImage& render, const ColorImage& truth, const LabelImage& region);

} // namespace kinora
