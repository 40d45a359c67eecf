#include "host/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/edit_distance.h"
#include "core/error.h"

namespace kinora::host {
namespace {

template <class Number> bool is_number(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(static_cast<double>(value));
}

bool is_one_of(const std::string& choices, const std::string& value) {
  for (std::string_view rest = choices; !rest.empty();) {
    const std::size_t end = std::min(rest.find('|'), rest.size());
    if (rest.substr(0, end) == value) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

bool is_bool(std::string_view type) { return type == "bool"; }

bool is_of_type(const std::string& type, const std::string& value) {
  if (type == "text") return true;
  if (type == "int") return is_number<int>(value);
  if (type == "number") return is_number<double>(value);
  return is_one_of(is_bool(type) ? "true|false" : type, value);
}

const KinoraOption* find_option(const KinoraFormat& format, const std::string& name) {
  for (std::size_t i = 0; i < format.option_count; ++i)
    if (name == format.options[i].name) return &format.options[i];
  return nullptr;
}

} // namespace

Options parse_options(std::span<const std::string> words) {
  Options options;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == 0 || equals == std::string::npos)
      throw Error(ErrorCode::kUsage, fmt::format("option \"{}\": write -O key=value", word));
    options[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return options;
}

void check_options(const KinoraFormat& format, const Options& options, std::span<const std::string> others) {
  for (const auto& [name, value] : options) {
    const KinoraOption* option = find_option(format, name);
    if (option == nullptr) {
      std::vector<std::string> names(others.begin(), others.end());
      for (std::size_t i = 0; i < format.option_count; ++i)
        if (std::ranges::find(others, format.options[i].name) == others.end())
          names.emplace_back(format.options[i].name);
      throw Error(ErrorCode::kUsage,
                  names.empty() ? fmt::format("the format {} has no options, so not \"{}\" either", format.name, name)
                                : fmt::format("the format {} has no option \"{}\"; the nearest is {}; it has {}",
                                              format.name, name, nearest_word(name, names), fmt::join(names, ", ")));
    }
    if (!is_of_type(option->type, value))
      throw Error(ErrorCode::kUsage,
                  fmt::format("option {}={} of the format {}: the value must be of type {}", name, value, format.name,
                              is_bool(option->type) ? "bool: true or false" : option->type));
  }
}

} // namespace kinora::host
