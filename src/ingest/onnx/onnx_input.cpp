#include "ingest/onnx/onnx_input.h"

#include <cstdint>
#include <vector>

namespace kinora::ingest {
namespace {

/// The fields of a Protocol Buffers message, one after the other.
class Message {
public:
  explicit Message(std::string_view bytes) : rest_(bytes) {}

  /// The next field; false at the end, or where the message is damaged.
  bool next() {
    std::uint64_t tag = 0;
    if (rest_.empty() || !read(tag)) return false;
    field_ = tag >> 3;
    number_ = 0;
    content_ = {};
    switch (tag & 7) {
    case 0:
      return read(number_);
    case 1:
      return skip(8);
    case 2: {
      std::uint64_t size = 0;
      if (!read(size) || size > rest_.size()) return false;
      content_ = rest_.substr(0, size);
      return skip(size);
    }
    case 5:
      return skip(4);
    default:
      return false;
    }
  }
  std::uint64_t field() const { return field_; }
  std::uint64_t number() const { return number_; }      ///< of a field that holds one, else 0
  std::string_view content() const { return content_; } ///< of a field that holds bytes, else empty

private:
  bool read(std::uint64_t& value) {
    value = 0;
    for (int shift = 0; shift < 64 && !rest_.empty(); shift += 7) {
      const auto byte = static_cast<std::uint8_t>(rest_.front());
      rest_.remove_prefix(1);
      value |= static_cast<std::uint64_t>(byte & 127) << shift;
      if (byte < 128) return true;
    }
    return false;
  }
  bool skip(std::uint64_t size) {
    if (size > rest_.size()) return false;
    rest_.remove_prefix(size);
    return true;
  }

  std::string_view rest_;
  std::uint64_t field_ = 0;
  std::uint64_t number_ = 0;
  std::string_view content_;
};

// The first field of that number; empty if there is none.
std::string_view content_of(std::string_view message, std::uint64_t field) {
  for (Message m(message); m.next();) {
    if (m.field() == field) return m.content();
  }
  return {};
}

// Sides of an input's tensor; 0 where the file gives a name or nothing.
std::vector<std::uint64_t> sides_of(std::string_view input) {
  constexpr std::uint64_t kType = 2;
  constexpr std::uint64_t kTensorType = 1;
  constexpr std::uint64_t kShape = 2;
  constexpr std::size_t kMax = 8;
  std::vector<std::uint64_t> sides;
  for (Message shape(content_of(content_of(content_of(input, kType), kTensorType), kShape));
       shape.next() && sides.size() < kMax;) {
    if (shape.field() != 1) continue;
    sides.push_back(0);
    for (Message side(shape.content()); side.next();) {
      if (side.field() == 1) sides.back() = side.number();
    }
  }
  return sides;
}

} // namespace

std::optional<PictureSize> onnx_picture_input(std::string_view file) {
  constexpr std::uint64_t kGraph = 7;
  constexpr std::uint64_t kInput = 11;
  constexpr std::uint64_t kMaxSide = 4096;
  for (Message graph(content_of(file, kGraph)); graph.next();) {
    if (graph.field() != kInput) continue;
    const std::vector<std::uint64_t> sides = sides_of(graph.content());
    if (sides.size() != 4 || sides[0] > 1 || sides[1] != 3) continue;
    if (sides[2] == 0 || sides[3] == 0 || sides[2] > kMaxSide || sides[3] > kMaxSide) continue;
    return PictureSize{static_cast<int>(sides[3]), static_cast<int>(sides[2])};
  }
  return std::nullopt;
}

} // namespace kinora::ingest
