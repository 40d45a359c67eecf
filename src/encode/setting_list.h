// The single values in a tree of structs of settings: what each is called and holds, and how it is changed by name.
// The fields of the structs are all there is to know (core/reflection.h): a new field is a new setting.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/reflection.h"

namespace kinora::encode {

/// True for what a struct of settings holds besides settings: data of one capture.
template <class T> inline constexpr bool kIsData = false;

/// JSON and back, for what a setting may be: bool, whole numbers, numbers, std::string, an enum, several of one kind
/// (std::array), or one that may be missing (std::optional). No number is negative or infinite.
template <class T> struct SettingValue;

template <> struct SettingValue<bool> {
  static std::string type() { return "true or false"; }
  static nlohmann::json json(bool value) { return value; }
  static std::optional<bool> read(const nlohmann::json& json) {
    return json.is_boolean() ? std::optional(json.get<bool>()) : std::nullopt;
  }
};

template <std::integral T> struct SettingValue<T> {
  static std::string type() { return "a whole number, 0 or more"; }
  static nlohmann::json json(T value) { return value; }
  static std::optional<T> read(const nlohmann::json& json) {
    constexpr double kExact = 1ULL << 53U; // a whole number may be written as 2e7
    if (!json.is_number() || json.get<double>() < 0) return std::nullopt;
    if (json.is_number_float() &&
        !(json.get<double>() <= kExact && json.get<double>() == std::floor(json.get<double>())))
      return std::nullopt;
    const auto value = json.get<std::uint64_t>();
    return std::in_range<T>(value) ? std::optional(static_cast<T>(value)) : std::nullopt;
  }
};

template <std::floating_point T> struct SettingValue<T> {
  static std::string type() { return "a number, 0 or more"; }
  /// The fewest digits that are read as the same number, also of a float.
  static nlohmann::json json(T value) { return std::stod(fmt::format("{}", value)); }
  static std::optional<T> read(const nlohmann::json& json) {
    if (!json.is_number()) return std::nullopt;
    const auto value = json.get<double>();
    return value >= 0 && value <= std::numeric_limits<T>::max() ? std::optional(static_cast<T>(value)) : std::nullopt;
  }
};

template <> struct SettingValue<std::string> {
  static std::string type() { return "text"; }
  static nlohmann::json json(const std::string& value) { return value; }
  static std::optional<std::string> read(const nlohmann::json& json) {
    return json.is_string() ? std::optional(json.get<std::string>()) : std::nullopt;
  }
};

/// "kSignedDistance": "signed_distance".
std::string words_of_enumerator(std::string_view name);

template <class T>
requires std::is_enum_v<T>
struct SettingValue<T> {
  static std::string type() {
    std::string all;
    for (const std::string_view name : enumerator_names<T>()) {
      all += (all.empty() ? "" : " or ") + words_of_enumerator(name);
    }
    return all;
  }
  static nlohmann::json json(T value) {
    return words_of_enumerator(enumerator_names<T>().at(static_cast<std::size_t>(value)));
  }
  static std::optional<T> read(const nlohmann::json& json) {
    for (std::size_t i = 0; i < enumerator_names<T>().size(); ++i) {
      if (json == SettingValue::json(static_cast<T>(i))) return static_cast<T>(i);
    }
    return std::nullopt;
  }
};

template <class T, std::size_t N> struct SettingValue<std::array<T, N>> {
  static std::string type() { return fmt::format("{} of: {}", N, SettingValue<T>::type()); }
  static nlohmann::json json(const std::array<T, N>& values) {
    nlohmann::json all = nlohmann::json::array();
    for (const T& value : values) all.push_back(SettingValue<T>::json(value));
    return all;
  }
  /// One value stands for all.
  static std::optional<std::array<T, N>> read(const nlohmann::json& json) {
    std::array<T, N> values{};
    if (json.is_array() && json.size() != N) return std::nullopt;
    for (std::size_t i = 0; i < N; ++i) {
      const auto value = SettingValue<T>::read(json.is_array() ? json[i] : json);
      if (!value) return std::nullopt;
      values[i] = *value;
    }
    return values;
  }
};

template <class T> struct SettingValue<std::optional<T>> {
  static std::string type() { return SettingValue<T>::type() + " or null"; }
  static nlohmann::json json(const std::optional<T>& value) {
    return value ? SettingValue<T>::json(*value) : nlohmann::json();
  }
  static std::optional<std::optional<T>> read(const nlohmann::json& json) {
    if (json.is_null()) return std::optional<T>();
    const auto value = SettingValue<T>::read(json);
    return value ? std::optional<std::optional<T>>(value) : std::nullopt;
  }
};

struct Setting {
  std::string path; ///< the fields that lead to it: "tracking.rigid.min_pixels"
  std::string type; ///< in words
  std::function<nlohmann::json()> get;
  std::function<bool(const nlohmann::json&)> set; ///< false: that is not a value for it, and nothing changes
};

/// All settings of a struct, in order. Refers to the struct, which must outlive it.
class SettingList {
public:
  template <PlainStruct T> explicit SettingList(T& root) { append("", root); }

  const std::vector<Setting>& all() const& { return settings_; }
  std::vector<Setting> all() && { return std::move(settings_); }
  /// Structs as objects.
  nlohmann::json json() const;
  /// "path=value", as a user writes it. Names within the path may be left out where one setting alone is meant:
  /// tracking.solver.iterations. The value is JSON, but for text without quotation marks and lists without brackets.
  /// Throws Error(kUsage) for an unknown path, naming those that are like it, and for a value of another type.
  void change(const std::string& assignment) const;
  /// A line for each: path, value and type.
  std::string text() const;

private:
  template <class T> void append(const std::string& path, T& value) {
    if constexpr (PlainStruct<T>) {
      if constexpr (!kIsData<T>) {
        for_each_field(value, [&](std::string_view name, auto& field) {
          append(path.empty() ? std::string(name) : fmt::format("{}.{}", path, name), field);
        });
      }
    } else {
      settings_.push_back({path, SettingValue<T>::type(), [&value] { return SettingValue<T>::json(value); },
                           [&value](const nlohmann::json& json) {
                             auto read = SettingValue<T>::read(json);
                             if (read) value = *std::move(read);
                             return read.has_value();
                           }});
    }
  }
  const Setting& find(const std::string& path) const;

  std::vector<Setting> settings_;
};

/// The JSON of a struct of settings.
template <PlainStruct T> nlohmann::json settings_json(T settings) { return SettingList(settings).json(); }

} // namespace kinora::encode
