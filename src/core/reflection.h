// Names and values of a plain struct's fields, and names of an enum's values, without a list kept by hand.
// A struct's fields are counted by how many values it can be initialised with, reached by structured bindings, and
// named by how the compiler prints a pointer to them; an enum's values likewise. As Boost.PFR and reflect-cpp do.
#pragma once

#include <array>
#include <cstddef>
#include <exception>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace kinora {
namespace reflection {

/// Initialises any field, but not the struct itself as a copy.
template <class T> struct AnyFieldOf {
  // clang-format off
  template <class U> requires(!std::is_same_v<U, T>) operator U() const { std::terminate(); }
  // clang-format on
};

template <class T, std::size_t... I> constexpr bool takes_values(std::index_sequence<I...> /*unused*/) {
  return requires { T{(static_cast<void>(I), AnyFieldOf<T>{})...}; };
}

template <class T, std::size_t N = 0> constexpr std::size_t count_fields() {
  if constexpr (takes_values<T>(std::make_index_sequence<N + 1>())) {
    return count_fields<T, N + 1>();
  } else {
    return N;
  }
}

// clang-format off
template <class T> constexpr auto tie_fields(T& o) {
  constexpr std::size_t n = count_fields<std::remove_const_t<T>>();
  static_assert(n >= 1 && n <= 32, "more fields than that are better kept in structs of their own");
#define KINORA_TIE(count, ...) else if constexpr (n == (count)) { auto& [__VA_ARGS__] = o; return std::tie(__VA_ARGS__); }
  if constexpr (n == 0) return std::tuple<>();
  KINORA_TIE(1, a)
  KINORA_TIE(2, a, b)
  KINORA_TIE(3, a, b, c)
  KINORA_TIE(4, a, b, c, d)
  KINORA_TIE(5, a, b, c, d, e)
  KINORA_TIE(6, a, b, c, d, e, f)
  KINORA_TIE(7, a, b, c, d, e, f, g)
  KINORA_TIE(8, a, b, c, d, e, f, g, h)
  KINORA_TIE(9, a, b, c, d, e, f, g, h, i)
  KINORA_TIE(10, a, b, c, d, e, f, g, h, i, j)
  KINORA_TIE(11, a, b, c, d, e, f, g, h, i, j, k)
  KINORA_TIE(12, a, b, c, d, e, f, g, h, i, j, k, l)
  KINORA_TIE(13, a, b, c, d, e, f, g, h, i, j, k, l, m)
  KINORA_TIE(14, a, b, c, d, e, f, g, h, i, j, k, l, m, p)
  KINORA_TIE(15, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q)
  KINORA_TIE(16, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r)
  KINORA_TIE(17, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s)
  KINORA_TIE(18, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t)
  KINORA_TIE(19, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u)
  KINORA_TIE(20, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v)
  KINORA_TIE(21, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w)
  KINORA_TIE(22, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x)
  KINORA_TIE(23, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y)
  KINORA_TIE(24, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z)
  KINORA_TIE(25, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A)
  KINORA_TIE(26, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B)
  KINORA_TIE(27, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B, C)
  KINORA_TIE(28, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B, C, D)
  KINORA_TIE(29, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B, C, D, E)
  KINORA_TIE(30, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B, C, D, E, F)
  KINORA_TIE(31, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B, C, D, E, F, G)
  KINORA_TIE(32, a, b, c, d, e, f, g, h, i, j, k, l, m, p, q, r, s, t, u, v, w, x, y, z, A, B, C, D, E, F, G, H)
#undef KINORA_TIE
}
// clang-format on

/// Room for an object that is never made: its fields have addresses.
template <class T> union Unmade {
  constexpr Unmade() : nothing() {}
  ~Unmade() {}
  char nothing;
  T object;
};
template <class T> inline const Unmade<T> kUnmade;

/// Clang takes the address of a field as a template's argument only within a struct.
template <class T> struct Constant { T value; };
template <class T> Constant(T) -> Constant<T>;

/// Ends, as GCC prints it, with "…::name)}]" or "…::kName}]"; as Clang does, with "….name}]" or "…kName}]".
template <auto X> constexpr const char* printed() { return __PRETTY_FUNCTION__; }

/// The last identifier; nothing if a number stands there, as for an enum's value without a name.
constexpr std::string_view last_word(std::string_view text) {
  text = text.substr(0, text.find_last_not_of(")}]") + 1);
  const auto is_letter = [](char c) {
    return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  std::size_t begin = text.size();
  while (begin > 0 && is_letter(text[begin - 1])) --begin;
  text = text.substr(begin);
  return text.empty() || (text[0] >= '0' && text[0] <= '9') ? std::string_view() : text;
}

template <class T, std::size_t I> constexpr std::string_view field_name() {
  return last_word(printed<Constant{&std::get<I>(tie_fields(kUnmade<T>.object))}>());
}

} // namespace reflection

/// A struct without constructors and bases: its fields can be looked at.
template <class T>
concept PlainStruct = std::is_class_v<T> && std::is_aggregate_v<T> && !requires {
  typename T::value_type;
};

/// Calls visit(name, field) for each field of a struct, in order. No field may be a reference or a C array.
template <PlainStruct T, class Visit> constexpr void for_each_field(T& object, Visit&& visit) {
  const auto fields = reflection::tie_fields(object);
  [&]<std::size_t... I>(std::index_sequence<I...> /*unused*/) {
    (visit(reflection::field_name<std::remove_const_t<T>, I>(), std::get<I>(fields)), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<std::remove_const_t<decltype(fields)>>>());
}

/// The names of an enum's values 0, 1, … up to the first that has none, as they are written: "kFast".
template <class E>
requires std::is_enum_v<E>
constexpr auto enumerator_names() {
  constexpr auto kCount = []<std::size_t N>(auto&& self, std::integral_constant<std::size_t, N> /*unused*/) {
    if constexpr (reflection::last_word(reflection::printed<static_cast<E>(N)>()).empty()) {
      return N;
    } else {
      return self(self, std::integral_constant<std::size_t, N + 1>());
    }
  };
  constexpr std::size_t n = kCount(kCount, std::integral_constant<std::size_t, 0>());
  return []<std::size_t... I>(std::index_sequence<I...> /*unused*/) {
    return std::array<std::string_view, n>{reflection::last_word(reflection::printed<static_cast<E>(I)>())...};
  }
  (std::make_index_sequence<n>());
}
} // namespace kinora
