#include "tracking/view/texture.h"

#include <algorithm>
#include <cmath>

#include "tracking/view/mask_area.h"

namespace kinora::tracking {
namespace {

constexpr int kReach = 2;           // pixels
constexpr float kMinDetail = 0.03F; // of the logarithm; light on a ball 40 pixels wide has as much at its limb only

// Sums over 5×5 pixels; 0 within two of the picture's border.
template <class T> Image<T> sums_around(const Image<T>& values) {
  Image<T> across(values.width(), values.height());
  Image<T> result(values.width(), values.height());
  for (int v = 0; v < values.height(); ++v) {
    const T* in = values.pixel(0, v);
    T* out = across.pixel(0, v);
    for (int u = kReach; u + kReach < values.width(); ++u) {
      out[u] = static_cast<T>(in[u - 2] + in[u - 1] + in[u] + in[u + 1] + in[u + 2]);
    }
  }
  for (int v = kReach; v + kReach < values.height(); ++v) {
    T* out = result.pixel(0, v);
    const T* in = across.pixel(0, v - kReach);
    const std::ptrdiff_t row = values.width();
    for (std::ptrdiff_t u = 0; u < row; ++u) {
      out[u] = static_cast<T>(in[u] + in[u + row] + in[u + 2 * row] + in[u + 3 * row] + in[u + 4 * row]);
    }
  }
  return result;
}

Image<float> halved(const Image<float>& values) {
  Image<float> result(std::max(1, values.width() / 2), std::max(1, values.height() / 2));
  for (int v = 0; v < result.height(); ++v) {
    for (int u = 0; u < result.width(); ++u) {
      const int u1 = std::min(2 * u + 1, values.width() - 1);
      const int v1 = std::min(2 * v + 1, values.height() - 1);
      result.at(u, v) =
          0.25F * (values.at(2 * u, 2 * v) + values.at(u1, 2 * v) + values.at(2 * u, v1) + values.at(u1, v1));
    }
  }
  return result;
}

TextureLevel with_gradient(const Image<float>& values, float scale) {
  TextureLevel level{Image<float>(values.width(), values.height(), 3), scale};
  const int last_u = values.width() - 1;
  const int last_v = values.height() - 1;
  const auto derivative = [scale](float from, float to, int steps) {
    return steps > 0 ? scale * (to - from) / static_cast<float>(steps) : 0.0F;
  };
  for (int v = 0; v <= last_v; ++v) {
    const int v0 = std::max(0, v - 1);
    const int v1 = std::min(last_v, v + 1);
    const float* row = values.pixel(0, v);
    const float* above = values.pixel(0, v0);
    const float* below = values.pixel(0, v1);
    float* out = level.values.pixel(0, v);
    const float share = v1 > v0 ? scale / static_cast<float>(v1 - v0) : 0.0F; // by one or two: without rounding
    for (int u = 0; u <= last_u; ++u, out += 3) {
      out[0] = row[u];
      out[2] = share * (below[u] - above[u]);
    }
    out = level.values.pixel(0, v);
    out[1] = derivative(row[0], row[std::min(1, last_u)], std::min(1, last_u));
    for (int u = 1; u < last_u; ++u) out[3 * u + 1] = scale * (row[u + 1] - row[u - 1]) * 0.5F;
    if (last_u > 0) out[3 * last_u + 1] = derivative(row[last_u - 1], row[last_u], 1);
  }
  return level;
}

} // namespace

Image<float> log_luminance(const ColorImage& color, int left, int top, int width, int height) {
  return log_luminance(color, left, top, LabelImage(width, height, 1, 1));
}

Image<float> log_luminance(const ColorImage& color, int left, int top, const LabelImage& mask) {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i) / 255.0F;
  Image<float> result(mask.width(), mask.height());
  for (int v = 0; v < result.height(); ++v) {
    for (int u = 0; u < result.width(); ++u) {
      if (mask.at(u, v) == 0) continue;
      const std::uint8_t* c = color.pixel(left + u, top + v);
      result.at(u, v) = std::log(0.08F + 0.299F * table[c[0]] + 0.587F * table[c[1]] + 0.114F * table[c[2]]);
    }
  }
  return result;
}

void fill_outside(Image<float>& values, const LabelImage& mask) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < mask.values().size(); ++i) {
    if (mask.values()[i] == 0) continue;
    sum += values.values()[i];
    count += 1;
  }
  const float mean = count > 0 ? static_cast<float>(sum / count) : 0.0F;
  for (std::size_t i = 0; i < mask.values().size(); ++i) {
    if (mask.values()[i] == 0) values.values()[i] = mean;
  }
}

LabelImage detail_of(const Image<float>& texture, const LabelImage& mask) {
  constexpr float kPixels = (2 * kReach + 1) * (2 * kReach + 1);
  const Image<float> sums = sums_around(texture);
  LabelImage differs(mask.width(), mask.height());
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      const float contrast = texture.at(u, v) - sums.at(u, v) / kPixels;
      if (mask.at(u, v) == MaskArea::kInterior && std::abs(contrast) > kMinDetail) differs.at(u, v) = 1;
    }
  }
  LabelImage detail = sums_around(differs);
  for (std::size_t i = 0; i < detail.values().size(); ++i) {
    detail.values()[i] = detail.values()[i] > 0 && mask.values()[i] == MaskArea::kInterior ? 1 : 0;
  }
  return detail;
}

TexturePyramid texture_pyramid(const Image<float>& values, float scale) {
  TexturePyramid pyramid;
  Image<float> level = values;
  for (std::size_t l = 0; l < pyramid.size(); ++l) {
    pyramid[l] = with_gradient(level, scale / static_cast<float>(1U << l));
    level = halved(level);
  }
  return pyramid;
}

} // namespace kinora::tracking
