// Adam's update of parameters, of which most have no gradient.
// Sources: Kingma, Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015; Müller et al., "Instant Neural Graphics
// Primitives", ACM TOG 41(4), 2022, sec. 4 (entries without gradient are left alone).
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

/// Updates `count` parameters (a multiple of kFeatures) and clears their gradients. One without gradient keeps its
/// value and moments.
void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments);

} // namespace kinora::fields::kernels
