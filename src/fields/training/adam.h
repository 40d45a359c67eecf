// Adam's update of parameters, of which most have no gradient, and what is left of them when they are quantised.
// Sources: Kingma, Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015; Müller et al., "Instant Neural Graphics
// Primitives", ACM TOG 41(4), 2022, sec. 4 (entries without gradient are left alone); Bengio et al., "Estimating or
// Propagating Gradients Through Stochastic Neurons", 2013 (gradients of rounded values move those behind them).
// Vectorised with Highway and chosen at run time for the processor. Thread-safe as long as parameters do not overlap.
#pragma once

#include <cstddef>

namespace kinora::fields::kernels {

/// Adam (Kingma & Ba 2015) without weight decay.
struct AdamStep {
  float learning_rate; ///< with both bias corrections already inside
  float beta1 = 0.9F;
  float beta2 = 0.99F;
  float epsilon = 1e-15F;
};

/// Multiples of a step, 2^15 − 1 of either sign at most.
struct Quantiser {
  float step = 1;       ///< a power of two from 2^-100 to 2^100
  float up_from = 0.5F; ///< what is left of a step that counts as one more
};

/// `count` values (a multiple of kFeatures).
void quantise(const Quantiser& quantiser, std::size_t count, const float* values, float* quantised);

/// The parameters as gradients see them.
struct QuantisedCopy {
  Quantiser quantiser;
  float* values;
};

/// Updates `count` parameters (a multiple of kFeatures) and clears their gradients. One without gradient keeps its
/// value and moments. A copy stays quantise() of the parameters.
void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments, const QuantisedCopy* copy = nullptr);

} // namespace kinora::fields::kernels
