#include "tracking/point_products.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/point_products_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kPadded = std::tuple_size_v<PaddedTwist>;
using Numbers = hn::CappedTag<float, kPadded>;

void add_products(std::span<const PointUse> uses, const PointJacobians* points, Block* blocks, float* gradient) {
  const Numbers d;
  for (const PointUse& use : uses) {
    const PointJacobians& point = points[use.point];
    if (point.empty) continue;
    const auto& own = point.by_node[use.slot];
    for (std::size_t part = 0; part < kPadded; part += hn::Lanes(d)) {
      const auto first = hn::LoadU(d, own[0].data() + part);
      const auto second = hn::LoadU(d, own[1].data() + part);
      const auto sum = hn::MulAdd(first, hn::Set(d, point.residuals[0]), hn::LoadU(d, gradient + part));
      hn::StoreU(hn::MulAdd(second, hn::Set(d, point.residuals[1]), sum), d, gradient + part);
      for (std::size_t k = 0; k < use.blocks.size(); ++k) {
        if (use.blocks[k] == PointUse::kNone) continue;
        const auto& other = point.by_node[k];
        Block& block = blocks[use.blocks[k]];
        for (std::size_t c = 0; c < block.columns.size(); ++c) {
          float* column = block.columns[c].data() + part;
          const auto product = hn::MulAdd(first, hn::Set(d, other[0][c]), hn::LoadU(d, column));
          hn::StoreU(hn::MulAdd(second, hn::Set(d, other[1][c]), product), d, column);
        }
      }
    }
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(add_products);

void add_point_products(std::span<const PointUse> uses, std::span<const PointJacobians> points, std::span<Block> blocks,
                        PointJacobians::Row& gradient) {
  HWY_DYNAMIC_DISPATCH(add_products)(uses, points.data(), blocks.data(), gradient.data());
}

} // namespace kinora::tracking
#endif
