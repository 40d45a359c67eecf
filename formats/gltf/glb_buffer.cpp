#include "gltf/glb_buffer.h"

#include <bit>
#include <cstring>

#include <meshoptimizer.h>

#include "common/files.h"
#include "core/error.h"

namespace kinora::formats {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kAlignment = 4;
constexpr std::uint32_t kMagic = 0x46546C67;     // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A; // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

std::size_t component_bytes(int component_type) {
  switch (component_type) {
  case 5120:
  case 5121:
    return 1;
  case 5122:
  case 5123:
    return 2;
  default:
    return 4;
  }
}

void append(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const std::size_t end = out.size();
  out.resize(end + bytes.size());
  std::memcpy(out.data() + end, bytes.data(), bytes.size());
}

void append_number(std::vector<std::byte>& out, std::uint32_t number) {
  append(out, std::as_bytes(std::span(&number, 1)));
}

void pad(std::vector<std::byte>& out, std::byte with) {
  out.resize((out.size() + kAlignment - 1) / kAlignment * kAlignment, with);
}

/// As meshoptimizer packs triangles or rows of `stride` bytes.
std::vector<std::byte> packed(std::span<const std::byte> bytes, std::size_t stride, GlbTarget target,
                              GlbFilter filter) {
  const std::size_t count = bytes.size() / stride;
  std::vector<std::byte> filtered;
  if (filter == GlbFilter::kExponential) {
    constexpr int kBits = 16;
    filtered.resize(bytes.size());
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    meshopt_encodeFilterExp(filtered.data(), count, stride, kBits, values.data());
    bytes = filtered;
  }
  std::vector<std::byte> out;
  auto* const to =
      [&](std::size_t bound) {
        out.resize(bound);
        return reinterpret_cast<unsigned char*>(out.data());
      }(target == GlbTarget::kIndices ? meshopt_encodeIndexBufferBound(count, count)
                                      : meshopt_encodeVertexBufferBound(count, stride));
  if (target == GlbTarget::kIndices) {
    std::vector<std::uint32_t> indices(count);
    std::memcpy(indices.data(), bytes.data(), bytes.size());
    out.resize(meshopt_encodeIndexBuffer(to, out.size(), indices.data(), count));
  } else {
    out.resize(meshopt_encodeVertexBuffer(to, out.size(), bytes.data(), count, stride));
  }
  return out;
}

} // namespace

std::size_t GlbBuffer::stride_of(const GlbElements& elements) {
  if (elements.stride > 0) return elements.stride;
  return component_bytes(elements.component_type) * static_cast<std::size_t>(elements.components);
}

int GlbBuffer::add_bytes(std::span<const std::byte> bytes) {
  bytes_.pad(kAlignment);
  views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}});
  bytes_.append(bytes);
  return static_cast<int>(views_.size()) - 1;
}

int GlbBuffer::add_view(std::span<const std::byte> bytes, std::size_t stride, GlbTarget target, GlbFilter filter) {
  int number = 0;
  if (packing_ == GlbPacking::kPlain || bytes.empty()) {
    number = add_bytes(bytes);
  } else {
    const std::vector<std::byte> small = packed(bytes, stride, target, filter);
    number = add_bytes(small);
    nlohmann::json extension = views_.back();
    extension["byteStride"] = stride;
    extension["count"] = bytes.size() / stride;
    extension["mode"] = target == GlbTarget::kIndices ? "TRIANGLES" : "ATTRIBUTES";
    if (filter == GlbFilter::kExponential) extension["filter"] = "EXPONENTIAL";
    views_.back() = {{"buffer", 1},
                     {"byteOffset", unpacked_},
                     {"byteLength", bytes.size()},
                     {"extensions", {{"EXT_meshopt_compression", std::move(extension)}}}};
    unpacked_ += (bytes.size() + kAlignment - 1) / kAlignment * kAlignment;
  }
  if (target != GlbTarget::kNone) views_.back()["target"] = static_cast<int>(target);
  if (target == GlbTarget::kVertices) views_.back()["byteStride"] = stride;
  return number;
}

int GlbBuffer::add_unstored_accessor(std::size_t count, const GlbElements& elements) {
  nlohmann::json accessor = {{"componentType", elements.component_type}, {"count", count}, {"type", elements.type}};
  if (elements.normalized) accessor["normalized"] = true;
  accessors_.push_back(std::move(accessor));
  return static_cast<int>(accessors_.size()) - 1;
}

int GlbBuffer::add_accessor(int view, std::size_t offset, std::size_t count, const GlbElements& elements) {
  const int number = add_unstored_accessor(count, elements);
  accessors_.back()["bufferView"] = view;
  if (offset > 0) accessors_.back()["byteOffset"] = offset;
  return number;
}

void GlbBuffer::describe(nlohmann::json& gltf) const {
  gltf["buffers"] = {{{"byteLength", bytes_.size()}}};
  if (unpacked_ > 0) {
    gltf["buffers"].push_back(
        {{"byteLength", unpacked_}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  }
  gltf["bufferViews"] = views_;
  gltf["accessors"] = accessors_;
}

void write_glb(const std::filesystem::path& path, const nlohmann::json& gltf, ByteSpool& binary) {
  const std::string text = gltf.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::vector<std::byte> head;
  append_number(head, kMagic);
  append_number(head, 2);
  append_number(head, 0); // the whole length, below
  append_number(head, 0); // that of the text
  append_number(head, kJsonChunk);
  const std::size_t text_begin = head.size();
  append(head, std::as_bytes(std::span(text)));
  pad(head, std::byte{' '});
  const auto text_bytes = static_cast<std::uint32_t>(head.size() - text_begin);
  binary.pad(kAlignment);
  const std::size_t total = head.size() + 8 + binary.size();
  if (total > 0xFFFFFFFFU)
    throw Error(ErrorCode::kFailure,
                path.string() + ": a GLB file holds at most 4 GiB; take fewer frames or fewer triangles");
  const auto total_bytes = static_cast<std::uint32_t>(total);
  std::memcpy(head.data() + 8, &total_bytes, sizeof total_bytes);
  std::memcpy(head.data() + 12, &text_bytes, sizeof text_bytes);
  append_number(head, static_cast<std::uint32_t>(binary.size()));
  append_number(head, kBinaryChunk);
  FileWriter file(path);
  file.write(head);
  binary.read([&file](std::span<const std::byte> piece) { file.write(piece); });
  file.finish();
}

} // namespace kinora::formats
