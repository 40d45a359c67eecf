#include "tracking/view/deforming_view.h"

#include <algorithm>
#include <cmath>

namespace kinora::tracking {

LayerView view_layer(const ingest::Frame& frame, int label) {
  if (frame.has_labels()) return view_label(frame, label);
  if (frame.color.empty()) return {};
  ingest::Frame whole = frame;
  whole.labels = LabelImage(frame.color.width(), frame.color.height(), 1, static_cast<std::uint8_t>(label));
  return view_label(whole, label);
}

double measured_area(const LayerView& view) {
  double area = 0;
  for (int v = 0; v < view.intrinsics.height; ++v) {
    for (int u = 0; u < view.intrinsics.width; ++u) {
      if (view.planes.weights.at(u, v) <= 0) continue;
      const Eigen::Vector3d point = view.point(u, v);
      const float* plane = view.planes.planes.pixel(u, v);
      const double cosine = std::abs(plane[0] * point.x() + plane[1] * point.y() + plane[2] * point.z()) / point.norm();
      area += point.z() * point.z() / std::max(0.2, cosine);
    }
  }
  return area / (view.intrinsics.fx * view.intrinsics.fy);
}

} // namespace kinora::tracking
