#include "core/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/error.h"

namespace kinora {
namespace {

using Plane = Image<double>;

struct Box {
  int left, top, right, bottom; // right and bottom excluded
  bool operator==(const Box&) const = default;
};

constexpr int kRadius = 5;

std::array<double, 2 * kRadius + 1> gaussian_kernel() {
  std::array<double, 2 * kRadius + 1> kernel{};
  double sum = 0;
  for (int i = -kRadius; i <= kRadius; ++i) sum += kernel[i + kRadius] = std::exp(-i * i / (2.0 * 1.5 * 1.5));
  for (double& k : kernel) k /= sum;
  return kernel;
}

// Border without the edge pixel: gfedcb|abcdefgh|gfedcba.
int reflect(int i, int size) {
  if (size == 1) return 0;
  while (i < 0 || i >= size) i = i < 0 ? -i : 2 * (size - 1) - i;
  return i;
}

Plane blur(const Plane& in) {
  static const auto kernel = gaussian_kernel();
  const int width = in.width(), height = in.height();
  Plane rows(width, height), out(width, height);
  std::vector<double> line(static_cast<std::size_t>(width) + 2 * kRadius); // with what is beyond both ends
  for (int v = 0; v < height; ++v) {
    for (int u = -kRadius; u < width + kRadius; ++u) line[u + kRadius] = in.at(reflect(u, width), v);
    double* to = rows.pixel(0, v);
    for (int u = 0; u < width; ++u) {
      double sum = 0;
      for (std::size_t tap = 0; tap < kernel.size(); ++tap)
        sum += kernel[tap] * line[static_cast<std::size_t>(u) + tap];
      to[u] = sum;
    }
  }
  for (int v = 0; v < height; ++v) {
    double* to = out.pixel(0, v);
    for (std::size_t tap = 0; tap < kernel.size(); ++tap) {
      const double* from = rows.pixel(0, reflect(v + static_cast<int>(tap) - kRadius, height));
      for (int u = 0; u < width; ++u) to[u] += kernel[tap] * from[u];
    }
  }
  return out;
}

Plane channel_of(const ColorImage& image, int channel, const Box& box) {
  Plane plane(box.right - box.left, box.bottom - box.top);
  for (int v = 0; v < plane.height(); ++v) {
    for (int u = 0; u < plane.width(); ++u) plane.at(u, v) = image.at(u + box.left, v + box.top, channel);
  }
  return plane;
}

Plane product(const Plane& a, const Plane& b) {
  Plane out(a.width(), a.height());
  std::transform(a.values().begin(), a.values().end(), b.values().begin(), out.values().begin(), std::multiplies<>());
  return out;
}

double ssim_in(const ColorImage& a, const ColorImage& b, const Box& box) {
  constexpr double kC1 = (0.01 * 255) * (0.01 * 255);
  constexpr double kC2 = (0.03 * 255) * (0.03 * 255);
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const Plane x = channel_of(a, c, box);
    const Plane y = channel_of(b, c, box);
    const Plane mean_x = blur(x);
    const Plane mean_y = blur(y);
    const Plane xx = blur(product(x, x));
    const Plane yy = blur(product(y, y));
    const Plane xy = blur(product(x, y));
    double channel_sum = 0;
    for (std::size_t i = 0; i < mean_x.pixel_count(); ++i) {
      const double mx = mean_x.data()[i];
      const double my = mean_y.data()[i];
      const double vx = xx.data()[i] - mx * mx;
      const double vy = yy.data()[i] - my * my;
      const double vxy = xy.data()[i] - mx * my;
      channel_sum += (2 * mx * my + kC1) * (2 * vxy + kC2) / ((mx * mx + my * my + kC1) * (vx + vy + kC2));
    }
    sum += channel_sum / static_cast<double>(mean_x.pixel_count());
  }
  return sum / 3;
}

struct Difference {
  double squared = 0;
  double absolute = 0;
  double count = 0;

