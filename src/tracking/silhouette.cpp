#include "tracking/silhouette.h"

#include <algorithm>
#include <utility>

namespace kinora::tracking {
namespace {

class Sweeps {
public:
  explicit Sweeps(const LabelImage& allowed) : offsets_(allowed.width(), allowed.height(), 2) {
    const int far = 2 * (allowed.width() + allowed.height()); // and not nearer after any way across the picture
    for (int v = 0; v < allowed.height(); ++v) {
      for (int u = 0; u < allowed.width(); ++u) {
        if (allowed.at(u, v) == 0) set(u, v, far, far);
      }
    }
  }

  Image<std::int16_t> run() {
    for (int v = 0; v < offsets_.height(); ++v) sweep_row(v, -1);
    for (int v = offsets_.height() - 1; v >= 0; --v) sweep_row(v, 1);
    return std::move(offsets_);
  }

private:
  void set(int u, int v, int du, int dv) {
    offsets_.pixel(u, v)[0] = static_cast<std::int16_t>(du);
    offsets_.pixel(u, v)[1] = static_cast<std::int16_t>(dv);
  }

  bool is_allowed(int u, int v) const {
    const std::int16_t* own = offsets_.pixel(u, v);
    return own[0] == 0 && own[1] == 0;
  }

  // From the row before (`before`: −1 or 1), then along the row both ways.
  void sweep_row(int v, int before) {
    for (int u = 0; u < offsets_.width(); ++u) {
      if (is_allowed(u, v)) continue;
      for (int du = -1; du <= 1; ++du) take(u, v, du, before);
    }
    for (int u = 1; u < offsets_.width(); ++u) take(u, v, -1, 0);
    for (int u = offsets_.width() - 2; u >= 0; --u) take(u, v, 1, 0);
  }

  // What the neighbour knows, if that is nearer.
  void take(int u, int v, int du, int dv) {
    if (!offsets_.contains(u + du, v + dv)) return;
    const std::int16_t* own = offsets_.pixel(u, v);
    const std::int16_t* other = offsets_.pixel(u + du, v + dv);
    const int x = other[0] + du;
    const int y = other[1] + dv;
    if (x * x + y * y < own[0] * own[0] + own[1] * own[1]) set(u, v, x, y);
  }

  Image<std::int16_t> offsets_;
};

} // namespace

Image<std::int16_t> offsets_to_silhouette(const LabelImage& allowed) { return Sweeps(allowed).run(); }

} // namespace kinora::tracking
