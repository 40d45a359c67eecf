// Where somebody stands who looks at a clip that grows: what training on the fly goes for.
#pragma once

#include <mutex>
#include <optional>

#include "core/se3.h"

namespace kinora::cli {

/// Thread-safe.
class AskedView {
public:
  /// Camera to world; nothing: nobody looks any more.
  void set(const std::optional<SE3>& camera_to_world) {
    const std::lock_guard lock(mutex_);
    camera_to_world_ = camera_to_world;
  }
  std::optional<SE3> get() const {
    const std::lock_guard lock(mutex_);
    return camera_to_world_;
  }

private:
  mutable std::mutex mutex_;
  std::optional<SE3> camera_to_world_;
};

} // namespace kinora::cli
