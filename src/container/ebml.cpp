#include "container/ebml.h"

#include <array>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::container {

namespace {
constexpr int kMaxIdBytes = 4;
constexpr std::uint64_t kMaxTextBytes = 1 << 16;

// Number of bytes of a variable-length integer, from its first byte; 9 if there is no marker.
int length_of(std::byte first) { return std::countl_zero(std::to_integer<std::uint8_t>(first)) + 1; }

std::uint64_t big_endian(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (const std::byte b : bytes) value = value << 8 | std::to_integer<std::uint64_t>(b);
  return value;
}

// The bytes of one variable-length integer with its marker, as a number.
std::uint64_t read_marked(ByteSource& source, std::uint64_t offset, std::uint64_t limit, int max_length, int& length) {
  if (offset >= limit) throw_corrupt(source, offset, "an element ends where its header should be");
  std::array<std::byte, 8> bytes{};
  source.read(offset, std::span(bytes).first(1));
  length = length_of(bytes[0]);
  if (length > max_length) throw_corrupt(source, offset, "not an EBML element; the file is damaged");
  const std::span<std::byte> all = std::span(bytes).first(static_cast<std::size_t>(length));
  if (all.size() > limit - offset) throw_corrupt(source, offset, "an element's header is cut short");
  source.read(offset, all);
  return big_endian(all);
}
} // namespace

void throw_corrupt(const ByteSource& source, std::uint64_t offset, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: byte {}: {}", source.name(), offset, why));
}

VariableInteger read_variable_integer(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  VariableInteger result;
  const std::uint64_t marked = read_marked(source, offset, limit, 8, result.length);
  const std::uint64_t mask = (std::uint64_t{1} << (7 * result.length)) - 1;
  result.value = marked & mask;
  result.all_ones = result.value == mask;
  return result;
}

Element read_element_header(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  Element element;
  element.start = offset;
  int id_length = 0;
  element.id = static_cast<std::uint32_t>(read_marked(source, offset, limit, kMaxIdBytes, id_length));
  const std::uint64_t size_at = offset + static_cast<std::uint64_t>(id_length);
  const VariableInteger size = read_variable_integer(source, size_at, limit);
  element.body = size_at + static_cast<std::uint64_t>(size.length);
  element.unknown_size = size.all_ones;
  element.end = size.all_ones ? limit : element.body + size.value; // below 2^57 + 2^63: no overflow
  return element;
}

Element read_element(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  const Element element = read_element_header(source, offset, limit);
  if (element.end > limit) {
    throw_corrupt(
        source, offset,
        fmt::format("element {:X} of {} bytes passes the end of what holds it; the file is cut short or damaged",
                    element.id, element.body_size()));
  }
  return element;
}

std::uint64_t read_uint(ByteSource& source, const Element& element) {
  if (element.body_size() > 8) throw_corrupt(source, element.start, "a number of more than 8 bytes");
  std::array<std::byte, 8> bytes{};
  const auto used = std::span(bytes).first(static_cast<std::size_t>(element.body_size()));
  source.read(element.body, used);
  return big_endian(used);
}

double read_float(ByteSource& source, const Element& element) {
  const std::uint64_t bits = read_uint(source, element);
  if (element.body_size() == sizeof(float)) {
    const auto narrow = static_cast<std::uint32_t>(bits);
    float value = 0;
    std::memcpy(&value, &narrow, sizeof value);
    return value;
  }
  double value = 0;
  if (element.body_size() == sizeof(double)) std::memcpy(&value, &bits, sizeof value);
  return value;
}

std::string read_text(ByteSource& source, const Element& element) {
  if (element.body_size() > kMaxTextBytes) {
    throw_corrupt(source, element.start, fmt::format("a text of {} bytes is too long", element.body_size()));
  }
  std::string text(static_cast<std::size_t>(element.body_size()), '\0');
  source.read(element.body, std::as_writable_bytes(std::span(text)));
  text.resize(std::min(text.size(), text.find('\0')));
  return text;
}

Bytes read_bytes(ByteSource& source, const Element& element) {
  Bytes bytes(static_cast<std::size_t>(element.body_size()));
  source.read(element.body, bytes);
  return bytes;
}

} // namespace kinora::container
