#include "fields/network/instruction_set.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/network/instruction_set_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {

const char* instruction_set() { return hwy::TargetName(HWY_TARGET); }

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(instruction_set);

const char* instruction_set() { return HWY_DYNAMIC_DISPATCH(instruction_set)(); }

} // namespace kinora::fields::kernels
#endif
