// How well labels fit true masks, and pictures of them.
#pragma once

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <vector>

#include "core/image_codec.h"
#include "ingest/frame/frame.h"

namespace kinora::bench {

/// Labels of a capture's frames: how much they cover, and their overlap with masks where there are some.
class LabelTally {
public:
  void add(const LabelImage& labels, const LabelImage& truth) {
    for (const std::uint8_t label : labels.values()) ++pixels_[label];
    if (truth.empty()) return;
    for (int label = 1; label < 256; ++label)
      if (const auto share = overlap(labels, truth, label)) shares_[label].push_back(*share);
  }

  void print() const {
    double all = 0;
    for (const auto& [label, count] : pixels_) all += count;
    for (const auto& [label, count] : pixels_)
      std::printf("label %d: %.2f %% of all pixels\n", label, 100 * count / all);
    for (const auto& [label, shares] : shares_) {
      double sum = 0;
      for (const double share : shares) sum += share;
      std::printf("label %d: IoU %.3f (%zu frames)\n", label, sum / static_cast<double>(shares.size()), shares.size());
    }
  }

private:
  /// Pixels that both have, over pixels that either has; nothing if neither has any.
  static std::optional<double> overlap(const LabelImage& a, const LabelImage& b, int label) {
    double both = 0;
    double either = 0;
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
      const bool in_a = a.data()[i] == label;
      const bool in_b = b.data()[i] == label;
      both += in_a && in_b ? 1 : 0;
      either += in_a || in_b ? 1 : 0;
    }
    if (either == 0) return std::nullopt;
    return both / either;
  }

  std::map<int, double> pixels_;
  std::map<int, std::vector<double>> shares_;
};

/// Colour darkened, with a tint for each label but 0.
inline void write_tinted(const ingest::Frame& frame, const std::filesystem::path& folder) {
  constexpr std::array<std::array<int, 3>, 6> kTints{
      {{0, 0, 120}, {120, 0, 0}, {0, 120, 0}, {120, 120, 0}, {0, 120, 120}, {120, 0, 120}}};
  ColorImage image = frame.color;
  for (std::size_t i = 0; i < frame.labels.pixel_count(); ++i) {
    const int label = frame.labels.data()[i];
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint8_t& value = image.data()[3 * i + c];
      const int tint = label == 0 ? 0 : kTints[static_cast<std::size_t>(label) % kTints.size()][c];
      value = static_cast<std::uint8_t>(value / 2 + tint);
    }
  }
  const Bytes png = encode_png(image);
  char name[32];
  std::snprintf(name, sizeof name, "%06d.png", frame.index);
  std::ofstream(folder / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
}

} // namespace kinora::bench
