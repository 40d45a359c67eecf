#include "host/plugin_table.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "host/interface_struct.h"

namespace kinora::host {
namespace {

using test::TemporaryFolder;

template <class Call> Error error_of_call(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {ErrorCode::kFailure, ""};
}

void probe_nothing(const char* /*path*/, KinoraProbe* answer) { answer->confidence = 200; }
KinoraStatus open_nothing(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*count*/,
                          KinoraReader** /*reader*/, KinoraMessage* /*message*/) {
  return KINORA_FAILURE;
}
KinoraStatus info_nothing(KinoraReader* /*reader*/, KinoraCaptureInfo* /*info*/, KinoraMessage* /*message*/) {
  return KINORA_FAILURE;
}
KinoraStatus next_nothing(KinoraReader* /*reader*/, KinoraFrame* /*frame*/, KinoraMessage* /*message*/) {
  return KINORA_END;
}
void close_nothing(KinoraReader* /*reader*/) {}

KinoraFormat reading_format(const char* name) {
  auto format = make_struct<KinoraFormat>();
  format.name = name;
  format.description = "a format for this test";
  format.extensions = "";
  format.capabilities = KINORA_READS_FRAMES;
  format.probe = probe_nothing;
  format.open_reader = open_nothing;
  format.reader_info = info_nothing;
  format.reader_next = next_nothing;
  format.reader_close = close_nothing;
  return format;
}

/// Adds one format to a table that has the built-in ones.
void add(PluginTable& table, const KinoraFormat& format) {
  const KinoraFormat* formats[] = {&format};
  auto plugin = make_struct<KinoraPlugin>();
  plugin.name = "test";
  plugin.version = "1";
  plugin.formats = formats;
  plugin.format_count = 1;
  table.add(plugin, "test.so");
}

TEST(PluginTable, BuiltinFormatsHaveUniqueNamesAndDescriptions) {
  const PluginTable table = PluginTable::builtin();
  std::set<std::string> names;
  for (const FormatEntry& entry : table.formats()) {
    EXPECT_TRUE(names.insert(entry.format->name).second) << entry.format->name;
    EXPECT_EQ(entry.origin, "built-in");
    EXPECT_FALSE(capability_names(*entry.format).empty());
    EXPECT_STRNE(entry.format->description, "");
  }
  EXPECT_EQ(names, (std::set<std::string>{"tum-rgbd",
                                          "numbered-folder",
                                          "3dmatch",
                                          "m3t",
                                          "transforms",
                                          "png",
                                          "exr",
                                          "exr-sequence",
                                          "mp4",
                                          "freenect",
                                          "glb",
                                          "gltf-scene",
                                          "usd",
                                          "ply",
                                          "obj",
                                          "oni",
                                          "openni",
                                          "openvdb",
                                          "data-set",
                                          "kinora-clip",
                                          "kinora-recording",
                                          "stray-scanner",
                                          "ros-bag",
                                          "mcap",
                                          "video-pair",
                                          "azure-kinect",
                                          "record3d"}));
}

TEST(PluginTable, ASecondFormatOfTheSameNameIsAnErrorAndChangesNothing) {
  PluginTable table = PluginTable::builtin();
  const std::size_t before = table.formats().size();
  const Error error = error_of_call([&] { add(table, reading_format("png")); });
  EXPECT_NE(std::string(error.what()).find("png is already taken (built-in)"), std::string::npos) << error.what();
  EXPECT_EQ(table.formats().size(), before);
}

TEST(PluginTable, IncompleteDescriptorsAreRefusedByName) {
  const auto fault = [](const auto& damage) {
    PluginTable table;
    KinoraFormat format = reading_format("mine");
    damage(format);
    const Error error = error_of_call([&] { add(table, format); });
    EXPECT_EQ(error.code(), ErrorCode::kMissingComponent);
    EXPECT_TRUE(table.formats().empty());
    return std::string(error.what());
  };
  EXPECT_NE(fault([](KinoraFormat& f) { f.abi_version = 7; }).find("version 7"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.struct_size = 8; }).find("version"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.name = nullptr; }).find("no name"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.name = "Mine"; }).find("no name of lower-case"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.description = nullptr; }).find("description"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.reader_next = nullptr; }).find("for reading"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.capabilities |= KINORA_SEEKS; }).find("reader_seek"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.capabilities |= KINORA_WRITES_PICTURES; }).find("for writing"),
            std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.capabilities = 0; }).find("neither reads nor writes"), std::string::npos);
  EXPECT_NE(fault([](KinoraFormat& f) { f.option_count = 1; }).find("options"), std::string::npos);
}

