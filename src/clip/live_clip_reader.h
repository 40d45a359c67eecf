// What the file of a live clip holds, for read_clip (clip_io.h). docs/container.md, "A live clip", specifies it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "clip/clip.h"
#include "clip/coding/allocation_budget.h"
#include "container/payload.h"

namespace kinora::clip {

/// Takes the updates of a file in their order and decodes the last one that can be understood; memory holds two. Safe
/// for untrusted input. Not thread-safe.
class LiveClipDecoder {
public:
  /// `name`: of the file, for errors. `budget`: of what one update may ask for.
  LiveClipDecoder(std::string name, const AllocationBudget& budget) : name_(std::move(name)), budget_(budget) {}

  /// False, and it is passed over, if its key update is not there. Throws Error(kCorruptInput).
  bool take(container::Payload payload);
  /// The clip as of the last update. Throws Error(kCorruptInput) if there is none, or it contradicts itself.
  Clip decode(const Intrinsics& intrinsics) const;

private:
  std::string location_of(const container::Payload& payload) const;

  std::string name_;
  AllocationBudget budget_;
  std::optional<container::Payload> key_;
  std::uint32_t key_number_ = 0;
  std::optional<container::Payload> update_; ///< behind the key update, and understood with it
};

} // namespace kinora::clip
