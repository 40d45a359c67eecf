#include <algorithm>
#include <chrono>
#include <cstdlib>

#include <gtest/gtest.h>

#include "formats/sample_capture.h"
#include "host/frame_reader.h"
#include "host/host_services.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

class Listener final : public Progress {
public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  std::vector<std::string> warnings;
};

/// A table with the built-in formats and those of one folder that holds copies of these libraries.
class ExternalPlugins : public testing::Test {
protected:
  void load(const std::vector<fs::path>& libraries) {
    for (const fs::path& library : libraries) fs::copy(library, folder_.path());
    const fs::path folders[] = {folder_.path(), folder_.path() / "absent"};
    load_external_plugins(table_, folders, listener_);
  }

  TemporaryFolder folder_;
  PluginTable table_ = PluginTable::builtin();
  Listener listener_;
};

TEST_F(ExternalPlugins, AFormatWrittenInCIsRecognisedAndRead) {
  load({KINORA_EXAMPLE_PLUGIN});
  EXPECT_TRUE(listener_.warnings.empty());
  folder_.write("a.world", "flat and grey");
  const KinoraFormat& format = table_.recognise(folder_.path() / "a.world");
  ASSERT_STREQ(format.name, "flat");
  FrameReader reader(format, folder_.path() / "a.world", {});
  EXPECT_EQ(reader.info().frame_count, 4);
  EXPECT_EQ(reader.next()->frame.index, 0);
  reader.seek(2); // by reading on, for the format cannot seek
  const auto bad = reader.next();
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->problem, "frame 2 of the flat world has a dent");
  const auto good = reader.next();
  ASSERT_TRUE(good);
  EXPECT_TRUE(good->problem.empty());
  EXPECT_EQ(static_cast<const std::uint8_t*>(good->frame.color.data)[0], 103);
  EXPECT_FALSE(reader.next());
  EXPECT_THROW(reader.seek(0), Error);
}

TEST_F(ExternalPlugins, TheHostGivesThemFilesMemoryALogAndProgress) {
  std::vector<std::string> said;
  std::uint64_t steps = 0;
  bool stop = false;
  set_plugin_listener({[&](const std::string& sentence, bool is_warning) {
                         said.push_back((is_warning ? "warning: " : "detail: ") + sentence);
                       },
                       [&](std::uint64_t done, std::uint64_t total) {
                         EXPECT_EQ(total, 3U);
                         steps = done;
                         return stop;
                       }});
  load({KINORA_EXAMPLE_PLUGIN_HOSTED});
  folder_.write("a.world", "flat and grey");
  const KinoraFormat& format = table_.find("flat");
  {
    FrameReader reader(format, folder_.path() / "a.world", {});
    EXPECT_TRUE(reader.next());
  }
  EXPECT_EQ(said, (std::vector<std::string>{"warning: the world is flat", "detail: it has four corners"}));
  EXPECT_EQ(steps, 2U);
  const auto refused = [&](const char* file, const std::string& why) {
    try {
      const FrameReader reader(format, folder_.path() / file, {});
      ADD_FAILURE() << file;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused("absent.world", "not a regular file");
  folder_.write("short.world", "fl");
  refused("short.world", "ends too early");
  stop = true;
  refused("a.world", "stopped as asked");
  set_plugin_listener({});
}

TEST_F(ExternalPlugins, APluginWhoseNameIsTakenIsLeftOutWithOneWarning) {
  load({KINORA_EXAMPLE_PLUGIN_TAKEN});
  EXPECT_EQ(table_.formats().size(), PluginTable::builtin().formats().size());
  ASSERT_EQ(listener_.warnings.size(), 1U);
  EXPECT_NE(listener_.warnings[0].find("already taken"), std::string::npos);
}

TEST_F(ExternalPlugins, APluginOfAnotherVersionIsLeftOutWithOneWarning) {
  load({KINORA_EXAMPLE_PLUGIN_OLD});
  ASSERT_EQ(listener_.warnings.size(), 1U);
  EXPECT_NE(listener_.warnings[0].find("version 99"), std::string::npos) << listener_.warnings[0];
}

TEST_F(ExternalPlugins, AFileThatIsNoLibraryIsLeftOutWithOneWarning) {
  folder_.write("broken.so", "not a library");
  load({KINORA_EXAMPLE_PLUGIN});
  ASSERT_EQ(listener_.warnings.size(), 1U);
  EXPECT_NE(listener_.warnings[0].find("broken.so"), std::string::npos);
  EXPECT_NE(listener_.warnings[0].find("cannot be loaded"), std::string::npos);
  EXPECT_STREQ(table_.find("flat").name, "flat");
}

TEST_F(ExternalPlugins, ACrashInAProbeIsNamedAndTheRestWorks) {
  load({KINORA_EXAMPLE_PLUGIN_CRASHING});
  test::write_numbered(folder_, 1);
  const std::vector<ProbeScore> scores = table_.probe(folder_.path());
  EXPECT_STREQ(scores.front().format->name, "numbered-folder");
  const auto flat =
      std::ranges::find_if(scores, [](const ProbeScore& score) { return std::string(score.format->name) == "flat"; });
  ASSERT_NE(flat, scores.end());
  EXPECT_EQ(flat->confidence, 0);
  EXPECT_NE(flat->reason.find("crashed"), std::string::npos) << flat->reason;
}

TEST_F(ExternalPlugins, AProbeThatNeverEndsIsLeftAfterTwoSeconds) {
  load({KINORA_EXAMPLE_PLUGIN_HANGING});
  const auto start = std::chrono::steady_clock::now();
  const std::vector<ProbeScore> scores = table_.probe(folder_.path());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const auto flat =
      std::ranges::find_if(scores, [](const ProbeScore& score) { return std::string(score.format->name) == "flat"; });
  ASSERT_NE(flat, scores.end());
  EXPECT_EQ(flat->confidence, 0);
  EXPECT_NE(flat->reason.find("did not answer within 2 s"), std::string::npos) << flat->reason;
  EXPECT_LT(took.count(), 10);
}

TEST_F(ExternalPlugins, ALibraryThatCrashesWhenItIsOpenedIsLeftOutWithOneWarning) {
  load({KINORA_EXAMPLE_PLUGIN, KINORA_EXAMPLE_PLUGIN_STILLBORN});
  ASSERT_EQ(listener_.warnings.size(), 1U);
  EXPECT_NE(listener_.warnings[0].find("crashed"), std::string::npos) << listener_.warnings[0];
  EXPECT_NE(listener_.warnings[0].find("opened on trial"), std::string::npos) << listener_.warnings[0];
  EXPECT_STREQ(table_.find("flat").name, "flat");
}

TEST_F(ExternalPlugins, FoldersComeFromTheCallAndFromTheEnvironment) {
  setenv("KINORA_PLUGIN_PATH", "/one::/two", 1);
  const fs::path extra[] = {"/first"};
  const std::vector<fs::path> folders = plugin_folders(extra);
  unsetenv("KINORA_PLUGIN_PATH");
  ASSERT_EQ(folders.size(), 4U);
  EXPECT_EQ(folders[0], "/first");
  EXPECT_EQ(folders[1], "/one");
  EXPECT_EQ(folders[2], "/two");
  EXPECT_TRUE(folders[3].string().ends_with("lib/kinora/plugins"));
}

} // namespace
} // namespace kinora::host
