// Measuring with other instructions than the best that the machine has.
#pragma once

#include <strings.h>

#include <string>

#include <hwy/targets.h>

#include "core/error.h"

namespace kinora::bench {

/// From now on vectorised kernels use this one of Highway's targets (avx3, avx2, sse4, …, scalar; any case), which the
/// machine must have. Throws Error(kUsage) naming those that it has.
inline void use_instruction_set(const std::string& name) {
  std::string known;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (strcasecmp(name.c_str(), hwy::TargetName(target)) == 0) return hwy::SetSupportedTargetsForTest(target);
    known += std::string(known.empty() ? "" : ", ") + hwy::TargetName(target);
  }
  throw Error(ErrorCode::kUsage, "target=" + name + ": this machine has " + known);
}

} // namespace kinora::bench
