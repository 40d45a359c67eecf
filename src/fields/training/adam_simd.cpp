#include "fields/training/adam.h"

#include <algorithm>
#include <bit>

#include "fields/model/field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/training/adam_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kF = FieldConfig::kFeatures;

/// 1/√v to 5e-6 for v ≥ 1e-37: a first guess from the bits (Lomont, "Fast inverse square root", 2003) and two of
/// Newton's steps. The same bits on every processor, and faster than a root and a division.
template <class D> HWY_INLINE hn::Vec<D> inverse_root(D d, hn::Vec<D> v) {
  const hn::RebindToSigned<D> di;
  const auto half = hn::Mul(hn::Set(d, 0.5F), v);
  auto guess = hn::BitCast(d, hn::Sub(hn::Set(di, 0x5F375A86), hn::ShiftRight<1>(hn::BitCast(di, v))));
  for (int step = 0; step < 2; ++step) {
    guess = hn::Mul(guess, hn::NegMulAdd(hn::Mul(half, guess), guess, hn::Set(d, 1.5F)));
  }
  return guess;
}

/// Adam for a vector of parameters, with its constants in registers.
template <class D> class Adam {
public:
  HWY_INLINE explicit Adam(const AdamStep& step)
      : rate_(hn::Set(D(), step.learning_rate)), epsilon_(hn::Set(D(), step.epsilon * step.epsilon)),
        fresh1_(hn::Set(D(), 1 - step.beta1)), beta2_(hn::Set(D(), step.beta2)), fresh2_(hn::Set(D(), 1 - step.beta2)) {
  }

  HWY_INLINE void update(float* parameters, float* gradients, float* first_moments, float* second_moments) const {
    const D d;
    const auto g = hn::LoadU(d, gradients);
    const auto m_before = hn::LoadU(d, first_moments);
    const auto v_before = hn::LoadU(d, second_moments);
    const auto p = hn::LoadU(d, parameters);
    const auto m = hn::MulAdd(fresh1_, hn::Sub(g, m_before), m_before);
    const auto v = hn::MulAdd(beta2_, v_before, hn::Mul(fresh2_, hn::Mul(g, g)));
    const auto next = hn::NegMulAdd(hn::Mul(rate_, m), inverse_root(d, hn::Add(v, epsilon_)), p);
    // A parameter without gradient keeps its value and moments (Müller et al. 2022, sec. 4).
    const auto moved = hn::Ne(g, hn::Zero(d));
    hn::StoreU(hn::IfThenElse(moved, next, p), d, parameters);
    hn::StoreU(hn::IfThenElse(moved, m, m_before), d, first_moments);
    hn::StoreU(hn::IfThenElse(moved, v, v_before), d, second_moments);
    hn::StoreU(hn::Zero(d), d, gradients);
  }

private:
  hn::Vec<D> rate_, epsilon_, fresh1_, beta2_, fresh2_;
};

/// A vector of values as multiples of a step.
template <class D> class Rounding {
public:
  HWY_INLINE explicit Rounding(const Quantiser& quantiser)
      : step_(hn::Set(D(), quantiser.step)), inverse_(hn::Set(D(), 1 / quantiser.step)),
        carry_(hn::Set(D(), 1 - quantiser.up_from)) {}

  HWY_INLINE void round(const float* values, float* quantised) const {
    const D d;
    const auto value = hn::LoadU(d, values);
    const auto steps = hn::Floor(hn::MulAdd(hn::Abs(value), inverse_, carry_));
    const auto size = hn::Mul(hn::Min(steps, hn::Set(d, 32767.0F)), step_);
    hn::StoreU(hn::CopySign(size, value), d, quantised);
  }

private:
  hn::Vec<D> step_, inverse_, carry_;
};

using Narrow = hn::CappedTag<float, kF>;

void quantise(const Quantiser& quantiser, std::size_t count, const float* values, float* quantised) {
  const Rounding<Narrow> rounding(quantiser);
  for (std::size_t i = 0; i < count; i += hn::Lanes(Narrow())) rounding.round(values + i, quantised + i);
}

void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments, const QuantisedCopy* copy) {
  using Wide = hn::CappedTag<float, 16>;
  constexpr std::size_t kLanes = hn::MaxLanes(Wide());
  const Adam<Wide> wide(step);
  const Adam<Narrow> narrow(step);
  const Quantiser quantiser = copy != nullptr ? copy->quantiser : Quantiser{};
  const Rounding<Wide> wide_rounding(quantiser);
  const Rounding<Narrow> narrow_rounding(quantiser);
  const auto touched = [&](std::size_t i) HWY_ATTR {
    return !hn::AllTrue(Wide(), hn::Eq(hn::LoadU(Wide(), gradients + i), hn::Zero(Wide())));
  };
  const auto update_narrow = [&](std::size_t begin, std::size_t end) HWY_ATTR {
    for (std::size_t i = begin; i < end; i += hn::Lanes(Narrow())) {
      narrow.update(parameters + i, gradients + i, first_moments + i, second_moments + i);
      if (copy != nullptr) narrow_rounding.round(parameters + i, copy->values + i);
    }
  };
  // Whole lines of memory: a level may begin in the middle of one.
  const bool aligned = reinterpret_cast<std::uintptr_t>(gradients) % (16 * sizeof(float)) == 0;
  const std::size_t head = aligned ? 0 : std::min<std::size_t>(kF, count);
  update_narrow(0, head);
  // A group is looked at while the one before it is updated: its memory is on the way by then, and no branch is guessed
  // wrong for each vector.
  constexpr std::size_t kGroup = 32;
  const auto find_touched = [&](std::size_t begin) HWY_ATTR {
    std::uint32_t which = 0;
    const std::size_t vectors = begin < count ? std::min(kGroup, (count - begin) / kLanes) : 0;
    for (std::size_t i = 0; i < vectors; ++i) {
      const std::size_t at = begin + i * kLanes;
      if (!touched(at)) continue;
      which |= 1U << i;
      __builtin_prefetch(parameters + at);
      __builtin_prefetch(first_moments + at);
      __builtin_prefetch(second_moments + at);
    }
    return which;
  };
  std::uint32_t next = find_touched(head);
  for (std::size_t begin = head; begin + kLanes <= count; begin += kGroup * kLanes) {
    std::uint32_t which = next;
    next = find_touched(begin + kGroup * kLanes);
    for (; which != 0; which &= which - 1) {
      const std::size_t i = begin + static_cast<std::size_t>(std::countr_zero(which)) * kLanes;
      wide.update(parameters + i, gradients + i, first_moments + i, second_moments + i);
      if (copy != nullptr) wide_rounding.round(parameters + i, copy->values + i);
    }
  }
  update_narrow(head + (count - head) / kLanes * kLanes, count);
}

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(quantise);
HWY_EXPORT(adam);

void quantise(const Quantiser& quantiser, std::size_t count, const float* values, float* quantised) {
  HWY_DYNAMIC_DISPATCH(quantise)(quantiser, count, values, quantised);
}

void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments, const QuantisedCopy* copy) {
  HWY_DYNAMIC_DISPATCH(adam)(step, count, parameters, gradients, first_moments, second_moments, copy);
}

} // namespace kinora::fields::kernels
#endif
