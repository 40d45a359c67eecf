#include "core/frame_range.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"

namespace kinora {
namespace {

struct Case {
  const char* text;
  int begin;
  std::optional<int> end;
  int step;
};

TEST(FrameRange, PartsMayBeLeftOut) {
  for (const Case& expected :
       {Case{"3:10:2", 3, 10, 2}, Case{"3:10", 3, 10, 1}, Case{"3:", 3, {}, 1}, Case{":7", 0, 7, 1},
        Case{"::5", 0, {}, 5}, Case{":", 0, {}, 1}, Case{"3", 3, 4, 1}, Case{"1:2:", 1, 2, 1}}) {
    const FrameRange range = FrameRange::parse(expected.text);
    EXPECT_EQ(range.begin, expected.begin) << expected.text;
    EXPECT_EQ(range.end, expected.end) << expected.text;
    EXPECT_EQ(range.step, expected.step) << expected.text;
  }
}

TEST(FrameRange, TellsWhereItGoesOnAfterAGap) {
  const FrameRange range = FrameRange::parse("3:10:4"); // 3, 7
  EXPECT_EQ(range.at_or_after(0), 3);
  EXPECT_EQ(range.at_or_after(4), 7);
  EXPECT_EQ(range.at_or_after(7), 7);
  EXPECT_EQ(range.at_or_after(8), 11); // behind its end
  constexpr int kLast = std::numeric_limits<int>::max();
  EXPECT_EQ((FrameRange{1, {}, kLast}.at_or_after(2)), kLast);
}

TEST(FrameRange, EverythingElseIsAUsageError) {
  for (const char* text :
       {"", "a", "1:b", "1:2:3:4", "-1:", "1:-1", "5:5", "7:3", "0:9:0", "0:9:-1", "1.5:", " 1:2", "99999999999:"}) {
    try {
      FrameRange::parse(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
    }
  }
}

TEST(FrameRange, CountsThatAPluginMayGiveDoNotOverflow) {
  constexpr int kMost = std::numeric_limits<int>::max();
  EXPECT_EQ(FrameRange().count_of(kMost), kMost);
  EXPECT_EQ(FrameRange::parse("::2").count_of(kMost), kMost / 2 + 1);
}

TEST(FrameRange, ContainsWhatItSelects) {
  const FrameRange range = FrameRange::parse("2:9:3");
  std::vector<int> selected;
  for (int i = 0; i < 20; ++i)
    if (range.contains(i)) selected.push_back(i);
  EXPECT_EQ(selected, (std::vector<int>{2, 5, 8}));
  EXPECT_EQ(range.frames_of(20), selected);
  EXPECT_EQ(range.count_of(20), 3);
}

TEST(FrameRange, EndsWhereTheFramesDo) {
  EXPECT_EQ(FrameRange{}.frames_of(3), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(FrameRange::parse("1:99:2").frames_of(4), (std::vector<int>{1, 3}));
  for (const char* text : {"4:", "7:9", "4:99:5"}) {
    EXPECT_EQ(FrameRange::parse(text).count_of(4), 0) << text;
    EXPECT_TRUE(FrameRange::parse(text).frames_of(4).empty()) << text;
  }
  EXPECT_EQ(FrameRange{}.count_of(0), 0);
}

} // namespace
} // namespace kinora
