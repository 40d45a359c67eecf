// The loops that carry hulls and see them from a camera, vectorised with Highway and chosen at run time for the
// processor: points in lanes. tests/fields/rendering/proxy_mesh_test.cpp keeps them equal to Warp, which does the same
// for one point in double precision.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "motion/skinning/deformation_graph.h"
#include "motion/skinning/node_rows.h"

namespace kinora::fields::kernels {

/// Arrays of points are this much longer than what they hold, so that kernels can read and write whole vectors.
inline constexpr std::size_t kPadding = 16;

/// What moves each of many points (tracking::Influence), padded.
struct Influences {
  std::array<std::vector<std::int32_t>, motion::Influence::kMax> nodes; ///< heaviest first
  std::array<std::vector<float>, motion::Influence::kMax> weights;      ///< all 0: nothing moves it
  std::size_t count = 0;

  /// Of n points, to be filled by set().
  explicit Influences(std::size_t n = 0);
  void set(std::size_t point, const motion::Influence& influence);
  bool moves(std::size_t point) const { return weights[0][point] > 0; }
};

/// Where points of a hull are, and how they are turned: a unit quaternion x y z w. Padded.
struct SkinnedPoints {
  std::vector<Eigen::Vector3f> world;
  std::vector<Eigen::Vector4f> rotation;
};

/// Points begin … end of `canonical` (metres, times `scale`) by the blend of their nodes' transforms; not a number
/// where no node moves them. begin: a multiple of kPadding.
void skin(const Influences& influences, const motion::TransformRow* transforms, const Eigen::Vector3f* canonical,
          float scale, std::size_t begin, std::size_t end, SkinnedPoints& skinned);

/// A camera among carried points.
struct Viewpoint {
  Eigen::Matrix3f rotation; ///< world to the camera's frame
  Eigen::Vector3f centre;   ///< of the camera, in the coordinates of the points
  float per_metre;          ///< lattice steps
};

/// corners = the points in the camera's frame; ways = from the camera to them, turned back into canonical space, in
/// lattice steps. begin: a multiple of kPadding.
void project(const Viewpoint& viewpoint, const SkinnedPoints& skinned, std::size_t begin, std::size_t end,
             Eigen::Vector3f* corners, Eigen::Vector3f* view_vectors);

/// Many points, apart by axis; padded.
struct PointLanes {
  std::array<std::vector<float>, 3> axes;

  void resize(std::size_t n) {
    for (auto& values : axes) values.resize(n + kPadding);
  }
  void set(std::size_t i, const Eigen::Vector3f& point) {
    for (std::size_t a = 0; a < 3; ++a) axes[a][i] = point[static_cast<Eigen::Index>(a)];
  }
  Eigen::Vector3f at(std::size_t i) const { return {axes[0][i], axes[1][i], axes[2][i]}; }
};

/// The motion of a posed hull's corners, seen from a camera.
struct CellMotion {
  const std::int32_t* bricks; ///< DensityBricks::index
  int bricks_per_side;
  const std::int32_t* cells_of_brick; ///< per brick eight numbers of cells, x fastest; −1: none
  const std::int32_t* cells;          ///< per cell: corners, x fastest
  int cell_stride;
  const std::int32_t* split_corners; ///< per cell: the first of eight in a row, instead; −1: none
  const Eigen::Vector3f* corners;    ///< in the camera's frame
};

/// Moves n places, in lattice steps, to where the motion interpolated among the corners of their cell carries them to
/// `points`: two of Newton's steps, as long as they lead to cells and are shorter than a cell.
void refine(const CellMotion& motion, std::size_t n, const PointLanes& points, PointLanes& positions);

} // namespace kinora::fields::kernels
