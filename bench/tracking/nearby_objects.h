// The rigid objects of a capture, followed beside the layer that a bench is about.
#pragma once

#include <map>
#include <vector>

#include "tracking/rigid/contact.h"
#include "tracking/rigid/rigid_tracker.h"

namespace kinora::bench {

/// Every label but the background and the layer's own is taken for a rigid object.
class NearbyObjects {
public:
  explicit NearbyObjects(int own_label) : own_label_(own_label) {}

  /// Those that the next frame shows; valid until the frame after.
  std::vector<tracking::NearbyObject> follow(const ingest::Frame& frame) {
    for (const std::uint8_t label : frame.labels.values()) {
      if (label != 0 && label != own_label_) trackers_.try_emplace(label, label);
    }
    std::vector<tracking::NearbyObject> objects;
    for (auto& [label, tracker] : trackers_) {
      tracker.track(frame);
      if (const auto object = tracking::nearby_object(tracker)) objects.push_back(*object);
    }
    return objects;
  }

private:
  int own_label_;
  std::map<int, tracking::RigidTracker> trackers_;
};

} // namespace kinora::bench
