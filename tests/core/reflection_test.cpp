// Fields and enumerators are found with their names, in order, whatever their types are.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/reflection.h"

namespace kinora {
namespace {

struct Inner {
  int count = 2;
};

template <class T> struct Pair { T first, second; };

enum class Shade { kLight, kHalfDark, kDark };

struct Everything {
  bool is_bool = true;
  double number = 0.5;
  float per_metre_ = 1;
  std::size_t n = 7;
  std::string text = "as it is";
  std::array<int, 3> stages{1, 1, 5};
  Inner inner{.count = 4};
  Pair<float> pair{};
  Shade shade = Shade::kDark;
  std::vector<int> list = {};
  std::optional<double> maybe = {};
  int function() const { return count_of_calls; }
  int count_of_calls = 0;
};

struct TwentyFour {
  int a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, c0, c1, c2, c3;
};

template <class T> std::vector<std::string> names_of(T object) {
  std::vector<std::string> names;
  for_each_field(object, [&](std::string_view name, auto& /*field*/) { names.emplace_back(name); });
  return names;
}

TEST(Reflection, NamesEveryFieldInOrder) {
  EXPECT_EQ(names_of(Everything{}),
            (std::vector<std::string>{"is_bool", "number", "per_metre_", "n", "text", "stages", "inner", "pair",
                                      "shade", "list", "maybe", "count_of_calls"}));
  EXPECT_EQ(names_of(Inner{}), std::vector<std::string>{"count"});
  EXPECT_EQ(names_of(Pair<Inner>{}), (std::vector<std::string>{"first", "second"}));
}

TEST(Reflection, HandsOutTheFieldsThemselves) {
  Everything object;
  for_each_field(object, [](std::string_view name, auto& field) {
    if constexpr (std::is_same_v<decltype(field), std::string&>) field = name;
  });
  EXPECT_EQ(object.text, "text");
  TwentyFour many{};
  int next = 0;
  for_each_field(many, [&](std::string_view /*name*/, int& field) { field = next++; });
  EXPECT_EQ(many.a0, 0);
  EXPECT_EQ(many.b3, 13);
  EXPECT_EQ(many.c3, 23);
}

TEST(Reflection, LooksAtConstantObjects) {
  const Everything object;
  int sum = 0;
  for_each_field(object, [&](std::string_view /*name*/, const auto& field) {
    if constexpr (std::is_same_v<decltype(field), const Inner&>) sum += field.count;
  });
  EXPECT_EQ(sum, 4);
}

TEST(Reflection, TellsStructsFromValues) {
  static_assert(PlainStruct<Everything> && PlainStruct<Inner> && PlainStruct<Pair<int>>);
  static_assert(!PlainStruct<int> && !PlainStruct<Shade> && !PlainStruct<std::string>);
  static_assert(!PlainStruct<std::array<int, 3>> && !PlainStruct<std::vector<int>> && !PlainStruct<std::optional<int>>);
}

TEST(Reflection, NamesTheValuesOfAnEnum) {
  constexpr auto kNames = enumerator_names<Shade>();
  ASSERT_EQ(kNames.size(), 3U);
  EXPECT_EQ(kNames[0], "kLight");
  EXPECT_EQ(kNames[1], "kHalfDark");
  EXPECT_EQ(kNames[2], "kDark");
}

} // namespace
} // namespace kinora
