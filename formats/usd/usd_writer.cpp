#include "usd/usd_writer.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/files.h"
#include "common/mesh_fault.h"
#include "core/error.h"
#include "core/image_codec.h"
#include "core/jpeg_writer.h"
#include "usd/usd_text.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr double kDefaultFramesPerSecond = 30;

/// The median distance of the poses that follow one another.
double rate_of(const std::vector<BlendedMesh>& meshes) {
  std::vector<double> steps;
  for (const BlendedMesh& mesh : meshes) {
    for (std::size_t i = 1; i < mesh.times().size(); ++i) steps.push_back(mesh.times()[i] - mesh.times()[i - 1]);
  }
  if (steps.empty()) return kDefaultFramesPerSecond;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  constexpr double kThousand = 1000;
  return std::round(kThousand / *middle) / kThousand;
}

double last_time_of(const std::vector<BlendedMesh>& meshes) {
  double last = 0;
  for (const BlendedMesh& mesh : meshes) last = std::max(last, mesh.times().empty() ? 0 : mesh.times().back());
  return last;
}

/// a/clip.usda, "person" → a/clip_person.jpg
fs::path texture_path(const fs::path& path, const std::string& mesh, bool is_jpeg) {
  return path.parent_path() / (path.stem().string() + "_" + mesh + (is_jpeg ? ".jpg" : ".png"));
}

} // namespace

UsdWriter::UsdWriter(fs::path path, const UsdSettings& settings) : path_(std::move(path)), settings_(settings) {
  write_file(path_, {});
}

void UsdWriter::refuse(const std::string& what) const { throw Error(ErrorCode::kUsage, path_.string() + ": " + what); }

void UsdWriter::add(const KinoraMesh& mesh) {
  if (posed_) refuse("all meshes must come before the first pose");
  if (const std::string fault = fault_of(mesh); !fault.empty()) refuse("a mesh cannot be written: " + fault);
  meshes_.emplace_back(mesh);
}

void UsdWriter::pose(const KinoraMeshPose& pose) {
  posed_ = true;
  if (pose.mesh >= meshes_.size()) refuse("a pose is for a mesh that is not there");
  BlendedMesh& mesh = meshes_[pose.mesh];
  if (pose.joint_count != mesh.joint_count() || pose.joint_count == 0)
    refuse("a pose has not as many joints as its mesh " + mesh.name);
  if (!(pose.time >= 0) || (!mesh.times().empty() && !(pose.time > mesh.times().back())))
    refuse("the times of the poses of " + mesh.name + " are negative or do not increase");
  mesh.add(pose);
}

void UsdWriter::finish() {
  if (meshes_.empty()) throw Error(ErrorCode::kFailure, path_.string() + ": no mesh was written");
  for (const BlendedMesh& mesh : meshes_) {
    if (mesh.joint_count() > 0 && mesh.times().empty())
      throw Error(ErrorCode::kFailure, path_.string() + ": the mesh " + mesh.name + " has joints and no pose");
  }
  const double rate = settings_.frames_per_second > 0 ? settings_.frames_per_second : rate_of(meshes_);
  UsdText text(path_, {rate, last_time_of(meshes_), settings_.axes, facts_});
  std::set<std::string> names;
  for (const BlendedMesh& mesh : meshes_) {
    const std::string name = usd_name(mesh.name, names);
    std::string texture;
    if (!mesh.texture.empty()) {
      const bool is_jpeg = settings_.jpeg_quality > 0;
      const fs::path file = texture_path(path_, name, is_jpeg);
      write_file(file, is_jpeg ? encode_jpeg(mesh.texture, settings_.jpeg_quality) : encode_png(mesh.texture));
      texture = file.filename().string();
    }
    text.add(mesh, name, texture);
  }
  text.finish();
}

} // namespace kinora::formats
