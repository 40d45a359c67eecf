#include "fields/rendering/projected_layer.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kChunk = 1024; // corners

} // namespace

ProjectedLayer::ProjectedLayer(const PosedField& posed, const Camera& camera)
    : layer_(&posed.field->derived()), own_index_(posed.brick_index.get()) {
  const FieldConfig& config = layer_->field.config;
  lattice_per_metre_ = layer_->bricks.resolution() / config.box.side;
  // As far apart as in training, or as the lattice can tell.
  step_ = static_cast<float>(std::max(config.cell_size(), 1 / lattice_per_metre_));
  optical_length_ = static_cast<float>(step_ / config.density_length());
  const SE3 camera_from_world = camera.camera_to_world.inverse();
  if (posed.proxy_mesh == nullptr) {
    const SE3 canonical_from_camera = posed.canonical_to_world.inverse() * camera.camera_to_world;
    rotation_ = rotation_of(posed.canonical_to_world.linear());
    project(canonical_from_camera, canonical_from_camera.inverse());
    return;
  }
  project(*posed.proxy_mesh, camera_from_world);
  const Eigen::Vector3d& centre = camera.camera_to_world.translation();
  if (const auto canonical = posed.warp->to_canonical(centre)) {
    SE3 canonical_from_camera = SE3::Identity();
    const Eigen::Matrix3d rotation = posed.warp->at(*canonical)->linear();
    rotation_ = rotation_of(rotation);
    canonical_from_camera.linear() = rotation.transpose() * camera.camera_to_world.linear();
    canonical_from_camera.translation() = *canonical;
    set_camera(canonical_from_camera);
  }
}

// A rigid layer.
void ProjectedLayer::project(const SE3& canonical_from_camera, const SE3& camera_from_canonical) {
  set_camera(canonical_from_camera);
  const ProxyMesh& proxy_mesh = layer_->proxy_mesh;
  const Eigen::Matrix3f rotation = (camera_from_canonical.linear() * proxy_mesh.lattice_step()).cast<float>();
  const Eigen::Vector3f origin = (camera_from_canonical * proxy_mesh.origin()).cast<float>();
  corners_.resize(proxy_mesh.corner_count());
  view_vectors_.resize(proxy_mesh.corner_count());
  parallel_for(corners_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      corners_[i] = rotation * proxy_mesh.positions()[i] + origin;
      view_vectors_[i] = proxy_mesh.positions()[i] - camera_position_;
    }
  });
  positions_ = &proxy_mesh.positions();
  faces_ = &proxy_mesh.faces();
}

// A deforming one.
void ProjectedLayer::project(const PosedProxyMesh& proxy_mesh, const SE3& camera_from_world) {
  const Eigen::Vector3d centre = camera_from_world.inverse().translation();
  const kernels::Viewpoint viewpoint{camera_from_world.linear().cast<float>(),
                                     (centre - proxy_mesh.origin()).cast<float>(),
                                     static_cast<float>(lattice_per_metre_)};
  corners_.resize(proxy_mesh.positions().size());
  view_vectors_.resize(proxy_mesh.positions().size());
  parallel_for(proxy_mesh.corner_count(), kChunk, [&](const Chunk& chunk) {
    kernels::project(viewpoint, proxy_mesh.corners(), chunk.begin, chunk.end, corners_.data(), view_vectors_.data());
  });
  positions_ = &proxy_mesh.positions();
  faces_ = &proxy_mesh.faces();
  posed_ = &proxy_mesh;
}

void ProjectedLayer::set_camera(const SE3& canonical_from_camera) {
  camera_position_ = to_lattice(canonical_from_camera.translation());
  camera_rotation_ = (canonical_from_camera.linear() * lattice_per_metre_).cast<float>();
  const auto brick = [this](int axis) {
    return static_cast<int>(std::floor(std::clamp(camera_position_[axis], -1e6F, 1e6F) / DensityBricks::kSide));
  };
  const int n = layer_->bricks.bricks_per_side();
  const int number = layer_->bricks.brick_at(brick(0), brick(1), brick(2));
  contains_camera_ = number >= 0 && brick_index()[(brick(2) * n + brick(1)) * n + brick(0)] >= 0;
}

ProjectedLayer::EntryPoint ProjectedLayer::entry_point(const Entry& entry, const TriangleBins& bins,
                                                       const Eigen::Vector3f& ray) const {
  if (entry.triangle == kInside) {
    const Eigen::Vector3f view_vector = camera_rotation_ * ray * entry.depth;
    return {camera_position_ + view_vector, view_vector, rotation_};
  }
  const ProxyTriangle& triangle = bins.triangle(entry.triangle);
  EntryPoint position{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), rotation_};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& row = triangle.rows[i];
    const float share = (row[0] * ray.x() + row[1] * ray.y() + row[2]) * entry.depth;
    position.at += share * (*positions_)[triangle.corners[i]];
    position.view_vector += share * view_vectors_[triangle.corners[i]];
  }
  // It hardly differs from corner to corner.
  if (deforms()) std::copy_n(posed_->corners().rotation[triangle.corners[0]].data(), 4, position.rotation.begin());
  return position;
}

