#include "gltf/glb_buffer.h"

#include <bit>

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
  case 5121:
    return 1;
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

} // namespace

int GlbBuffer::add_bytes(std::span<const std::byte> bytes, const GlbElements& elements, GlbTarget target) {
  pad(bytes_, std::byte{0});
  nlohmann::json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
  if (target != GlbTarget::kNone) view["target"] = static_cast<int>(target);
  append(bytes_, bytes);
  const std::size_t element_bytes =
      component_bytes(elements.component_type) * static_cast<std::size_t>(elements.components);
  nlohmann::json accessor = {{"bufferView", views_.size()},
                             {"componentType", elements.component_type},
                             {"count", bytes.size() / element_bytes},
                             {"type", elements.type}};
  if (elements.normalized) accessor["normalized"] = true;
  views_.push_back(std::move(view));
  accessors_.push_back(std::move(accessor));
  return static_cast<int>(accessors_.size()) - 1;
}

void GlbBuffer::add_range(std::span<const float> values, int components) {
  const auto width = static_cast<std::size_t>(components);
  std::vector<float> low(values.begin(), values.begin() + components);
  std::vector<float> high = low;
  for (std::size_t i = 0; i < values.size(); ++i) {
    low[i % width] = std::min(low[i % width], values[i]);
    high[i % width] = std::max(high[i % width], values[i]);
  }
  accessors_.back()["min"] = low;
  accessors_.back()["max"] = high;
}

void GlbBuffer::describe(nlohmann::json& gltf) const {
  gltf["buffers"] = {{{"byteLength", bytes_.size()}}};
  gltf["bufferViews"] = views_;
  gltf["accessors"] = accessors_;
}

std::vector<std::byte> glb_file(const nlohmann::json& gltf, std::span<const std::byte> binary,
                                const std::string& location) {
  const std::string text = gltf.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::vector<std::byte> json;
  append(json, std::as_bytes(std::span(text)));
  pad(json, std::byte{' '});
  std::vector<std::byte> data(binary.begin(), binary.end());
  pad(data, std::byte{0});
  const std::size_t total = 12 + 8 + json.size() + 8 + data.size();
  if (total > 0xFFFFFFFFU)
    throw Error(ErrorCode::kFailure,
                location + ": a GLB file holds at most 4 GiB; take fewer frames or fewer triangles");
  std::vector<std::byte> file;
  file.reserve(total);
  append_number(file, kMagic);
  append_number(file, 2);
  append_number(file, static_cast<std::uint32_t>(total));
  append_number(file, static_cast<std::uint32_t>(json.size()));
  append_number(file, kJsonChunk);
  append(file, json);
  append_number(file, static_cast<std::uint32_t>(data.size()));
  append_number(file, kBinaryChunk);
  append(file, data);
  return file;
}

} // namespace kinora::formats
