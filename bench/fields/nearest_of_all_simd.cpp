#include "fields/nearest_of_all.h"

#include <limits>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/nearest_of_all_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::bench::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kFound = NearestOfAll::kFound;

void find_nearest(const float* x, const float* y, const float* z, std::size_t count, const float* point,
                  NearestOfAll::Found* found) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto px = hn::Set(d, point[0]);
  const auto py = hn::Set(d, point[1]);
  const auto pz = hn::Set(d, point[2]);
  found->nodes.fill(-1);
  found->squared_distances.fill(std::numeric_limits<float>::max());
  HWY_ALIGN float nearer[16];
  HWY_ALIGN int numbers[16];
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto dx = hn::Sub(hn::LoadU(d, x + i), px);
    const auto dy = hn::Sub(hn::LoadU(d, y + i), py);
    const auto dz = hn::Sub(hn::LoadU(d, z + i), pz);
    const auto squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto mask = hn::Lt(squared, hn::Set(d, found->squared_distances.back()));
    if (hn::AllFalse(d, mask)) continue;
    const std::size_t here = hn::CompressStore(squared, mask, d, nearer);
    hn::CompressStore(hn::Iota(di, static_cast<int>(i)), hn::RebindMask(di, mask), di, numbers);
    for (std::size_t k = 0; k < here; ++k) {
      if (!(nearer[k] < found->squared_distances.back())) continue;
      std::size_t at = kFound - 1;
      for (; at > 0 && nearer[k] < found->squared_distances[at - 1]; --at) {
        found->squared_distances[at] = found->squared_distances[at - 1];
        found->nodes[at] = found->nodes[at - 1];
      }
      found->squared_distances[at] = nearer[k];
      found->nodes[at] = numbers[k];
    }
  }
}

} // namespace kinora::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::bench {

HWY_EXPORT(find_nearest);

NearestOfAll::NearestOfAll(const std::vector<Eigen::Vector3d>& nodes) : origin_(nodes.front()) {
  constexpr std::size_t kWidest = 16;
  const std::size_t padded = (nodes.size() + kWidest - 1) / kWidest * kWidest;
  for (auto* axis : {&x_, &y_, &z_}) axis->assign(padded, 1e18F);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Vector3f relative = (nodes[i] - origin_).cast<float>();
    x_[i] = relative.x();
    y_[i] = relative.y();
    z_[i] = relative.z();
  }
}

NearestOfAll::Found NearestOfAll::find(const Eigen::Vector3d& point) const {
  const Eigen::Vector3f relative = (point - origin_).cast<float>();
  Found found;
  HWY_DYNAMIC_DISPATCH(find_nearest)(x_.data(), y_.data(), z_.data(), x_.size(), relative.data(), &found);
  return found;
}

} // namespace kinora::bench
#endif
