#include "encode/readout_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>

namespace kinora::encode {
namespace {

constexpr double kLeast = 0.002; // seconds
constexpr double kDeviations = 4;
constexpr std::size_t kStretches = 8; // that the frames are cut into
constexpr std::size_t kMinFrames = 6; // of each
constexpr double kToldAtOnce = 0.6;   // part of what is missing that the first look tells, about
constexpr double kLeastTold = 0.2;    // and at least, if the search is to be believed
constexpr double kTooLong = 1.25;     // of the longest: an error, not a time

} // namespace

bool ReadoutBeyond::is_certain() const { return std::abs(color) > std::max(kLeast, kDeviations * deviation); }

std::optional<ReadoutBeyond> readout_beyond(std::span<const std::optional<PoseCorrection>> corrections) {
  std::vector<ReadoutEvidence> frames;
  for (const auto& correction : corrections) {
    if (correction && correction->readout.information(0, 0) > 0) frames.push_back(correction->readout);
  }
  if (frames.size() < kStretches * kMinFrames) return std::nullopt;
  ReadoutEvidence all;
  std::array<ReadoutEvidence, kStretches> stretches{};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (ReadoutEvidence* sum : {&all, &stretches[i * kStretches / frames.size()]}) {
      sum->information += frames[i].information;
      sum->gradient += frames[i].gradient;
    }
  }
  const auto solver = all.information.ldlt();
  const Eigen::Vector2d seconds = -solver.solve(all.gradient);
  if (!seconds.allFinite()) return std::nullopt;
  double variance = 0;
  for (const ReadoutEvidence& stretch : stretches) {
    const Eigen::Vector2d pull = -solver.solve(stretch.gradient + stretch.information * seconds);
    variance += pull[0] * pull[0] * kStretches / (kStretches - 1);
  }
  return ReadoutBeyond{seconds[0], seconds[1], std::sqrt(variance)};
}

bool ReadoutSearch::look(std::span<const std::optional<PoseCorrection>> corrections) {
  const auto beyond = readout_beyond(corrections);
  if (!beyond) return false;
  const auto limited = [&](double seconds) { return std::clamp(seconds, -longest_, longest_); };
  if (first_beyond_ == 0) {
    if (!beyond->is_certain() || std::abs(beyond->color) > longest_) return false;
    first_beyond_ = beyond->color;
    color_ = limited(beyond->color / kToldAtOnce);
    depth_ = limited(beyond->depth / kToldAtOnce);
    return true;
  }
  const double told = (first_beyond_ - beyond->color) / color_;
  const double color = first_beyond_ / told;
  if (told > kLeastTold && std::abs(color) > kLeast && std::abs(color) < kTooLong * longest_) {
    depth_ = limited(depth_ + beyond->depth / told);
    color_ = limited(color);
  } else {
    color_ = depth_ = 0;
  }
  return false;
}

} // namespace kinora::encode