TEST(PluginTable, FormatsFromBeforeMeshesAndVolumesAreAcceptedIfTheyWriteNone) {
  KinoraFormat old = reading_format("old");
  old.struct_size = offsetof(KinoraFormat, writer_mesh);
  PluginTable table;
  add(table, old);
  EXPECT_EQ(table.formats().size(), 1U);
  old.open_writer = [](const char*, const KinoraOptionValue*, size_t, KinoraWriter**, KinoraMessage*) {
    return KinoraStatus{KINORA_FAILURE};
  };
  old.writer_finish = [](KinoraWriter*, KinoraMessage*) { return KinoraStatus{KINORA_OK}; };
  old.writer_abandon = [](KinoraWriter*) {};
  old.writer_mesh = [](KinoraWriter*, const KinoraMesh*, KinoraMessage*) { return KinoraStatus{KINORA_OK}; };
  old.capabilities |= KINORA_WRITES_MESHES; // beyond the size that it states
  PluginTable other;
  const Error error = error_of_call([&] { add(other, old); });
  EXPECT_NE(std::string(error.what()).find("writer_mesh"), std::string::npos) << error.what();
  old.struct_size = sizeof(KinoraFormat);
  add(other, old);
  EXPECT_EQ(other.formats().size(), 1U);
}

TEST(PluginTable, WritersOfMeshesAndVolumesAreFoundByWhatTheyWrite) {
  const PluginTable table = PluginTable::builtin();
  EXPECT_STREQ(table.writer_for("a.glb", KINORA_WRITES_MESHES).name, "glb");
  EXPECT_STREQ(table.writer_for("a.vdb", KINORA_WRITES_MESHES | KINORA_WRITES_VOLUMES).name, "openvdb");
  EXPECT_THROW((void)table.writer_for("a.glb"), Error); // it writes no pictures
}

TEST(PluginTable, ProbeGivesAllScoresTheSurestFirst) {
  const TemporaryFolder folder;
  test::write_numbered(folder, 1);
  PluginTable table = PluginTable::builtin();
  const std::vector<ProbeScore> scores = table.probe(folder.path());
  const auto readers = std::ranges::count_if(
      table.formats(), [](const FormatEntry& entry) { return supports(*entry.format, KINORA_READS_FRAMES); });
  ASSERT_EQ(static_cast<std::ptrdiff_t>(scores.size()), readers);
  EXPECT_STREQ(scores[0].format->name, "numbered-folder");
  for (const ProbeScore& score : scores) EXPECT_FALSE(score.reason.empty());
  const KinoraFormat boastful = reading_format("boastful");
  add(table, boastful);
  EXPECT_EQ(table.probe(folder.path())[0].confidence, 100); // cut to what the interface allows
}

TEST(PluginTable, WritersAreFoundByExtension) {
  const PluginTable table = PluginTable::builtin();
  EXPECT_STREQ(table.writer_for("a/b.mp4").name, "mp4");
  EXPECT_STREQ(table.writer_for("b.png").name, "png");
  for (const char* path : {"b.gif", "folder", "b.mp4.part"}) {
    const Error error = error_of_call([&] { (void)table.writer_for(path); });
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find(".mp4"), std::string::npos);
  }
}

TEST(PluginTable, UnknownNamesListWhatThereIs) {
  const PluginTable table = PluginTable::builtin();
  const Error error = error_of_call([&] { (void)table.find("tum"); });
  EXPECT_EQ(error.code(), ErrorCode::kUsage);
  EXPECT_NE(std::string(error.what()).find("tum-rgbd, numbered-folder"), std::string::npos);
}

} // namespace
} // namespace kinora::host
