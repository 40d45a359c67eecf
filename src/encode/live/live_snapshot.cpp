#include "encode/live/live_snapshot.h"

#include <set>

#include "encode/training_plan.h"

namespace kinora::encode {

LiveSnapshot snapshot_of(const clip::Clip& timeline, const std::map<int, TrackedLabel>& labels, bool is_last) {
  LiveSnapshot snapshot{timeline, {}, is_last};
  std::set<std::string> names;
  for (const auto& [number, label] : labels) {
    const std::string name = unique_name(label.plan.name, names);
    if (why_not_followed(label).empty())
      snapshot.labels.emplace(number, LabelSnapshot{name, label.motion(), label.joints()});
  }
  return snapshot;
}

} // namespace kinora::encode