  void add(const std::uint8_t* a, const std::uint8_t* b) {
    for (int c = 0; c < 3; ++c) {
      const double d = static_cast<double>(a[c]) - b[c];
      squared += d * d;
      absolute += std::abs(d);
      ++count;
    }
  }
  double psnr() const { return psnr_from_mse(squared / count); }
  double mae() const { return absolute / count; }
};

Difference difference_in(const ColorImage& a, const ColorImage& b, const Box& box) {
  Difference d;
  for (int v = box.top; v < box.bottom; ++v) {
    for (int u = box.left; u < box.right; ++u) d.add(a.pixel(u, v), b.pixel(u, v));
  }
  return d;
}

Box box_around(const LabelImage& mask, int margin) {
  Box box{mask.width(), mask.height(), 0, 0};
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      if (mask.at(u, v) == 0) continue;
      box = {std::min(box.left, u), std::min(box.top, v), std::max(box.right, u + 1), std::max(box.bottom, v + 1)};
    }
  }
  if (box.right == 0) throw Error(ErrorCode::kFailure, "the mask to compare inside has no foreground pixel");
  return {std::max(box.left - margin, 0), std::max(box.top - margin, 0), std::min(box.right + margin, mask.width()),
          std::min(box.bottom + margin, mask.height())};
}

// Half to even, as numpy rounds.
std::uint8_t round_to_byte(double value) { return static_cast<std::uint8_t>(std::nearbyint(value)); }

} // namespace

double psnr_from_mse(double mean_squared_error) {
  return -10 * std::log10(std::max(mean_squared_error / (255.0 * 255.0), 1e-10));
}

std::optional<double> psnr_over(const ColorImage& render, const ColorImage& truth, const LabelImage& region) {
  Difference d;
  for (int v = 0; v < region.height(); ++v) {
    for (int u = 0; u < region.width(); ++u) {
      if (region.at(u, v) != 0) d.add(render.pixel(u, v), truth.pixel(u, v));
    }
  }
  if (d.count == 0) return std::nullopt;
  return d.psnr();
}

ImageMetrics compare_images(const ColorImage& render, const ColorImage& truth, const LabelImage& mask) {
  if (!render.same_size(truth) || (!mask.empty() && !mask.same_size(truth)) || truth.empty()) {
    throw Error(ErrorCode::kFailure, "pictures that are compared must have the same size");
  }
  const int width = truth.width();
  const int height = truth.height();
  ColorImage shown(width, height, 3);
  ColorImage wanted(width, height, 3);
  LabelImage foreground = mask.empty() ? LabelImage(width, height, 1, 1) : mask;
  Difference inside;
  double both = 0;
  double either = 0;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const bool wanted_here = foreground.at(u, v) != 0;
      const double alpha = render.channels() == 4 ? render.at(u, v, 3) / 255.0 : 1.0;
      const bool shown_here = alpha > 0.5;
      for (int c = 0; c < 3; ++c) {
        shown.at(u, v, c) = render.channels() == 4 ? round_to_byte(render.at(u, v, c) * alpha) : render.at(u, v, c);
        wanted.at(u, v, c) = wanted_here ? truth.at(u, v, c) : std::uint8_t{0};
      }
      if (shown_here && wanted_here) inside.add(shown.pixel(u, v), wanted.pixel(u, v));
      both += shown_here && wanted_here ? 1 : 0;
      either += shown_here || wanted_here ? 1 : 0;
    }
  }
  const Box box = box_around(foreground, 8);
  const Box full{0, 0, width, height};
  const Difference in_box = difference_in(shown, wanted, box);
  ImageMetrics metrics;
  metrics.psnr_box = in_box.psnr();
  metrics.mae_box = in_box.mae();
  metrics.ssim_box = ssim_in(shown, wanted, box);
  metrics.psnr_full = difference_in(shown, wanted, full).psnr();
  metrics.ssim_full = box == full ? metrics.ssim_box : ssim_in(shown, wanted, full);
  metrics.psnr_inside = inside.count > 0 ? inside.psnr() : 0.0;
  metrics.iou = both / std::max(either, 1.0);
  return metrics;
}

} // namespace kinora
