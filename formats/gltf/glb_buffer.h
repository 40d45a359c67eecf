// The binary part of a GLB file and the JSON that describes it: buffer views and accessors.
// Source: Khronos Group, "glTF 2.0 Specification" (2021), sections 3.6 and 4.4.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

namespace kinora::formats {

/// What an accessor's bytes are for.
enum class GlbTarget { kNone = 0, kVertices = 34962, kIndices = 34963 };

/// How an accessor reads its bytes.
struct GlbElements {
  int component_type;      ///< 5121 u8, 5123 u16, 5125 u32, 5126 float
  const char* type;        ///< "SCALAR", "VEC3", "VEC4", "MAT4"
  int components;          ///< that `type` has
  bool normalized = false; ///< integers stand for numbers up to 1
  bool with_range = false; ///< smallest and largest values are stated (floats only)
};

inline constexpr GlbElements kGlbScalars = {5126, "SCALAR", 1, false, true}; // times: their range is required
inline constexpr GlbElements kGlbPositions = {5126, "VEC3", 3, false, true}; // here too
inline constexpr GlbElements kGlbVectors = {5126, "VEC3", 3};
inline constexpr GlbElements kGlbQuaternions = {5126, "VEC4", 4};
inline constexpr GlbElements kGlbMatrices = {5126, "MAT4", 16};
inline constexpr GlbElements kGlbShares = {5123, "VEC4", 4, true};
inline constexpr GlbElements kGlbNumbers = {5123, "VEC4", 4};
inline constexpr GlbElements kGlbIndices = {5125, "SCALAR", 1};

/// One buffer that grows. Numbers must be in little-endian order, as all machines that Kinora runs on have it.
class GlbBuffer {
public:
  /// Appends values as a buffer view of their own and returns the number of the accessor that reads them.
  template <class Value> int add(std::span<const Value> values, const GlbElements& elements, GlbTarget target) {
    const int accessor = add_bytes(std::as_bytes(values), elements, target);
    if constexpr (std::is_same_v<Value, float>) {
      if (elements.with_range) add_range(values, elements.components);
    }
    return accessor;
  }

  const std::vector<std::byte>& bytes() const { return bytes_; }
  /// Adds "buffers", "bufferViews" and "accessors".
  void describe(nlohmann::json& gltf) const;

private:
  int add_bytes(std::span<const std::byte> bytes, const GlbElements& elements, GlbTarget target);
  void add_range(std::span<const float> values, int components);

  std::vector<std::byte> bytes_;
  nlohmann::json views_ = nlohmann::json::array();
  nlohmann::json accessors_ = nlohmann::json::array();
};

/// The file: header, JSON chunk, binary chunk. Throws Error(kFailure), naming `location`, if it is longer than the 4
/// GiB that the format can state.
std::vector<std::byte> glb_file(const nlohmann::json& gltf, std::span<const std::byte> binary,
                                const std::string& location);

} // namespace kinora::formats
