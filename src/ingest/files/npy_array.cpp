#include "ingest/files/npy_array.h"

#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::ingest {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kMaxDimensions = 3;

[[noreturn]] void refuse(const std::string& source, std::string_view what) {
  throw Error(ErrorCode::kCorruptInput,
              fmt::format("{}: {}; write it again with numpy.savez from arrays of plain numbers", source, what));
}

struct Header {
  std::string type;
  bool fortran_order = false;
  std::vector<std::size_t> shape;
};

// A dictionary as Python prints it, with exactly the three keys that the format has.
class HeaderParser {
public:
  HeaderParser(std::string_view text, const std::string& source) : text_(text), source_(source) {}

  Header parse() {
    std::optional<std::string> type;
    std::optional<bool> fortran_order;
    std::optional<std::vector<std::size_t>> shape;
    expect('{');
    while (!take('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr" && !type) {
        if (next() == '[') refuse(source_, "it holds records, not numbers");
        type = quoted();
      } else if (key == "fortran_order" && !fortran_order) {
        fortran_order = truth();
      } else if (key == "shape" && !shape) {
        shape = numbers();
      } else {
        fail();
      }
      if (!take(',') && next() != '}') fail();
    }
    if (next() != '\0' || !type || !fortran_order || !shape) fail();
    return {*type, *fortran_order, *shape};
  }

private:
  [[noreturn]] void fail() const { refuse(source_, "its header is damaged"); }
  char next() {
    while (!text_.empty() && std::isspace(static_cast<unsigned char>(text_.front())) != 0) text_.remove_prefix(1);
    return text_.empty() ? '\0' : text_.front();
  }
  bool take(char c) {
    if (next() != c || text_.empty()) return false;
    text_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!take(c)) fail();
  }
  std::string quoted() {
    expect('\'');
    const std::size_t end = text_.find('\'');
    if (end == std::string_view::npos) fail();
    std::string word(text_.substr(0, end));
    text_.remove_prefix(end + 1);
    return word;
  }
  bool truth() {
    next();
    for (const std::string_view word : {"True", "False"}) {
      if (!text_.starts_with(word)) continue;
      text_.remove_prefix(word.size());
      return word == "True";
    }
    fail();
  }
  std::size_t number() {
    constexpr std::size_t kMax = 1U << 30U;
    if (std::isdigit(static_cast<unsigned char>(next())) == 0) fail();
    std::size_t value = 0;
    while (!text_.empty() && std::isdigit(static_cast<unsigned char>(text_.front())) != 0) {
      value = 10 * value + static_cast<std::size_t>(text_.front() - '0');
      if (value > kMax) refuse(source_, "its shape is absurd");
      text_.remove_prefix(1);
    }
    return value;
  }
  std::vector<std::size_t> numbers() {
    std::vector<std::size_t> result;
    expect('(');
    while (!take(')')) {
      if (result.size() == kMaxDimensions) refuse(source_, "it has more than three dimensions");
      result.push_back(number());
      if (!take(',') && next() != ')') fail();
    }
    return result;
  }

  std::string_view text_;
  const std::string& source_;
};

template <class T> std::vector<double> decode(std::span<const std::byte> data) {
  std::vector<double> values(data.size() / sizeof(T));
  for (std::size_t i = 0; i < values.size(); ++i) {
    T value;
    std::memcpy(&value, data.data() + i * sizeof(T), sizeof(T));
    values[i] = static_cast<double>(value);
  }
  return values;
}

struct Type {
  std::string_view name;
  std::size_t size;
  std::vector<double> (*decode)(std::span<const std::byte>);
};
constexpr Type kTypes[] = {{"<f4", 4, decode<float>},         {"<f8", 8, decode<double>},
                           {"<i4", 4, decode<std::int32_t>},  {"<i8", 8, decode<std::int64_t>},
                           {"<u4", 4, decode<std::uint32_t>}, {"<u8", 8, decode<std::uint64_t>}};

const Type& type_of(const std::string& name, const std::string& source) {
  for (const Type& type : kTypes) {
    if (type.name == name) return type;
  }
  if (name.find('O') != std::string::npos) refuse(source, "it holds pickled objects, which are never read");
  refuse(source, "its numbers are not little-endian integers or floats of 4 or 8 bytes");
}

// From the first index running fastest to the last.
std::vector<double> in_c_order(const std::vector<double>& values, const std::vector<std::size_t>& shape) {
  std::array<std::size_t, kMaxDimensions> n = {1, 1, 1};
  for (std::size_t i = 0; i < shape.size(); ++i) n.at(i) = shape[i];
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t a = i % n[0];
    const std::size_t b = i / n[0] % n[1];
    const std::size_t c = i / n[0] / n[1];
    result[(a * n[1] + b) * n[2] + c] = values[i];
  }
  return result;
}

} // namespace

NpyArray parse_npy(std::span<const std::byte> bytes, const std::string& source) {
  constexpr std::string_view kMagic = "\x93NUMPY";
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!text.starts_with(kMagic) || bytes.size() < 12) refuse(source, "it is no NumPy array");
  const auto byte_at = [bytes](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); };
  const std::size_t version = byte_at(6);
  if (version < 1 || version > 3 || byte_at(7) != 0) refuse(source, "its version of NumPy's format is unknown");
  const std::size_t begin = version == 1 ? 10 : 12;
  const std::size_t length = version == 1
                                 ? byte_at(8) + (byte_at(9) << 8U)
                                 : byte_at(8) + (byte_at(9) << 8U) + (byte_at(10) << 16U) + (byte_at(11) << 24U);
  if (length > bytes.size() - begin) refuse(source, "it ends within its header");
  const Header header = HeaderParser(text.substr(begin, length), source).parse();
  const Type& type = type_of(header.type, source);
  const std::span<const std::byte> data = bytes.subspan(begin + length);
  std::size_t count = 1;
  for (const std::size_t n : header.shape) {
    count *= n;
    if (count > data.size()) refuse(source, "it holds fewer numbers than its header says");
  }
  if (count * type.size != data.size()) refuse(source, "it does not hold as many numbers as its header says");
  NpyArray array{header.shape, type.decode(data)};
  for (const double value : array.values) {
    if (!std::isfinite(value)) refuse(source, "it holds numbers that are not finite");
  }
  if (header.fortran_order) array.values = in_c_order(array.values, array.shape);
  return array;
}

} // namespace kinora::ingest
