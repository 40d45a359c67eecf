// The binary part of a GLB file and the JSON that describes it: buffer views and accessors.
// Source: Khronos Group, "glTF 2.0 Specification" (2021), sections 3.6 and 4.4; EXT_meshopt_compression.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/byte_spool.h"

namespace kinora::formats {

/// What an accessor's bytes are for.
enum class GlbTarget { kNone = 0, kVertices = 34962, kIndices = 34963 };

/// How an accessor reads its bytes.
struct GlbElements {
  int component_type;      ///< 5121 u8, 5123 u16, 5125 u32, 5126 float
  const char* type;        ///< "SCALAR", "VEC3", "VEC4", "MAT4"
  int components;          ///< that `type` has
  bool normalized = false; ///< integers stand for numbers up to 1
  bool with_range = false; ///< smallest and largest values are stated
  std::size_t stride = 0;  ///< bytes from one element to the next; 0: they are packed
};

/// How buffer views are stored: as they are, or so that EXT_meshopt_compression unpacks them.
enum class GlbPacking { kPlain, kMeshopt };

/// What EXT_meshopt_compression does after unpacking.
enum class GlbFilter { kNone, kExponential };

inline constexpr GlbElements kGlbScalars = {5126, "SCALAR", 1, false, true}; // times: their range is required
inline constexpr GlbElements kGlbWeights = {5126, "SCALAR", 1};
inline constexpr GlbElements kGlbPositions = {5126, "VEC3", 3, false, true}; // here too
inline constexpr GlbElements kGlbVectors = {5126, "VEC3", 3};
inline constexpr GlbElements kGlbQuaternions = {5126, "VEC4", 4};
inline constexpr GlbElements kGlbRotations = {5122, "VEC4", 4, true};             // quaternions in 1/32767
inline constexpr GlbElements kGlbBoxPositions = {5123, "VEC3", 3, true, true, 8}; // in 1/65535 of a box
inline constexpr GlbElements kGlbBoxWays = {5122, "VEC3", 3, true, true, 8};      // in 1/32767 of a box
inline constexpr GlbElements kGlbByteNormals = {5120, "VEC3", 3, true, false, 4}; // in 1/127
inline constexpr GlbElements kGlbTextureFloats = {5126, "VEC2", 2};               // in floats
inline constexpr GlbElements kGlbTexturePlaces = {5123, "VEC2", 2, true};         // in 1/65535
inline constexpr GlbElements kGlbMatrices = {5126, "MAT4", 16};
inline constexpr GlbElements kGlbShares = {5123, "VEC4", 4, true};
inline constexpr GlbElements kGlbNumbers = {5123, "VEC4", 4};
inline constexpr GlbElements kGlbIndices = {5125, "SCALAR", 1};

/// One buffer that grows. Numbers must be in little-endian order, as all machines that Kinora runs on have it.
class GlbBuffer {
public:
  /// `output`: the file that it becomes a part of; long buffers wait beside it (byte_spool.h).
  GlbBuffer(std::filesystem::path output, GlbPacking packing) : packing_(packing), bytes_(std::move(output)) {}

  /// Appends values as a buffer view of their own and returns the number of the accessor that reads them.
  template <class Value> int add(std::span<const Value> values, const GlbElements& elements, GlbTarget target) {
    const std::size_t stride = stride_of(elements);
    const int view = add_view(std::as_bytes(values), stride, target);
    const int accessor = add_accessor(view, 0, values.size_bytes() / stride, elements);
    if constexpr (std::is_arithmetic_v<Value>) {
      if (elements.with_range) add_range(values, elements.components, stride / sizeof(Value));
    }
    return accessor;
  }

  /// Bytes that several accessors read, `stride` of them per element. With kExponential they are floats, of which those
  /// of one element keep 16 bits together; plain buffers keep them as they are. Returns the view's number.
  int add_view(std::span<const std::byte> bytes, std::size_t stride, GlbTarget target,
               GlbFilter filter = GlbFilter::kNone);
  /// Reads `count` elements of a view from `offset` bytes on.
  int add_accessor(int view, std::size_t offset, std::size_t count, const GlbElements& elements);
  /// An accessor whose values stand elsewhere; give it its range with add_range().
  int add_unstored_accessor(std::size_t count, const GlbElements& elements);
  /// Bytes that no accessor reads, such as a picture; never packed. Returns the view's number.
  int add_bytes(std::span<const std::byte> bytes);
  /// Smallest and largest values of the last accessor; elements are `stride` values apart.
  template <class Value> void add_range(std::span<const Value> values, int components, std::size_t stride) {
    std::vector<Value> low(values.begin(), values.begin() + components);
    std::vector<Value> high = low;
    for (std::size_t i = 0; i + static_cast<std::size_t>(components) <= values.size(); i += stride) {
      for (std::size_t c = 0; c < low.size(); ++c) {
        low[c] = std::min(low[c], values[i + c]);
        high[c] = std::max(high[c], values[i + c]);
      }
    }
    accessors_.back()["min"] = low;
    accessors_.back()["max"] = high;
  }

  ByteSpool& bytes() { return bytes_; }
  /// Adds "buffers", "bufferViews" and "accessors".
  void describe(nlohmann::json& gltf) const;

private:
  static std::size_t stride_of(const GlbElements& elements);

  GlbPacking packing_;
  ByteSpool bytes_;
  std::size_t unpacked_ = 0; ///< bytes of the buffer that packed views fill when they are read
  nlohmann::json views_ = nlohmann::json::array();
  nlohmann::json accessors_ = nlohmann::json::array();
};

/// Writes the file: header, JSON chunk, binary chunk. Throws Error: kFailure if it is longer than the 4 GiB that the
/// format can state, kUnwritableOutput.
void write_glb(const std::filesystem::path& path, const nlohmann::json& gltf, ByteSpool& binary);

} // namespace kinora::formats
