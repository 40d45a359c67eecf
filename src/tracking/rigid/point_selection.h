// Which points of a fused surface take part in aligning it to a view, and which pixels of a view in fusing it.
#pragma once

#include <span>
#include <vector>

#include "tracking/rigid/residuals.h"
#include "tracking/tsdf/tsdf.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// Points that face the camera and fall into the crop: all, if they are at most `max_points`, else as many of each
/// direction of the normal as possible (26 directions), evenly drawn from the order of the surface. The finest texture
/// is the surface's, the coarser ones are NaN.
std::vector<ModelPoint> select_points(std::span<const SurfacePoint> surface, const LayerView& view,
                                      const SE3& model_to_camera, std::size_t max_points);

/// Gives the point the coarse textures that `view` shows of it at the pose; leaves them where it is not seen well.
void add_coarse_texture(const LayerView& view, const SE3& model_to_camera, ModelPoint& point);

/// Takes out of `planes` the pixels that lie before the model by more than max(3 cm, 3σ): something stands there that
/// carries the object's label by mistake.
void remove_occluders(std::span<const SurfacePoint> surface, const SE3& model_to_camera, const LayerView& view,
                      DepthPlanes& planes);

} // namespace kinora::tracking
