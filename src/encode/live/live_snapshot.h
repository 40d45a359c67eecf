// What the front end knows at one moment, for those who work beside it.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "encode/front_end.h"

namespace kinora::encode {

struct LabelSnapshot {
  std::string name; ///< of the layer, unique
  motion::Motion motion;
  std::optional<motion::JointPaths> joints; ///< once no frame follows, and of a person
};

/// Plain data, which nobody changes any more.
struct LiveSnapshot {
  clip::Clip timeline;                 ///< as FrontEnd::timeline
  std::map<int, LabelSnapshot> labels; ///< those that have a motion
  bool is_last = false;                ///< no frame follows
};

/// A copy of it, with names of `labels`.
LiveSnapshot snapshot_of(const clip::Clip& timeline, const std::map<int, TrackedLabel>& labels, bool is_last);

} // namespace kinora::encode
