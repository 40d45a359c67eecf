#include "tracking/solver/jacobian_products.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/solver/jacobian_products_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kPadded = std::tuple_size_v<PaddedTwist>;
using Numbers = hn::CappedTag<float, kPadded>;

using Two = hn::CappedTag<float, 2 * kPadded>;

#if HWY_TARGET != HWY_SCALAR
/// Two columns side by side where vectors are that long.
class ColumnPairs {
public:
  static constexpr bool kFit = hn::MaxLanes(Two()) == 2 * kPadded;

  ColumnPairs(const PaddedTwist& first, const PaddedTwist& second) : first_(twice(first)), second_(twice(second)) {}

  HWY_INLINE void add(const PaddedTwist& first, const PaddedTwist& second, Block& block) const {
    const Two d;
    const auto a = twice(first);
    const auto b = twice(second);
    for (std::size_t c = 0; c < block.columns.size(); c += 2) {
      HWY_ALIGN static constexpr std::int32_t kColumns[3][2 * kPadded] = {
          {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1},
          {2, 2, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3},
          {4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5}};
      const auto columns = hn::SetTableIndices(d, kColumns[c / 2]);
      float* pair = block.columns[c].data();
      const auto product = hn::MulAdd(first_, hn::TableLookupLanes(a, columns), hn::LoadU(d, pair));
      hn::StoreU(hn::MulAdd(second_, hn::TableLookupLanes(b, columns), product), d, pair);
    }
  }

private:
  static HWY_INLINE hn::Vec<Two> twice(const PaddedTwist& row) {
    const auto once = hn::LoadU(hn::Half<Two>(), row.data());
    return hn::Combine(Two(), once, once);
  }

  hn::Vec<Two> first_, second_;
};
#endif

/// Column after column.
class SingleColumns {
public:
  static constexpr bool kFit = true;

  SingleColumns(const PaddedTwist& first, const PaddedTwist& second) : first_(first), second_(second) {}

  HWY_INLINE void add(const PaddedTwist& first, const PaddedTwist& second, Block& block) const {
    const Numbers d;
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      for (std::size_t part = 0; part < kPadded; part += hn::Lanes(d)) {
        float* column = block.columns[c].data() + part;
        const auto product = hn::MulAdd(hn::LoadU(d, first_.data() + part), hn::Set(d, first[c]), hn::LoadU(d, column));
        hn::StoreU(hn::MulAdd(hn::LoadU(d, second_.data() + part), hn::Set(d, second[c]), product), d, column);
      }
    }
  }

private:
  const PaddedTwist& first_;
  const PaddedTwist& second_;
};

template <class Columns>
void add_with(std::span<const PointIncidence> uses, const PointJacobians* points, Block* blocks, float* gradient) {
  const Numbers d;
  for (const PointIncidence& use : uses) {
    const PointJacobians& point = points[use.point];
    if (point.empty) continue;
    const auto& jacobian = point.by_node[use.slot];
    for (std::size_t part = 0; part < kPadded; part += hn::Lanes(d)) {
      const auto first = hn::LoadU(d, jacobian[0].data() + part);
      const auto second = hn::LoadU(d, jacobian[1].data() + part);
      const auto sum = hn::MulAdd(first, hn::Set(d, point.residuals[0]), hn::LoadU(d, gradient + part));
      hn::StoreU(hn::MulAdd(second, hn::Set(d, point.residuals[1]), sum), d, gradient + part);
    }
    const Columns columns(jacobian[0], jacobian[1]);
    for (std::size_t k = 0; k < use.blocks.size(); ++k) {
      if (use.blocks[k] == PointIncidence::kNone) continue;
      columns.add(point.by_node[k][0], point.by_node[k][1], blocks[use.blocks[k]]);
    }
  }
}

void add_products(std::span<const PointIncidence> uses, const PointJacobians* points, Block* blocks, float* gradient) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (ColumnPairs::kFit) return add_with<ColumnPairs>(uses, points, blocks, gradient);
#endif
  add_with<SingleColumns>(uses, points, blocks, gradient);
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(add_products);

void add_jacobian_products(std::span<const PointIncidence> uses, std::span<const PointJacobians> points,
                           std::span<Block> blocks, PointJacobians::Row& gradient) {
  HWY_DYNAMIC_DISPATCH(add_products)(uses, points.data(), blocks.data(), gradient.data());
}

} // namespace kinora::tracking
#endif
