#include "host/mesh_writer.h"

#include "host/image_view.h"
#include "host/interface_struct.h"
#include "host/plugin_table.h"

namespace kinora::host {

MeshWriter::MeshWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                       const Facts& facts)
    : format_(&format), writer_(open_writer(format, KINORA_WRITES_MESHES, "meshes", path, options)) {
  describe_output(format, writer_, facts);
}

std::size_t MeshWriter::add(const Mesh& mesh) {
  auto given = make_struct<KinoraMesh>();
  given.name = mesh.name.c_str();
  given.vertex_count = mesh.positions.size();
  given.positions = numbers_of(mesh.positions);
  given.normals = numbers_of(mesh.normals);
  given.colors = numbers_of(mesh.colors);
  given.face_count = mesh.faces.size();
  given.faces = numbers_of(mesh.faces);
  if (supports(*format_, KINORA_WRITES_TEXTURES) && !mesh.texture.empty()) {
    given.texture_coordinates = numbers_of(mesh.texture_coordinates);
    given.texture = view_of(mesh.texture, KINORA_PIXEL_U8);
  }
  std::vector<float> inverse_bind;
  if (supports(*format_, KINORA_WRITES_SKINS)) {
    for (const SE3& transform : mesh.skin.inverse_bind) {
      for (int i = 0; i < 16; ++i) inverse_bind.push_back(static_cast<float>(transform.matrix()(i / 4, i % 4)));
    }
    given.joint_count = mesh.skin.inverse_bind.size();
    given.inverse_bind = inverse_bind.data();
    given.joint_indices = numbers_of(mesh.skin.joints);
    given.joint_weights = numbers_of(mesh.skin.weights);
  }
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_mesh(writer_.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
  return count_++;
}

void MeshWriter::pose(std::size_t mesh, double time, std::span<const SE3> joint_to_world, bool hidden) {
  if (!supports(*format_, KINORA_WRITES_SKINS)) return;
  std::vector<KinoraJoint> joints;
  for (const SE3& transform : joint_to_world) {
    const Eigen::Quaterniond q(transform.linear());
    const Eigen::Vector3d& t = transform.translation();
    joints.push_back({{q.w(), q.x(), q.y(), q.z()}, {t.x(), t.y(), t.z()}});
  }
  auto given = make_struct<KinoraMeshPose>();
  given.mesh = mesh;
  given.time = time;
  given.joint_count = joints.size();
  given.joints = joints.data();
  given.hidden = hidden && supports(*format_, KINORA_WRITES_HIDDEN) ? 1 : 0;
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_pose(writer_.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
}

} // namespace kinora::host
