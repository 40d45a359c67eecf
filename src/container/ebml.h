// EBML elements of an untrusted source: identifiers, sizes and values, every one checked against what holds it.
// Source: RFC 8794 (EBML), sections 4 to 7, 11.2.
#pragma once

#include <cstdint>
#include <string>

#include "container/byte_source.h"
#include "container/payload.h"

namespace kinora::container {

/// Where one element lies. If the size is unknown, `end` is the limit given to the call that found it.
struct Element {
  std::uint32_t id = 0; ///< with its length marker, as specifications print it
  std::uint64_t start = 0;
  std::uint64_t body = 0;
  std::uint64_t end = 0;
  bool unknown_size = false;

  std::uint64_t body_size() const { return end - body; }
  std::uint64_t total_size() const { return end - start; }
};

/// Throws Error(kCorruptInput): "NAME: byte OFFSET: WHY".
[[noreturn]] void throw_corrupt(const ByteSource& source, std::uint64_t offset, const std::string& why);

/// A variable-length integer (RFC 8794, section 4) without its marker; all data bits 1 means "unknown".
struct VariableInteger {
  std::uint64_t value = 0;
  int length = 0; ///< bytes, 1 to 8
  bool all_ones = false;
};

/// Reads one at `offset`, which must end before `limit`. Throws Error(kCorruptInput).
VariableInteger read_variable_integer(ByteSource& source, std::uint64_t offset, std::uint64_t limit);

/// The element whose header starts at `offset` and lies before `limit` ≤ source.size(); its end may be anywhere behind.
/// Throws Error(kCorruptInput) if the header is malformed.
Element read_element_header(ByteSource& source, std::uint64_t offset, std::uint64_t limit);

/// The element that starts at `offset` inside a parent that ends at `limit` ≤ source.size().
/// Throws Error(kCorruptInput) if its header is malformed or it passes the limit.
Element read_element(ByteSource& source, std::uint64_t offset, std::uint64_t limit);

std::uint64_t read_uint(ByteSource& source, const Element& element);
/// A float of 4 or 8 bytes; 0 of any other size.
double read_float(ByteSource& source, const Element& element);
/// At most 64 KiB; ends at the first zero byte (RFC 8794, section 7.4).
std::string read_text(ByteSource& source, const Element& element);
/// Allocates no more than the source holds.
Bytes read_bytes(ByteSource& source, const Element& element);

/// Calls visit(child) for each child of a master element, in order; Void, CRC-32 and unknown ones are given, too.
template <class Visit> void for_each_child(ByteSource& source, const Element& parent, const Visit& visit) {
  for (std::uint64_t at = parent.body; at < parent.end;) {
    const Element child = read_element(source, at, parent.end);
    if (child.unknown_size) throw_corrupt(source, child.start, "an element of unknown size where none may be");
    visit(child);
    at = child.end;
  }
}

} // namespace kinora::container
