// Networks for tests, made byte by byte: one 1×1 convolution in ONNX's protobuf.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kinora::test::onnx {

inline std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 128; value >>= 7) bytes += static_cast<char>((value & 127) | 128);
  return bytes + static_cast<char>(value);
}
inline std::string number(int field, std::uint64_t value) {
  return varint(static_cast<std::uint64_t>(field) << 3) + varint(value);
}
inline std::string bytes(int field, const std::string& content) {
  return varint((static_cast<std::uint64_t>(field) << 3) | 2) + varint(content.size()) + content;
}

inline std::string tensor(const std::string& name, const std::vector<std::uint64_t>& sizes,
                          const std::vector<float>& values) {
  std::string text;
  for (const std::uint64_t size : sizes) text += number(1, size);
  text += number(2, 1); // float
  text += bytes(8, name);
  return text + bytes(9, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
}

inline std::string value_info(const std::string& name, const std::vector<std::uint64_t>& sizes) {
  std::string shape;
  for (const std::uint64_t size : sizes) shape += bytes(1, number(1, size));
  return bytes(1, name) + bytes(2, bytes(1, number(1, 1) + bytes(2, shape)));
}

/// scores = weights · RGB + biases, per pixel. `width`, `height`: of the input, as the file says.
inline std::string convolution(std::uint64_t classes, const std::vector<float>& weights,
                               const std::vector<float>& biases, std::uint64_t width = 64, std::uint64_t height = 32) {
  const std::string kernel = bytes(1, "kernel_shape") + number(8, 1) + number(8, 1) + number(20, 7);
  const std::string node =
      bytes(1, "x") + bytes(1, "w") + bytes(1, "b") + bytes(2, "y") + bytes(4, "Conv") + bytes(5, kernel);
  const std::string graph = bytes(1, node) + bytes(2, "g") + bytes(5, tensor("w", {classes, 3, 1, 1}, weights)) +
                            bytes(5, tensor("b", {classes}, biases)) +
                            bytes(11, value_info("x", {1, 3, height, width})) +
                            bytes(12, value_info("y", {1, classes, height, width}));
  return number(1, 6) + bytes(7, graph) + bytes(8, bytes(1, "") + number(2, 11));
}

} // namespace kinora::test::onnx
