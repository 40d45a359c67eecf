#include "obj/obj_writer.h"

#include <span>

#include "common/files.h"
#include "common/mesh_fault.h"
#include "common/number_text.h"
#include "core/error.h"

namespace kinora::formats {
namespace {

constexpr int kPositionDecimals = 5; ///< hundredths of a millimetre
constexpr int kShareDecimals = 4;

void append_vector(std::string& text, const std::array<float, 3>& vector, int decimals) {
  for (const float a : vector) {
    text += ' ';
    append_number(text, a, decimals);
  }
}

/// A name is the rest of a line.
std::string line_of(std::string name) {
  for (char& c : name) {
    if (static_cast<unsigned char>(c) < ' ') c = '_';
  }
  return name;
}

} // namespace

ObjWriter::ObjWriter(std::filesystem::path path, const WorldAxes& axes)
    : path_(std::move(path)), axes_(axes), text_("# Kinora: " + axes.text() + "\n") {
  write_file(path_, {});
}

void ObjWriter::add(const KinoraMesh& mesh) {
  if (const std::string fault = fault_of_colored(mesh); !fault.empty())
    throw Error(ErrorCode::kUsage, path_.string() + ": a mesh cannot be written: " + fault);
  text_ += "o " + line_of(mesh.name) + "\n";
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    text_ += 'v';
    append_vector(text_, axes_.position(mesh.positions + 3 * v), kPositionDecimals);
    for (std::size_t c = 0; c < 3; ++c) {
      text_ += ' ';
      append_number(text_, mesh.colors[3 * v + c] / 255.0, kShareDecimals);
    }
    text_ += '\n';
  }
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    text_ += "vn";
    append_vector(text_, axes_.direction(mesh.normals + 3 * v), kShareDecimals);
    text_ += '\n';
  }
  for (std::size_t f = 0; f < mesh.face_count; ++f) {
    text_ += 'f';
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string number = std::to_string(mesh.faces[3 * f + k] + vertex_count_ + 1);
      text_.append(" ").append(number).append("//").append(number);
    }
    text_ += '\n';
  }
  vertex_count_ += mesh.vertex_count;
}

void ObjWriter::finish() const { write_file(path_, std::as_bytes(std::span(text_))); }

} // namespace kinora::formats
