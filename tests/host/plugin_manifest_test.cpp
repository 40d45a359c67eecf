#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include "formats/sample_capture.h"
#include "host/frame_reader.h"
#include "host/picture_writer.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::TemporaryFolder;

class Listener final : public Progress {
public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  std::vector<std::string> warnings;
};

Json manifest() {
  return {{"name", "flat-world"},
          {"version", "1.0"},
          {"license", "MIT"},
          {"abi", {1, 1}},
          {"library", "flat.so"},
          {"formats",
           {{{"name", "flat"},
             {"description", "a flat world"},
             {"magic", {{{"text", "flat"}}}},
             {"can", {"read-frames", "read-confidence", "read-infrared"}}}}}};
}

/// The built-in formats and a folder of one plugin, as it would be installed; a.world is a file of its format.
class PluginFolder : public testing::Test {
protected:
  PluginFolder() {
    folder_.write("a.world", "flat and grey");
    folder_.write("other.bin", "something else");
  }
  void load(const Json& json, const std::string& library) {
    folder_.write("plugins/flat/plugin.json", json.dump());
    if (!library.empty()) fs::copy(library, folder_.path() / "plugins/flat/flat.so");
    const fs::path folders[] = {folder_.path() / "plugins"};
    load_external_plugins(table_, folders, listener_);
  }
  ProbeScore score_of_flat(const char* file) const {
    for (const ProbeScore& score : table_.probe(folder_.path() / file))
      if (std::string(score.format->name) == "flat") return score;
    return {nullptr, -1, "", ""};
  }
  void expect_refused(const std::string& word) const {
    try {
      table_.find("flat");
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kMissingComponent);
      EXPECT_NE(std::string(error.what()).find("flat.so"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
  void expect_left_out(const Json& json, const std::string& word) {
    load(json, "");
    ASSERT_EQ(listener_.warnings.size(), 1U);
    EXPECT_NE(listener_.warnings[0].find(word), std::string::npos) << listener_.warnings[0];
    EXPECT_EQ(table_.formats().size(), PluginTable::builtin().formats().size());
  }

  TemporaryFolder folder_;
  PluginTable table_ = PluginTable::builtin();
  Listener listener_;
};

TEST_F(PluginFolder, AFormatIsRecognisedAndRead) {
  load(manifest(), KINORA_EXAMPLE_PLUGIN);
  EXPECT_TRUE(listener_.warnings.empty());
  EXPECT_EQ(score_of_flat("a.world").confidence, 100);
  FrameReader reader(table_.recognise(folder_.path() / "a.world"), folder_.path() / "a.world", {});
  EXPECT_EQ(reader.info().frame_count, 4);
  EXPECT_TRUE(reader.next());
}

TEST_F(PluginFolder, AFrozenBinaryOfTheFirstInterfaceStillReads) {
  if (std::string(KINORA_FROZEN_PLUGIN).empty()) GTEST_SKIP() << "it is a binary for another processor";
  load(manifest(), KINORA_FROZEN_PLUGIN);
  FrameReader reader(table_.recognise(folder_.path() / "a.world"), folder_.path() / "a.world", {});
  const auto frame = reader.next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(static_cast<const std::uint16_t*>(frame->frame.depth.data)[0], 500);
}

TEST_F(PluginFolder, AFrozenBinaryOfTheFirstInterfaceStillWrites) {
  if (std::string(KINORA_FROZEN_WRITER).empty()) GTEST_SKIP() << "it is a binary for another processor";
  Json json = manifest();
  json["formats"] = {{{"name", "lines"},
                      {"description", "a line for each picture"},
                      {"extensions", ".lines"},
                      {"can", {"write-pictures"}}}};
  load(json, KINORA_FROZEN_WRITER);
  ASSERT_TRUE(listener_.warnings.empty()) << listener_.warnings[0];
  const fs::path path = folder_.path() / "a.lines";
  PictureWriter writer(table_.find("lines"), path, {});
  writer.write({"first", 0, ColorImage(4, 3, 3, 77), {}, {}, {}});
  writer.write({"second", 0.1, ColorImage(4, 3, 4, 255), {}, {}, {}});
  writer.finish();
  std::ifstream file(path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "first 4x3 77\nsecond 4x3 255\n");
}

TEST_F(PluginFolder, TheLibraryIsNotOpenedForFilesWithoutItsBytes) {
  load(manifest(), KINORA_EXAMPLE_PLUGIN_CRASHING);
  EXPECT_NE(score_of_flat("other.bin").reason.find("has not the bytes"), std::string::npos);
}

TEST_F(PluginFolder, ACrashInAProbeIsNamedAndTheRestWorks) {
  load(manifest(), KINORA_EXAMPLE_PLUGIN_CRASHING);
  const ProbeScore score = score_of_flat("a.world");
  EXPECT_EQ(score.confidence, 0);
  EXPECT_NE(score.reason.find("flat.so crashed"), std::string::npos) << score.reason;
  test::write_numbered(folder_, 1);
  EXPECT_STREQ(table_.recognise(folder_.path()).name, "numbered-folder");
}

TEST_F(PluginFolder, AProbeThatNeverEndsIsNamedAndTheRestWorks) {
  load(manifest(), KINORA_EXAMPLE_PLUGIN_HANGING);
  const ProbeScore score = score_of_flat("a.world");
  EXPECT_EQ(score.confidence, 0);
  EXPECT_NE(score.reason.find("did not answer within 2 s"), std::string::npos) << score.reason;
}

TEST_F(PluginFolder, ALibraryThatLiesAboutItsVersionIsRefused) {
  load(manifest(), KINORA_EXAMPLE_PLUGIN_OLD);
  EXPECT_EQ(score_of_flat("a.world").confidence, 0);
  expect_refused("version 99");
}

TEST_F(PluginFolder, AFileThatIsNoLibraryIsRefused) {
  folder_.write("plugins/flat/flat.so", "not a library");
  load(manifest(), "");
  expect_refused("cannot be loaded");
}

TEST_F(PluginFolder, ALibraryThatCanDoOtherThingsThanPromisedIsRefused) {
  Json json = manifest();
  json["formats"][0]["can"] = {"read-frames"};
  load(json, KINORA_EXAMPLE_PLUGIN);
  EXPECT_EQ(score_of_flat("a.world").confidence, 0);
  expect_refused("can do other things");
}

TEST_F(PluginFolder, AFileOfAPluginThatIsNotInstalledSaysWhichItNeeds) {
  load(manifest(), "");
  try {
    table_.recognise(folder_.path() / "a.world");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMissingComponent);
    EXPECT_NE(std::string(error.what()).find("could have been read by the format flat, which is not installed"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(PluginFolder, AManifestForAnotherInterfaceIsLeftOut) {
  Json json = manifest();
  json["abi"] = {2, 3};
  expect_left_out(json, "versions 2 to 3");
}

TEST_F(PluginFolder, AManifestWithoutALicenceIsLeftOut) {
  Json json = manifest();
  json.erase("license");
  expect_left_out(json, "\"license\" must be text");
}

TEST_F(PluginFolder, ALibraryOutsideOfTheFolderIsNotOpened) {
  Json json = manifest();
  json["library"] = "../evil.so";
  expect_left_out(json, "a file beside it");
}

} // namespace
} // namespace kinora::host
