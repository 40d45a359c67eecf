#include "evaluate/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/metrics.h"

namespace kinora::evaluate {
namespace {

LabelImage region_of(const Subject& subject, const ingest::Frame& frame) {
  LabelImage region(frame.color.width(), frame.color.height());
  for (int v = 0; v < region.height(); ++v) {
    for (int u = 0; u < region.width(); ++u) {
      const int label = frame.label_at(u, v);
      const bool wanted = !subject.labels || subject.labels->contains(label);
      region.at(u, v) = wanted && (!subject.measured_only || frame.depth.at(u, v) > 0) ? 1 : 0;
    }
  }
  return region;
}

// On black by its rounded alpha, as compare_images composites; outside the region nothing is left if `cut`.
ColorImage composited(const ColorImage& drawn, const LabelImage& region, bool cut) {
  ColorImage out(drawn.width(), drawn.height(), 3);
  for (int v = 0; v < out.height(); ++v) {
    for (int u = 0; u < out.width(); ++u) {
      const double alpha = cut && region.at(u, v) == 0 ? 0 : drawn.at(u, v, 3) / 255.0;
      for (int c = 0; c < 3; ++c) {
        out.at(u, v, c) = static_cast<std::uint8_t>(std::nearbyint(drawn.at(u, v, c) * alpha));
      }
    }
  }
  return out;
}

double drawn_share(const ColorImage& drawn, const LabelImage& region) {
  double sum = 0;
  double count = 0;
  for (int v = 0; v < region.height(); ++v) {
    for (int u = 0; u < region.width(); ++u) {
      if (region.at(u, v) == 0) continue;
      sum += drawn.at(u, v, 3) / 255.0;
      count += 1;
    }
  }
  return sum / count;
}

double mae_over(const ColorImage& shown, const ColorImage& truth, const LabelImage& region) {
  double sum = 0;
  double count = 0;
  for (int v = 0; v < region.height(); ++v) {
    for (int u = 0; u < region.width(); ++u) {
      if (region.at(u, v) == 0) continue;
      for (int c = 0; c < 3; ++c) sum += std::abs(static_cast<double>(shown.at(u, v, c)) - truth.at(u, v, c));
      count += 3;
    }
  }
  return sum / count;
}

struct DepthError {
  double median;   ///< metres; infinite if most of the measured pixels are not drawn
  double coverage; ///< share of the measured pixels that is drawn
};

std::optional<DepthError> depth_error(const DepthImage& drawn, const DepthImage& measured, const LabelImage& region) {
  std::vector<double> errors;
  double covered = 0;
  for (int v = 0; v < region.height(); ++v) {
    for (int u = 0; u < region.width(); ++u) {
      if (region.at(u, v) == 0 || measured.at(u, v) <= 0) continue;
      const bool is_drawn = drawn.at(u, v) > 0;
      covered += is_drawn ? 1 : 0;
      errors.push_back(is_drawn ? std::abs(static_cast<double>(drawn.at(u, v)) - measured.at(u, v))
                                : std::numeric_limits<double>::infinity());
    }
  }
  if (errors.empty()) return std::nullopt;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return DepthError{*middle, covered / static_cast<double>(errors.size())};
}

} // namespace

void Means::add(const std::string& name, double value) {
  auto& [sum, count] = sums_[name];
  sum += value;
  ++count;
}

std::optional<double> Means::mean(const std::string& name) const {
  const auto found = sums_.find(name);
  if (found == sums_.end()) return std::nullopt;
  return found->second.first / found->second.second;
}

nlohmann::json Means::json() const {
  nlohmann::json out = {{"frames", frames_}};
  for (const auto& [name, entry] : sums_) {
    const double mean = entry.first / entry.second;
    out[name] = std::isfinite(mean) ? nlohmann::json(std::round(mean * 1e4) / 1e4) : nlohmann::json(nullptr);
  }
  return out;
}

std::vector<Subject> layer_subjects(const player::Player& player, bool masks) {
  std::vector<Subject> subjects;
  const auto& layers = player.clip().layers;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    Subject subject{layers[i].name, "pixels with measured depth", {i}, {}, true, true};
    if (masks) {
      subject.labels.emplace({layers[i].label});
      subject.measured_only = layers[i].label == 0;
      subject.region =
          fmt::format("pixels labelled {}{}", layers[i].label, subject.measured_only ? " with measured depth" : "");
    }
    subjects.push_back(std::move(subject));
  }
  return subjects;
}

Subject whole_subject(const player::Player& player, bool masks) {
  Subject whole{"whole", "pixels with measured depth", player.all_layers(), {}, true};
  if (!masks) return whole;
  whole.region = "pixels of the modelled layers with measured depth";
  whole.labels.emplace();
  for (const clip::Layer& layer : player.clip().layers) whole.labels->insert(layer.label);
  return whole;
}

Subject picture_subject(const player::Player& player) {
  return {"picture", "every pixel", player.all_layers(), {}, false};
}

std::vector<Subject> moving_subjects(const player::Player& player) {
  return {{"moving", "pixels that move, with measured depth", player.all_layers(), std::set{1}, true},
          {"still", "pixels that keep still, with measured depth", player.all_layers(), std::set{0}, true}};
}

std::optional<Subject> foreground_subject(const player::Player& player) {
  Subject foreground{"foreground", "pixels with any label but 0", {}, std::set<int>{}, false};
  for (int label = 1; label < 256; ++label) foreground.labels->insert(label);
  const auto& layers = player.clip().layers;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].label != 0) foreground.layers.push_back(i);
  }
  if (foreground.layers.empty()) return std::nullopt;
  return foreground;
}

void compare(const fields::Picture& picture, const ingest::Frame& frame, const Subject& subject, Means& means) {
  const LabelImage region = region_of(subject, frame);
  if (std::all_of(region.values().begin(), region.values().end(), [](std::uint8_t x) { return x == 0; })) return;
  // A background is cut to its region: what it shows where something stands before it is not wrong.
  fields::Picture shown = picture;
  if (subject.measured_only) {
    for (std::size_t i = 0; i < region.pixel_count(); ++i) {
      if (region.data()[i] == 0) shown.color.data()[4 * i + 3] = 0;
    }
  }
  const ImageMetrics metrics = compare_images(shown.color, frame.color, region);
  const ColorImage on_black = composited(picture.color, region, subject.measured_only);
  means.add_frame();
  means.add("psnr", psnr_over(on_black, frame.color, region).value());
  means.add("mae", mae_over(on_black, frame.color, region));
  means.add("coverage", drawn_share(picture.color, region));
  means.add("psnr_box", metrics.psnr_box);
  means.add("ssim_box", metrics.ssim_box);
  means.add("mae_box", metrics.mae_box);
  means.add("psnr_full", metrics.psnr_full);
  means.add("ssim_full", metrics.ssim_full);
  means.add("psnr_inside", metrics.psnr_inside);
  means.add("iou", metrics.iou);
  if (const auto depth = depth_error(picture.depth, frame.depth, region)) {
    means.add("depth_error_median", depth->median);
    means.add("depth_coverage", depth->coverage);
  }
}

} // namespace kinora::evaluate
