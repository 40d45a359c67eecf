#include "common/blended_mesh.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "common/boundary.h"
#include "common/pictures.h"

namespace kinora::formats {
namespace {

template <class Row, class Value> void copy_rows(const Value* values, std::size_t count, std::vector<Row>& rows) {
  if (values == nullptr) return;
  rows.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < rows[i].size(); ++k) rows[i][k] = values[i * rows[i].size() + k];
  }
}

void copy_vectors(const float* values, std::size_t count, std::vector<Eigen::Vector3f>& vectors) {
  for (std::size_t i = 0; i < count; ++i) vectors.emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

Eigen::Matrix4f matrix_of(const std::array<float, 4>& rotation, const std::array<float, 3>& translation) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  const Eigen::Quaternionf q(rotation[0], rotation[1], rotation[2], rotation[3]);
  matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
  matrix.topRightCorner<3, 1>() = Eigen::Vector3f(translation[0], translation[1], translation[2]);
  return matrix;
}

} // namespace

BlendedMesh::BlendedMesh(const KinoraMesh& mesh) : name(mesh.name) {
  copy_vectors(mesh.positions, mesh.vertex_count, positions);
  copy_rows(mesh.faces, mesh.face_count, faces);
  if (mesh.texture.data != nullptr) {
    texture = color_of(mesh.texture);
    for (std::size_t v = 0; v < mesh.vertex_count; ++v)
      texture_coordinates.emplace_back(mesh.texture_coordinates[2 * v], mesh.texture_coordinates[2 * v + 1]);
  } else {
    copy_rows(mesh.colors, mesh.vertex_count, colors);
  }
  for (std::size_t j = 0; j < mesh.joint_count; ++j) {
    Eigen::Matrix4f bind;
    for (int i = 0; i < 16; ++i) bind(i / 4, i % 4) = mesh.inverse_bind[16 * j + static_cast<std::size_t>(i)];
    inverse_bind_.push_back(bind);
  }
  copy_rows(mesh.joint_indices, mesh.vertex_count, joint_numbers_);
  copy_rows(mesh.joint_weights, mesh.vertex_count, weights_);
  if (motion() == MeshMotion::kRigid) {
    for (Eigen::Vector3f& p : positions) p = (inverse_bind_[0] * p.homogeneous()).head<3>();
  }
}

MeshMotion BlendedMesh::motion() const {
  if (inverse_bind_.empty()) return MeshMotion::kStill;
  return weights_.empty() ? MeshMotion::kRigid : MeshMotion::kBlended;
}

void BlendedMesh::add(const KinoraMeshPose& pose) {
  times_.push_back(pose.time);
  hidden_.push_back(is_hidden(pose));
  for (std::size_t j = 0; j < pose.joint_count; ++j) {
    const KinoraJoint& given = pose.joints[j];
    Joint joint{};
    std::copy(std::begin(given.rotation), std::end(given.rotation), joint.rotation.begin());
    std::copy(std::begin(given.translation), std::end(given.translation), joint.translation.begin());
    joints_.push_back(joint);
  }
}

SE3 BlendedMesh::transform(std::size_t pose) const {
  const Joint& joint = joints_[pose];
  SE3 transform;
  transform.matrix() = matrix_of(joint.rotation, joint.translation).cast<double>();
  return transform;
}

std::vector<Eigen::Vector3f> BlendedMesh::points(std::size_t pose) const {
  if (motion() != MeshMotion::kBlended) return positions;
  std::vector<Eigen::Matrix4f> carry;
  for (std::size_t j = 0; j < joint_count(); ++j) {
    const Joint& joint = joints_[pose * joint_count() + j];
    carry.emplace_back(matrix_of(joint.rotation, joint.translation) * inverse_bind_[j]);
  }
  std::vector<Eigen::Vector3f> points(positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    Eigen::Vector4f sum = Eigen::Vector4f::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
      if (weights_[v][k] > 0) sum += weights_[v][k] * (carry[joint_numbers_[v][k]] * positions[v].homogeneous());
    }
    points[v] = sum.head<3>();
  }
  return points;
}

KinoraMesh BlendedMesh::still(const float* at) const {
  auto mesh = make_struct<KinoraMesh>();
  mesh.name = name.c_str();
  mesh.vertex_count = positions.size();
  mesh.positions = at;
  mesh.face_count = faces.size();
  mesh.faces = faces.front().data();
  if (!colors.empty()) mesh.colors = colors.front().data();
  if (!texture.empty()) {
    mesh.texture_coordinates = texture_coordinates.front().data();
    mesh.texture = {texture.width(),
                    texture.height(),
                    3,
                    KINORA_PIXEL_U8,
                    3 * static_cast<std::size_t>(texture.width()),
                    texture.data(),
                    {}};
  }
  return mesh;
}

} // namespace kinora::formats
