#include "container/valid_utf8.h"

#include <gtest/gtest.h>

namespace kinora::container {
namespace {

TEST(ValidUtf8, LeavesWellFormedTextAsItIs) {
  for (const char* text : {"", "person", "\xC3\xA4\xE2\x82\xAC\xF0\x9F\x8E\xA5"}) EXPECT_EQ(valid_utf8(text), text);
}

TEST(ValidUtf8, ReplacesEachByteThatIsPartOfNoSequence) {
  EXPECT_EQ(valid_utf8("a\xFF"
                       "b"),
            "a\xEF\xBF\xBD"
            "b");
  EXPECT_EQ(valid_utf8("\xF0\x9F\x8E"), "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD"); // cut
  EXPECT_EQ(valid_utf8("\xC0\x80"), "\xEF\xBF\xBD\xEF\xBF\xBD");                 // longer than it needs to be
  EXPECT_EQ(valid_utf8("\xED\xA0\x80"), "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD"); // half of a pair of UTF-16
}

} // namespace
} // namespace kinora::container
