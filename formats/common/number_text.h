// Numbers as text, whatever the locale.
#pragma once

#include <charconv>
#include <string>

namespace kinora::formats {

/// Appends the value with at most `decimals` places, zeros at the end left out: "1.5", "-0.25", "0".
inline void append_number(std::string& text, double value, int decimals) {
  char buffer[400]; // a double has up to 309 digits before the point
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  std::string_view digits(buffer, static_cast<std::size_t>(result.ptr - buffer));
  if (digits.find('.') != std::string_view::npos) {
    digits = digits.substr(0, digits.find_last_not_of('0') + 1);
    if (digits.ends_with('.')) digits.remove_suffix(1);
  }
  text += digits == "-0" ? "0" : digits;
}

} // namespace kinora::formats
