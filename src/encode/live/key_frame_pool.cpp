#include "encode/live/key_frame_pool.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "encode/live/blurriness.h"

namespace kinora::encode {
namespace {

/// A place and one of 26 directions.
std::uint64_t key_of(const Look& look) {
  constexpr float kDiagonal = 0.41421356F; // tan(45°/2): a component below shares of the largest counts as none
  const float limit = kDiagonal * look.towards_camera.cwiseAbs().maxCoeff();
  std::uint64_t direction = 0;
  for (int a = 0; a < 3; ++a) {
    const float component = look.towards_camera[a];
    direction = 3 * direction + (component > limit ? 2 : component < -limit ? 0 : 1);
  }
  return 27 * look.place + direction;
}

} // namespace

bool KeyFramePool::is_blurred(const ingest::Frame& frame) {
  constexpr std::size_t kRemembered = 31;
  constexpr std::size_t kFewest = 5; // before which nothing is said
  const std::optional<double> blur = config_.min_sharpness > 0 ? blurriness(frame) : std::nullopt;
  if (!blur) return false;
  sharpness_.push_back(1 - *blur);
  if (sharpness_.size() > kRemembered) sharpness_.pop_front();
  if (sharpness_.size() < kFewest) return false;
  std::vector<double> sorted(sharpness_.begin(), sharpness_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return 1 - *blur < config_.min_sharpness * *middle;
}

KeyFramePool::Kept KeyFramePool::described(const KeyFrame& frame, const LiveSnapshot& snapshot) {
  Kept kept{frame, {}, {}};
  for (const auto& [label, known] : snapshot.labels) {
    PlaceGrid& grid = grids_[label];
    if (!(grid.side > 0)) grid = PlaceGrid::of(*frame.frame, label);
    kept.looks[label] = looks_of(*frame.frame, label, known.motion, frame.number, grid);
    if (config_.rule == KeyFrameRule::kPaper) kept.views[label] = paper_view(*frame.frame, known.motion, frame.number);
  }
  return kept;
}

void KeyFramePool::add(const KeyFrame& frame, const LiveSnapshot& snapshot) {
  if (is_blurred(*frame.frame)) {
    ++blurred_;
    return;
  }
  newest_.push_back(frame);
  if (newest_.size() > std::max<std::size_t>(config_.similar, 1)) newest_.pop_front();
  Kept next = described(frame, snapshot);
  switch (config_.rule) {
  case KeyFrameRule::kInterval:
    return keep_at_intervals(std::move(next));
  case KeyFrameRule::kPaper:
    return keep_far_ones(std::move(next));
  case KeyFrameRule::kCoverage:
    return keep_covering_ones(std::move(next));
  }
}

void KeyFramePool::keep_at_intervals(Kept next) {
  if (added_++ % interval_ != 0) return;
  if (kept_.size() + 1 >= config_.capacity) { // the newest one needs room, too
    for (std::size_t i = 1; 2 * i < kept_.size(); ++i) kept_[i] = std::move(kept_[2 * i]);
    kept_.resize((kept_.size() + 1) / 2);
    interval_ *= 2;
    if ((added_ - 1) % interval_ != 0) return;
  }
  kept_.push_back(std::move(next));
}

double KeyFramePool::distance(const Kept& a, const Kept& b) const {
  double farthest = 0;
  for (const auto& [label, view] : a.views) {
    const auto other = b.views.find(label);
    if (other == b.views.end()) return std::numeric_limits<double>::infinity(); // a layer that appears
    farthest = std::max(farthest, paper_distance(view, other->second, a.frame.number - b.frame.number));
  }
  return farthest;
}

void KeyFramePool::keep_far_ones(Kept next) {
  const bool is_far = std::ranges::all_of(kept_, [&](const Kept& kept) { return distance(next, kept) > kPaperGamma; });
  if (!is_far) return;
  kept_.push_back(std::move(next));
  if (kept_.size() + 1 <= config_.capacity) return;
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    for (std::size_t j = i + 1; j < kept_.size(); ++j) {
      const double apart = distance(kept_[j], kept_[i]);
      if (apart < least) {
        least = apart;
        nearest = i;
      }
    }
  }
  kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(nearest));
}

std::vector<double> KeyFramePool::worths() const {
  constexpr int kWanted = 2; // looks at each place from each side
  std::map<int, std::unordered_map<std::uint64_t, int>> counts;
  for (const Kept& kept : kept_) {
    for (const auto& [label, looks] : kept.looks)
      for (const Look& look : looks) ++counts[label][key_of(look)];
  }
  std::vector<double> worths;
  worths.reserve(kept_.size());
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    double worth = 0;
    for (const auto& [label, looks] : kept_[i].looks) {
      if (looks.empty()) continue;
      double missing = 0;
      for (const Look& look : looks) missing += std::max(0, kWanted + 1 - counts[label][key_of(look)]);
      worth += missing / (kWanted * static_cast<double>(looks.size()));
    }
    if (i > 0 && i + 1 < kept_.size()) { // the first one stays, and the newest until others come
      const double gap = kept_[i + 1].frame.frame->time - kept_[i - 1].frame.frame->time; // that it would leave
      worth += config_.spread * gap / (gap + 1);
    } else {
      worth += config_.spread;
    }
    worths.push_back(worth);
  }
  return worths;
}

void KeyFramePool::keep_covering_ones(Kept next) {
  kept_.push_back(std::move(next));
  if (kept_.size() + 1 <= config_.capacity) return;
  const std::vector<double> worth = worths();
  kept_.erase(kept_.begin() + (std::ranges::min_element(worth) - worth.begin()));
}

std::vector<KeyFrame> KeyFramePool::frames() const {
  std::vector<KeyFrame> frames;
  frames.reserve(kept_.size() + 1);
  for (const Kept& kept : kept_) frames.push_back(kept.frame);
  if (!newest_.empty() && (frames.empty() || frames.back().number != newest_.back().number))
    frames.push_back(newest_.back());
  return frames;
}

std::vector<KeyFrame> KeyFramePool::frames_for(const SE3& camera_to_world, const LiveSnapshot& snapshot) const {
  std::vector<double> alike(kept_.size(), 0);
  const int last = static_cast<int>(snapshot.timeline.times.size()) - 1;
  for (const auto& [label, known] : snapshot.labels) {
    std::map<std::uint64_t, Look> places; // that any key frame shows
    for (const Kept& kept : kept_) {
      if (const auto looks = kept.looks.find(label); looks != kept.looks.end())
        for (const Look& look : looks->second) places.emplace(look.place, look);
    }
    std::vector<Look> known_places;
    known_places.reserve(places.size());
    for (const auto& [place, look] : places) known_places.push_back(look);
    const auto grid = grids_.find(label);
    const std::vector<Look> wanted = looks_from(camera_to_world.translation(), known_places, known.motion, last,
                                                grid == grids_.end() ? PlaceGrid() : grid->second);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (const auto looks = kept_[i].looks.find(label); looks != kept_[i].looks.end())
        alike[i] += similarity(looks->second, wanted);
    }
  }
  std::vector<std::size_t> order(kept_.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return alike[a] > alike[b]; });
  order.resize(std::min(order.size(), config_.similar));
  std::map<int, KeyFrame> chosen;
  for (const std::size_t i : order) chosen.emplace(kept_[i].frame.number, kept_[i].frame);
  for (const KeyFrame& frame : newest_) chosen.emplace(frame.number, frame);
  std::vector<KeyFrame> frames;
  frames.reserve(chosen.size());
  for (const auto& [number, frame] : chosen) frames.push_back(frame);
  return frames;
}

} // namespace kinora::encode
