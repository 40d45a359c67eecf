#include "gltf_scene/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "core/error.h"

namespace kinora::formats {
namespace {

constexpr std::size_t kMaxNumbers = std::size_t{1} << 27;

/// Where elements lie: `stride` bytes from one to the next.
struct Elements {
  std::span<const unsigned char> bytes;
  std::size_t stride = 0;
};

class Accessors {
public:
  Accessors(const tinygltf::Model& model, const std::string& source) : model_(model), source_(source) {}

  GltfNumbers read(int index) const {
    const tinygltf::Accessor& accessor = at(model_.accessors, index, "an accessor");
    const int width = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
    const int bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
    if (width < 1 || bytes < 1) fail("an accessor is of an unknown type");
    GltfNumbers numbers{static_cast<std::size_t>(width), accessor.count, {}};
    if (numbers.count < 1 || numbers.count > kMaxNumbers / numbers.width) fail("an accessor's length is absurd");
    const std::size_t element = numbers.width * static_cast<std::size_t>(bytes);
    if (accessor.bufferView >= 0) {
      const Elements elements = elements_of(accessor.bufferView, accessor.byteOffset, element, accessor.count);
      numbers.values.resize(numbers.width * numbers.count);
      copy(elements, numbers.count, numbers.width, accessor, numbers.values.data());
    } else if (accessor.sparse.isSparse) {
      if (accessor.sparse.count < 0 || numbers.count > kMaxSparse) fail("an accessor's length is absurd");
      numbers.values.resize(numbers.width * numbers.count);
    } else {
      fail("an accessor has no numbers");
    }
    if (accessor.sparse.isSparse) replace(accessor, element, numbers);
    if (!std::ranges::all_of(numbers.values, [](double value) { return std::isfinite(value); }))
      fail("a number is not finite");
    return numbers;
  }

private:
  static constexpr std::size_t kMaxSparse = std::size_t{1} << 20; // elements that no byte of the file stands for

  [[noreturn]] void fail(const std::string& problem) const {
    throw Error(ErrorCode::kCorruptInput, source_ + ": " + problem);
  }

  template <class T> const T& at(const std::vector<T>& list, int index, const char* what) const {
    if (index < 0 || static_cast<std::size_t>(index) >= list.size()) fail(std::string(what) + " is not there");
    return list[static_cast<std::size_t>(index)];
  }

  Elements elements_of(int view_index, std::size_t offset, std::size_t element, std::size_t count) const {
    const tinygltf::BufferView& view = at(model_.bufferViews, view_index, "a buffer view");
    const tinygltf::Buffer& buffer = at(model_.buffers, view.buffer, "a buffer");
    if (view.byteOffset > buffer.data.size() || view.byteLength > buffer.data.size() - view.byteOffset)
      fail("a buffer view reaches beyond its buffer");
    const std::size_t stride = view.byteStride == 0 ? element : view.byteStride;
    if (stride < element || stride > 4096 || offset > view.byteLength ||
        (count - 1) > (view.byteLength - offset) / stride || (count - 1) * stride + element > view.byteLength - offset)
      fail("an accessor reaches beyond its buffer");
    return {std::span(buffer.data).subspan(view.byteOffset + offset), stride};
  }

  template <class T> static double number(const unsigned char* from, bool normalized) {
    T value;
    std::memcpy(&value, from, sizeof value);
    if (!normalized || !std::numeric_limits<T>::is_integer) return static_cast<double>(value);
    return std::max(static_cast<double>(value) / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
  }

  double number_of(const unsigned char* from, int type, bool normalized) const {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return number<std::int8_t>(from, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return number<std::uint8_t>(from, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return number<std::int16_t>(from, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return number<std::uint16_t>(from, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return number<std::uint32_t>(from, normalized);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return number<float>(from, normalized);
    default:
      fail("an accessor's numbers are of an unknown type");
    }
  }

  void copy(const Elements& elements, std::size_t count, std::size_t width, const tinygltf::Accessor& accessor,
            double* to) const {
    const auto bytes =
        static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType)));
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < width; ++c)
        *to++ = number_of(elements.bytes.data() + i * elements.stride + c * bytes, accessor.componentType,
                          accessor.normalized);
  }

  void replace(const tinygltf::Accessor& accessor, std::size_t element, GltfNumbers& numbers) const {
    const auto& sparse = accessor.sparse;
    if (sparse.count == 0) return;
    const int bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(sparse.indices.componentType));
    if (sparse.count < 0 || bytes < 1 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
      fail("a sparse accessor is absurd");
    const auto count = static_cast<std::size_t>(sparse.count);
    const Elements places = elements_of(sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                                        static_cast<std::size_t>(bytes), count);
    const Elements values =
        elements_of(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset), element, count);
    for (std::size_t i = 0; i < count; ++i) {
      const double place = number_of(places.bytes.data() + i * places.stride, sparse.indices.componentType, false);
      if (!(place >= 0 && place < static_cast<double>(numbers.count))) fail("a sparse accessor is absurd");
      const Elements one{values.bytes.subspan(i * values.stride), values.stride};
      copy(one, 1, numbers.width, accessor, numbers.values.data() + static_cast<std::size_t>(place) * numbers.width);
    }
  }

  const tinygltf::Model& model_;
  const std::string& source_;
};

} // namespace

GltfNumbers read_accessor(const tinygltf::Model& model, int accessor, const std::string& source) {
  return Accessors(model, source).read(accessor);
}

} // namespace kinora::formats
