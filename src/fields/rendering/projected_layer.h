// One layer as one camera sees it: its hull in the camera's frame, and the way from a pixel to canonical space.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fields/network/vector_features.h"
#include "fields/rendering/rasterizer.h"
#include "fields/rendering/renderer.h"

namespace kinora::fields {

/// What is derived from a field once, to draw it.
struct DrawableField::Derived {
  explicit Derived(std::shared_ptr<const Field> drawn) : shared(std::move(drawn)), field(*shared) {}

  std::shared_ptr<const Field> shared;
  const Field& field;
  std::vector<GridLevel> levels;                    ///< stored_levels()
  std::vector<float> surface_matrix, vector_matrix; ///< fields/field_batch.h
  DensityBricks bricks;
  ProxyMesh proxy_mesh;
  std::optional<Confidence> confidence;
};

inline constexpr float kNearDepth = 0.02F; ///< metres: nothing nearer is drawn
/// Entry::triangle of rays that begin inside of a hull, before the camera.
inline constexpr std::uint32_t kInside = 0xFFFFFFFF;

/// Lattice coordinates are those of the layer's bricks. Immutable, thread-safe; what it was made from must outlive it.
class ProjectedLayer {
public:
  ProjectedLayer(const PosedField& posed, const Camera& camera);

  const DrawableField::Derived& layer() const { return *layer_; }
  float step() const { return step_; }                                              ///< metres between samples
  float lattice_step() const { return static_cast<float>(1 / lattice_per_metre_); } ///< metres
  float optical_length() const { return optical_length_; }                          ///< of a step
  const std::vector<Eigen::Vector3f>& corners() const { return corners_; }          ///< in the camera's frame, metres
  const std::vector<ProxyFace>& faces() const { return *faces_; }
  bool contains_camera() const { return contains_camera_; }
  /// As DensityBricks::index: of the bricks that are there.
  const std::int32_t* brick_index() const {
    return own_index_ == nullptr ? layer_->bricks.index() : own_index_->data();
  }
  bool lacks_bricks() const { return own_index_ != nullptr; }                   ///< some are not there yet
  const std::vector<Eigen::Vector3f>& positions() const { return *positions_; } ///< of the corners, lattice steps
  /// From the camera to the corners, turned into canonical space, lattice steps.
  const std::vector<Eigen::Vector3f>& view_vectors() const { return view_vectors_; }
  const PosedProxyMesh* posed() const { return posed_; }                      ///< null unless the layer deforms
  const Eigen::Vector3f& camera_position() const { return camera_position_; } ///< lattice steps
  const Eigen::Matrix3f& camera_rotation() const { return camera_rotation_; } ///< camera's frame to lattice steps
  const Rotation& rotation() const { return rotation_; } ///< of a layer that does not deform, or at the camera

  /// Where a ray of the camera, (x, y, 1) in its frame, is at an entry's depth, and its way from the camera to there.
  struct EntryPoint {
    Eigen::Vector3f at;
    Eigen::Vector3f view_vector;
    Rotation rotation; ///< of the layer
  };
  EntryPoint entry_point(const Entry& entry, const TriangleBins& bins, const Eigen::Vector3f& ray) const;
  /// Moves n places to where the layer's motion, interpolated among the corners of their cell, carries them to `points`
  /// in the camera's frame (kernels::refine). Only for layers that deform.
  void refine(std::size_t n, const kernels::PointLanes& points, kernels::PointLanes& positions) const;
  bool deforms() const { return posed_ != nullptr; }
  /// Unit normal, in the camera's frame, of the surface of equal density at a place, out of what is dense; zero where
  /// none can be told. From 27 places up to two samples' distance away on each axis, as trained density is rough.
  /// Source: Zucker, Hummel, "A Three-Dimensional Edge Operator", IEEE PAMI 3(3), 1981.
  Eigen::Vector3f normal_at(const Eigen::Vector3f& at) const { return in_camera(outward(at), at); }
  /// 0…1: how well the capture's cameras saw the surface at a place, as a ray of the camera meets it; 0 where it meets
  /// the inside, which no camera can have seen.
  float confidence_at(const Eigen::Vector3f& at, const Eigen::Vector3f& ray) const;
  /// What is left of a surface when what no camera saw fades: all of it where its side was seen, or the place from
  /// where the camera stands, whatever normal its rough density has there; 0 where neither was.
  float visible_share(const Eigen::Vector3f& at, const Eigen::Vector3f& ray) const;
  Eigen::Vector3f from_box(const std::array<float, 3>& position) const {
    return Eigen::Map<const Eigen::Vector3f>(position.data()) * static_cast<float>(layer_->bricks.resolution());
  }
  /// A place, or a way, relative to the field's box.
  std::array<float, 3> to_box(const Eigen::Vector3f& lattice) const {
    const float scale = 1.0F / static_cast<float>(layer_->bricks.resolution());
    return {lattice.x() * scale, lattice.y() * scale, lattice.z() * scale};
  }

private:
  /// The layer's motion near a place: interpolated among the corners of its cell.
  struct LocalMotion {
    Eigen::Vector3f value;    // camera's frame, metres
    Eigen::Matrix3f jacobian; // metres per lattice step
  };
  bool motion_at(const Eigen::Vector3f& at, LocalMotion& motion) const;
  float confidence_of(const Eigen::Vector3f& at,
                      const Eigen::Vector3f& view_vector) const; // out of the surface, canonical
  Eigen::Vector3f outward(const Eigen::Vector3f& at) const;      // as normal_at, in canonical space, of any length
  Eigen::Vector3f in_camera(const Eigen::Vector3f& outward, const Eigen::Vector3f& at) const;
  void project(const SE3& canonical_from_camera, const SE3& camera_from_canonical);
  void project(const PosedProxyMesh& proxy_mesh, const SE3& camera_from_world);
  void set_camera(const SE3& canonical_from_camera);
  Eigen::Vector3f to_lattice(const Eigen::Vector3d& canonical) const {
    return ((canonical - layer_->field.config.box.origin) * lattice_per_metre_).cast<float>();
  }

  const DrawableField::Derived* layer_;
  double lattice_per_metre_;
  float step_;
  float optical_length_;
  std::vector<Eigen::Vector3f> corners_;
  const std::vector<Eigen::Vector3f>* positions_ = nullptr; // of the corners, lattice
  std::vector<Eigen::Vector3f> view_vectors_; // from the camera to the corners, turned into canonical space, lattice
  const std::vector<ProxyFace>* faces_ = nullptr;
  const PosedProxyMesh* posed_ = nullptr;                // of a layer that deforms
  const std::vector<std::int32_t>* own_index_ = nullptr; // where bricks are not there yet
  bool contains_camera_ = false;
  Eigen::Vector3f camera_position_ = Eigen::Vector3f::Zero();     // lattice
  Eigen::Matrix3f camera_rotation_ = Eigen::Matrix3f::Identity(); // camera's frame to lattice
  Rotation rotation_ = kNoRotation;                               // of a layer that does not deform, or at the camera
};

} // namespace kinora::fields