bool ProjectedLayer::motion_at(const Eigen::Vector3f& at, LocalMotion& motion) const {
  constexpr float kSide = ProxyMesh::kCellSide;
  const Eigen::Vector3f in_cells = at / kSide;
  const Eigen::Vector3f low = in_cells.array().floor();
  const int number = layer_->proxy_mesh.cell_at(layer_->bricks, static_cast<int>(low.x()), static_cast<int>(low.y()),
                                                static_cast<int>(low.z()));
  if (number < 0) return false;
  const Eigen::Vector3f f = in_cells - low;
  motion = {Eigen::Vector3f::Zero(), Eigen::Matrix3f::Zero()};
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3f& corner =
        corners_[posed_->corner(static_cast<std::size_t>(number), static_cast<std::size_t>(c))];
    const float wx = (c & 1) ? f.x() : 1 - f.x(), wy = (c & 2) ? f.y() : 1 - f.y(), wz = (c & 4) ? f.z() : 1 - f.z();
    motion.value += wx * wy * wz * corner;
    motion.jacobian.col(0) += ((c & 1) ? 1 : -1) * wy * wz * corner;
    motion.jacobian.col(1) += ((c & 2) ? 1 : -1) * wx * wz * corner;
    motion.jacobian.col(2) += ((c & 4) ? 1 : -1) * wx * wy * corner;
  }
  motion.jacobian /= kSide;
  return true;
}

void ProjectedLayer::refine(std::size_t n, const kernels::PointLanes& points, kernels::PointLanes& positions) const {
  const ProxyMesh& proxy_mesh = layer_->proxy_mesh;
  if (n == 0 || proxy_mesh.cells().empty()) return;
  static_assert(sizeof(ProxyMesh::Cell) % sizeof(std::int32_t) == 0);
  kernels::refine({layer_->bricks.index(), layer_->bricks.bricks_per_side(), proxy_mesh.cells_of_brick().front().data(),
                   reinterpret_cast<const std::int32_t*>(proxy_mesh.cells().front().corners.data()),
                   sizeof(ProxyMesh::Cell) / sizeof(std::int32_t), posed_->split_corners().data(), corners_.data()},
                  n, points, positions);
}

Eigen::Vector3f ProjectedLayer::outward(const Eigen::Vector3f& at) const {
  const float reach = 2 * step_ * static_cast<float>(lattice_per_metre_);
  Eigen::Vector3f less = Eigen::Vector3f::Zero(); // against the gradient of the logarithm of density
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const int axes = offset.cwiseAbs().sum();
    if (axes == 0) continue;
    const Eigen::Vector3f away = offset.cast<float>();
    const Eigen::Vector3f position = at + reach * away;
    less -= layer_->bricks.raw_density({position.x(), position.y(), position.z()}) / static_cast<float>(axes) * away;
  }
  return less;
}

Eigen::Vector3f ProjectedLayer::in_camera(const Eigen::Vector3f& outward, const Eigen::Vector3f& at) const {
  Eigen::Vector3f rotated = Eigen::Vector3f::Zero();
  LocalMotion motion;
  if (!deforms()) {
    rotated = camera_rotation_.transpose() * outward;
  } else if (motion_at(at, motion)) {
    rotated = motion.jacobian.inverse().transpose() * outward;
  }
  const float norm = rotated.norm();
  return norm > 0 && std::isfinite(norm) ? Eigen::Vector3f(rotated / norm) : Eigen::Vector3f::Zero();
}

float ProjectedLayer::confidence_of(const Eigen::Vector3f& at, const Eigen::Vector3f& view_vector) const {
  // A surface is drawn within a sample behind where it was measured.
  const Eigen::Vector3f unit = view_vector.normalized();
  if (!unit.allFinite()) return 0;
  return layer_->confidence->at(to_box(at + step_ * static_cast<float>(lattice_per_metre_) * unit), unit);
}

float ProjectedLayer::confidence_at(const Eigen::Vector3f& at, const Eigen::Vector3f& ray) const {
  if (!layer_->confidence) return 0;
  const Eigen::Vector3f out = outward(at);
  return in_camera(out, at).dot(ray) < 0 ? confidence_of(at, out) : 0;
}

float ProjectedLayer::visible_share(const Eigen::Vector3f& at, const Eigen::Vector3f& ray) const {
  constexpr float kMinConfidence = 0.1F; // below, it fades, so that there is no edge
  if (!layer_->confidence) return 1;
  Eigen::Vector3f back = -camera_rotation_ * ray;
  LocalMotion motion;
  if (deforms() && motion_at(at, motion)) back = -motion.jacobian.inverse() * ray;
  const float from_here = confidence_of(at, back);
  if (from_here >= kMinConfidence) return 1;
  return std::min(1.0F, std::max(from_here, confidence_at(at, ray)) / kMinConfidence);
}

} // namespace kinora::fields
