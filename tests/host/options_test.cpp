#include "host/options.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

std::string usage_of(const std::function<void()>& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    return error.what();
  }
  return {};
}

void expect_usage(const std::string& word, const std::function<void()>& call) {
  const std::string said = usage_of(call);
  EXPECT_NE(said.find(word), std::string::npos) << said;
}

TEST(Options, WordsBecomePairsAndTheLastOneCounts) {
  const std::string words[] = {"crf=20", "fps=24", "crf=30", "empty=", "a=b=c"};
  EXPECT_EQ(parse_options(words), (Options{{"crf", "30"}, {"fps", "24"}, {"empty", ""}, {"a", "b=c"}}));
}

TEST(Options, WordsWithoutKeyOrValueAreRefused) {
  for (const std::string word : {"crf", "=5", ""}) expect_usage("key=value", [&] { parse_options({&word, 1}); });
}

TEST(Options, ValuesAreCheckedAgainstTheFormatsDeclaration) {
  const PluginTable table = PluginTable::builtin();
  const KinoraFormat& mp4 = table.find("mp4");
  check_options(mp4, {{"crf", "23"}, {"fps", "29.97"}});
  expect_usage("type int", [&] { check_options(mp4, {{"crf", "best"}}); });
  expect_usage("type int", [&] { check_options(mp4, {{"crf", "1.5"}}); });
  expect_usage("type int", [&] { check_options(mp4, {{"crf", "99999999999"}}); });
  expect_usage("type number", [&] { check_options(mp4, {{"fps", "nan"}}); });
  expect_usage("type number", [&] { check_options(mp4, {{"fps", "24x"}}); });
  expect_usage("it has fps, crf", [&] { check_options(mp4, {{"speed", "1"}}); });
  expect_usage("the nearest is fps", [&] { check_options(mp4, {{"fsp", "1"}}); });
  const std::string others[] = {"layers"};
  expect_usage("the nearest is layers; it has layers, fps", [&] { check_options(mp4, {{"layer", "1"}}, others); });
  const KinoraFormat& png = table.find("png");
  check_options(png, {{"layout", "folder"}});
  expect_usage("auto|folder|file", [&] { check_options(png, {{"layout", "auto|folder"}}); });
  const KinoraFormat& tum = table.find("tum-rgbd");
  check_options(tum, {{"masks", "false"}});
  expect_usage("true or false", [&] { check_options(tum, {{"masks", "no"}}); });
  const std::string both_have[] = {"masks", "near"};
  EXPECT_EQ(usage_of([&] {
              check_options(tum, {{"mask", "true"}}, both_have);
            }),
            "the format tum-rgbd has no option \"mask\"; the nearest is masks; it has masks, near");
}

} // namespace
} // namespace kinora::host
