#include <gtest/gtest.h>

#include "core/error.h"
#include "ingest/capture.h"

namespace kinora::ingest {
namespace {

struct Case {
  const char* text;
  int begin, end, step;
};

TEST(FrameRange, PartsMayBeLeftOut) {
  for (const Case& expected :
       {Case{"3:10:2", 3, 10, 2}, Case{"3:10", 3, 10, 1}, Case{"3:", 3, -1, 1}, Case{":7", 0, 7, 1},
        Case{"::5", 0, -1, 5}, Case{":", 0, -1, 1}, Case{"3", 3, 4, 1}, Case{"1:2:", 1, 2, 1}}) {
    const FrameRange range = FrameRange::parse(expected.text);
    EXPECT_EQ(range.begin, expected.begin) << expected.text;
    EXPECT_EQ(range.end, expected.end) << expected.text;
    EXPECT_EQ(range.step, expected.step) << expected.text;
  }
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

TEST(FrameRange, ContainsWhatItSelects) {
  const FrameRange range = FrameRange::parse("2:9:3");
  std::vector<int> selected;
  for (int i = 0; i < 20; ++i)
    if (range.contains(i)) selected.push_back(i);
  EXPECT_EQ(selected, (std::vector<int>{2, 5, 8}));
}

} // namespace
} // namespace kinora::ingest
