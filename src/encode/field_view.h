// What a layer's field shows where pixels of a frame look, beside what these show: what poses and motion are aligned
// by. Source: direct alignment as in Engel et al., "Direct Sparse Odometry", TPAMI 40(3), 2018, through a radiance
// field.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "fields/sampling/layer_observations.h"
#include "fields/training/ray_response.h"

namespace kinora::encode {

/// Some thousand pixels of one frame, of the layer's surface and on either side of its rim. The field, the layer's
/// pixels and the frame must outlive it.
class FieldView {
public:
  FieldView(const fields::Field& field, const fields::LayerObservations& layer, const fields::StoredFrame& frame);

  /// About what a pixel shows: point + t · direction for |t| ≤ reach, in metres of depth.
  struct Ray {
    Eigen::Vector3d point; ///< world, metres
    Eigen::Vector3d direction;
    double reach;
  };
  /// Writes rays in canonical space, one for each. Called from many threads.
  using ToCanonical = std::function<void(std::span<const Ray> rays, fields::CanonicalRay* canonical)>;

  /// Looks at the field along all rays; `jacobian`: with slopes, which stay those of the last look with them.
  void evaluate(bool jacobian, const ToCanonical& to_canonical);

  std::size_t size() const { return probes_.size(); }
  /// Of the surface that the pixel shows, canonical, metres; not a number if there is none.
  const Eigen::Vector3d& position(std::size_t i) const { return positions_[i]; }
  /// When the pixel is read (row_time()).
  double time(std::size_t i) const {
    return row_time(pixels_.pixels()[probes_[i].pixel].v, frame_.camera.intrinsics.height);
  }
  /// Of a value (RayResponse) by a displacement of the ray, per metre.
  const Eigen::Vector3d& gradient(std::size_t i, std::size_t value) const { return responses_[i].jacobian[value]; }
  /// What the field shows less what the pixel does; nothing where one of them shows nothing.
  std::optional<double> residual(std::size_t i, std::size_t value) const;
  /// Of a residual, by the typical difference of colour: 1 / standard deviation.
  double weight(std::size_t i, std::size_t value, double color_sigma) const;

  /// Typical difference of colour away from the rim (robust deviation, of 1); nothing with too few pixels.
  std::optional<double> color_sigma() const;
  /// Of all colours and opacities, each bounded: a pixel that shows the layer where the field shows nothing costs the
  /// most.
  double cost(double color_sigma) const;

private:
  /// A pixel and the depth about which its ray is looked at.
  struct Probe {
    std::uint32_t pixel;
    float depth;
    bool foreground;
    bool on_contour;
  };

  void choose_probes(const fields::LayerObservations& layer);
  bool has_color(std::size_t i) const {
    return probes_[i].foreground && positions_[i].allFinite() && responses_[i].is_opaque;
  }

  const fields::Field& field_;
  std::vector<fields::GridLevel> levels_;
  const fields::PixelStore& pixels_;
  const fields::StoredFrame& frame_;
  std::vector<Probe> probes_;
  std::vector<fields::RayResponse> responses_;
  std::vector<Eigen::Vector3d> positions_;
};

/// Typical difference of colour (FieldView::color_sigma) before and after something was moved.
struct ColorFit {
  double before, after;
};

} // namespace kinora::encode
