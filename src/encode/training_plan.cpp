#include "encode/training_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace kinora::encode {
namespace {

/// Pixels of a label, in frames where its place is known.
struct PixelCounts {
  std::size_t measured = 0; ///< with reliable depth
  std::size_t extended = 0; ///< with one that is guessed from afar
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

std::size_t rays_of_all(const clip::Clip& clip, const EncodeOptions& options) {
  const Intrinsics& camera = clip.intrinsics;
  const double pixels = static_cast<double>(camera.width) * camera.height * static_cast<double>(clip.times.size());
  const TrainingBudget& budget = options.settings.budget;
  return std::clamp(static_cast<std::size_t>(budget.rays_per_pixel * pixels), budget.min_rays,
                    std::max(budget.min_rays, budget.max_rays));
}

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
  TrainingPlan plan;
  std::vector<double> weights;
  std::set<std::string> names;
  double sum = 0;
  for (const auto& [number, label] : pass.labels) {
    const auto found = counts.find(number);
    const std::string why = found == counts.end() ? "it is in no frame that is trained on" : why_not_followed(label);
    if (!why.empty()) {
      plan.not_modelled.push_back({label.plan.name, number, why});
      continue;
    }
    plan.layers.push_back({&label, unique_name(label.plan.name, names), 0});
    weights.push_back(std::sqrt(static_cast<double>(found->second.measured)));
    sum += weights.back();
  }
  const std::size_t budget = rays_of_all(pass.clip, options);
  for (std::size_t i = 0; i < plan.layers.size(); ++i) {
    // What is guessed from afar is learnt besides: what was measured gets no ray less.
    const PixelCounts& count = counts.at(plan.layers[i].label->plan.label);
    const double all = static_cast<double>(count.measured + count.extended) / static_cast<double>(count.measured);
    plan.layers[i].rays = static_cast<std::size_t>(weights[i] / sum * all * static_cast<double>(budget));
  }
  return plan;
}

} // namespace kinora::encode
