#include "ply/ply_writer.h"

#include <bit>
#include <limits>
#include <span>
#include <string>

#include "common/files.h"
#include "common/mesh_fault.h"
#include "core/error.h"
#include "ply/splats.h"

namespace kinora::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class Value> void append(std::vector<std::byte>& bytes, const Value& value) {
  const auto raw = std::as_bytes(std::span(&value, 1));
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

} // namespace

PlyWriter::PlyWriter(std::filesystem::path path, PlyContent content, const WorldAxes& axes)
    : path_(std::move(path)), content_(content), axes_(axes) {
  write_file(path_, {});
}

void PlyWriter::add(const KinoraMesh& mesh) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::kUsage, path_.string() + ": a mesh cannot be written: " + why);
  };
  if (const std::string fault = fault_of_colored(mesh); !fault.empty()) refuse(fault);
  if (mesh.vertex_count > std::numeric_limits<std::int32_t>::max() - vertex_count_)
    refuse("the file would have more vertices than it can number");
  if (content_ == PlyContent::kSplats) {
    append_splats(mesh);
    return;
  }
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    append(vertices_, axes_.position(mesh.positions + 3 * v));
    append(vertices_, axes_.direction(mesh.normals + 3 * v));
    for (std::size_t c = 0; c < 3; ++c) append(vertices_, mesh.colors[3 * v + c]);
  }
  if (content_ == PlyContent::kMesh) {
    for (std::size_t f = 0; f < mesh.face_count; ++f) {
      append(faces_, std::uint8_t{3});
      for (std::size_t k = 0; k < 3; ++k) append(faces_, mesh.faces[3 * f + k] + vertex_count_);
    }
    face_count_ += mesh.face_count;
  }
  vertex_count_ += static_cast<std::uint32_t>(mesh.vertex_count);
}

void PlyWriter::append_splats(const KinoraMesh& mesh) {
  for (const Splat& splat : splats_of(mesh)) append(vertices_, splat);
  vertex_count_ += static_cast<std::uint32_t>(mesh.vertex_count);
}

void PlyWriter::finish() const {
  const bool splats = content_ == PlyContent::kSplats;
  std::string head = "ply\nformat binary_little_endian 1.0\ncomment Kinora: ";
  head += (splats ? "metres, x right, y down, z forward" : axes_.text()) + "\n" + lines_of(facts_, "comment ");
  head += "element vertex " + std::to_string(vertex_count_) + "\n";
  if (splats) {
    for (const char* name : kSplatProperties) head += std::string("property float ") + name + "\n";
  } else {
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) head += std::string("property float ") + name + "\n";
    for (const char* name : {"red", "green", "blue"}) head += std::string("property uchar ") + name + "\n";
  }
  if (content_ == PlyContent::kMesh)
    head += "element face " + std::to_string(face_count_) + "\nproperty list uchar int vertex_indices\n";
  head += "end_header\n";
  const auto raw = std::as_bytes(std::span(head));
  std::vector<std::byte> bytes(raw.begin(), raw.end());
  bytes.insert(bytes.end(), vertices_.begin(), vertices_.end());
  bytes.insert(bytes.end(), faces_.begin(), faces_.end());
  write_file(path_, bytes);
}

} // namespace kinora::formats
