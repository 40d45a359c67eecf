#include "encode/training_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace kinora::encode {
namespace {

/// Pixels of each label that are measured, in frames where its place is known, and that were guessed from afar there.
struct PixelCounts {
  std::size_t measured = 0;
  std::size_t extended = 0;
};

std::map<int, PixelCounts> stored_by_label(const FramePass& pass) {
  std::map<int, PixelCounts> counts;
  for (const fields::StoredFrame& frame : pass.pixels.frames()) {
    std::array<PixelCounts, 256> in_frame{};
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const fields::StoredPixel& pixel = pass.pixels.pixels()[i];
      if (pixel.depth.is_measured()) ++in_frame[pixel.label].measured;
      if (pixel.depth.is_extended()) ++in_frame[pixel.label].extended;
    }
    for (const auto& [number, label] : pass.labels) {
      const auto f = static_cast<std::size_t>(frame.frame);
      const bool lost = f < label.poses.size() && label.poses[f].health == motion::Health::kLost;
      const PixelCounts& here = in_frame[static_cast<std::size_t>(number)];
      if (lost || here.measured == 0) continue;
      counts[number].measured += here.measured;
      counts[number].extended += here.extended;
    }
  }
  return counts;
}

/// A second for each frame is worth the same in captures of different lengths; what is very short is not hurried, and
/// of what is very long more can be learnt in any case.
double frames_to_pay_for(std::size_t frames) { return std::clamp(static_cast<double>(frames), 30.0, 300.0); }

} // namespace

std::string why_not_followed(const TrackedLabel& label) {
  const auto lost = [](const auto& pose) { return pose.health == motion::Health::kLost; };
  const bool is_lost = label.tracker && std::all_of(label.poses.begin(), label.poses.end(), lost);
  const bool bends = label.plan.motion == motion::MotionKind::kDeforming;
  const bool was_seen = label.layer || (label.deforming_tracker && label.deforming_tracker->was_seen());
  return is_lost || (bends && !was_seen) ? "too little of it is measured in every frame to follow it" : "";
}

std::string unique_name(const std::string& wanted, std::set<std::string>& taken) {
  std::string name = wanted;
  for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}{}", wanted, i);
  return name;
}

TrainingPlan plan_training(const FramePass& pass, const EncodeOptions& options) {
  const auto counts = stored_by_label(pass);
  const TrainingBudget& budget = options.settings.budget;
  const double price = budget.decibels_per_second / frames_to_pay_for(pass.clip.times.size());
  TrainingPlan plan;
  std::set<std::string> names;
  for (const auto& [number, label] : pass.labels) {
    const auto found = counts.find(number);
    const std::string why = found == counts.end() ? "it is in no frame that is trained on" : why_not_followed(label);
    if (!why.empty()) {
      plan.not_modelled.push_back({label.plan.name, number, why});
      continue;
    }
    const auto pixels = static_cast<double>(found->second.measured + found->second.extended);
    const double looks = label.layer ? budget.deforming_rays_per_pixel : budget.rays_per_pixel;
    plan.layers.push_back(
        {&label, unique_name(label.plan.name, names), static_cast<std::size_t>(looks * pixels), price});
  }
  return plan;
}

} // namespace kinora::encode
