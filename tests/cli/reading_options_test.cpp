// -O of the commands that read captures.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "formats/capture_frames.h"

namespace kinora::test {
namespace {

class ReadingOptions : public testing::Test {
protected:
  ReadingOptions() {
    write_numbered(folder_, 3);
    folder_.write("mask/000000.png", encode_png(ColorImage(kSampleWidth, kSampleHeight, 1, 1)));
  }
  Said run(const std::vector<std::string>& words) const { return run_kinora(out_, words); }
  std::string capture() const { return folder_.path().string(); }
  std::string out(const char* name) const { return (out_.path() / name).string(); }

  TemporaryFolder folder_, out_;
};

TEST_F(ReadingOptions, ReachTheReader) {
  const auto has_masks = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"info", capture(), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return nlohmann::json::parse(run(words).out)["has_masks"].get<bool>();
  };
  EXPECT_TRUE(has_masks({}));
  EXPECT_FALSE(has_masks({"-O", "masks=false"}));
  EXPECT_FALSE(has_masks({"--format", "numbered-folder", "-O", "masks=false"}));

  ASSERT_EQ(run({"record", capture(), out("r.mkv"), "-O", "masks=false"}).code, 0);
  EXPECT_TRUE(read_capture(out("r.mkv")).frames.at(0).labels.empty());
  ASSERT_EQ(run({"record", capture(), out("r.mkv"), "--overwrite"}).code, 0);
  EXPECT_FALSE(read_capture(out("r.mkv")).frames.at(0).labels.empty());
}

TEST_F(ReadingOptions, AnUnknownOneIsRefusedWithTheNearest) {
  const std::vector<std::vector<std::string>> commands{{"encode", capture(), out("c.mkv")},
                                                       {"encode", capture(), out("c.mkv"), "--live"},
                                                       {"record", capture(), out("r.mkv")},
                                                       {"convert", capture(), out("v.mkv")},
                                                       {"convert", capture(), out("v"), "--to", "tum-rgbd"},
                                                       {"info", capture()}};
  for (std::vector<std::string> words : commands) {
    words.insert(words.end(), {"-O", "maks=false"});
    expect_error(run(words), 2, "the nearest is masks");
  }
  EXPECT_EQ(names_in(out_.path()), std::vector<std::string>{"stdout.txt"});
}

TEST_F(ReadingOptions, AValueOfAnotherTypeAndAWordWithoutValueAreRefused) {
  expect_error(run({"encode", capture(), out("c.mkv"), "-O", "masks=perhaps"}), 2, "must be of type bool");
  expect_error(run({"record", capture(), out("r.mkv"), "-O", "masks"}), 2, "-O key=value");
  EXPECT_EQ(names_in(out_.path()), std::vector<std::string>{"stdout.txt"});
}

} // namespace
} // namespace kinora::test
