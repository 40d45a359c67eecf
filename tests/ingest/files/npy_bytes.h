// Arrays as NumPy writes them.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace kinora::ingest::testing {

/// `dictionary` is the header as Python prints it.
inline std::vector<std::byte> npy_with_header(const std::string& dictionary, std::span<const std::byte> data) {
  std::string header = dictionary;
  while ((10 + header.size() + 1) % 64 != 0) header.push_back(' ');
  header.push_back('\n');
  std::string text("\x93NUMPY\x01\x00", 8);
  text.push_back(static_cast<char>(header.size() & 0xFFU));
  text.push_back(static_cast<char>(header.size() >> 8U));
  text.append(header);
  const auto view = std::as_bytes(std::span(text));
  std::vector<std::byte> bytes(view.begin(), view.end());
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

template <class T>
std::vector<std::byte> npy(const std::string& type, const std::string& shape, const std::vector<T>& values) {
  return npy_with_header("{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }",
                         std::as_bytes(std::span(values)));
}

} // namespace kinora::ingest::testing
