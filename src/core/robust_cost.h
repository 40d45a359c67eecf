// Costs of residuals that outliers do not dominate, and the weights with which iteratively reweighted least squares
// minimises them: a residual r with weight w(r) has the gradient of its cost. In lanes: robust_cost_simd.h.
// Sources: Huber, "Robust Estimation of a Location Parameter", Annals of Mathematical Statistics 1964; Geman and
// McClure, "Statistical Methods for Tomographic Image Reconstruction", Bulletin of the ISI 1987; survey: Zhang,
// "Parameter Estimation Techniques", Image and Vision Computing 1997.
#pragma once

#include <algorithm>
#include <cmath>

namespace kinora {

/// Standard deviations up to which residuals are taken for normal errors: then 96 % as efficient as least squares.
inline constexpr double kHuberThreshold = 1.5;

/// r²/2 up to a threshold, and grows linearly from there.
struct Huber {
  double threshold; ///< in the unit of r, mostly standard deviations

  double cost(double r) const {
    const double size = std::abs(r);
    return size <= threshold ? 0.5 * r * r : threshold * (size - 0.5 * threshold);
  }
  double weight(double r) const {
    const double size = std::abs(r);
    return size <= threshold ? 1.0 : threshold / size;
  }
};

/// Huber's, but none costs more than a residual of 2.5 thresholds does. It keeps Huber's weights: what is farther off
/// still draws. `max_cost` is also for a point without correspondence; then neither losing nor finding a bad one pays.
struct TruncatedHuber {
  double threshold;

  constexpr double max_cost() const { return 2 * threshold * threshold; }
  double cost(double r) const { return std::min(max_cost(), Huber{threshold}.cost(r)); }
  double weight(double r) const { return Huber{threshold}.weight(r); }
};

/// About (r/σ)² for small residuals, below (cutoff/σ)² for all: what lies far beyond the cutoff hardly draws.
struct GemanMcClure {
  double sigma;  ///< in the unit of r
  double cutoff; ///< likewise

  /// `squared`: r²
  double cost(double squared) const { return squared / (1 + squared / (cutoff * cutoff)) / (sigma * sigma); }
  /// Of r²/σ² in the sum of squares that is minimised.
  double weight(double squared) const {
    const double share = 1 / (1 + squared / (cutoff * cutoff));
    return share * share;
  }
};

} // namespace kinora
