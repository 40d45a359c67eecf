// Which labels become layers of the clip, under which name, and how long each is trained.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "encode/frame_pass.h"

namespace kinora::encode {

struct LayerJob {
  const TrackedLabel* label;  ///< of the pass
  std::string name;           ///< of the layer, unique: two labels may have been given one name
  std::size_t rays;           ///< of its whole training, at most
  double decibels_per_second; ///< that it must gain to go on: fields::ExchangeRate
};

struct NotModelled {
  std::string name;
  int label;
  std::string why; ///< one clause
};

struct TrainingPlan {
  std::vector<LayerJob> layers; ///< by label, ascending; empty: nothing can be modelled
  std::vector<NotModelled> not_modelled;
};

/// Empty if the label has a motion; at any moment. One clause.
std::string why_not_followed(const TrackedLabel& label);
/// `wanted`, or that with a number if it is taken; it is taken then.
std::string unique_name(const std::string& wanted, std::set<std::string>& taken);

/// What can be modelled, and what each layer's training may cost: each is asked for the same gain, so that time goes to
/// where most is still to be learnt. The pass must outlive the plan.
TrainingPlan plan_training(const FramePass& pass, const EncodeOptions& options);

} // namespace kinora::encode
