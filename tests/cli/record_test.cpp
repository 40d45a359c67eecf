// kinora record, recover and validate, as a user runs them.
#include <algorithm>

#include "cli/run_kinora.h"
#include "cli/small_disk.h"
#include "container/reader.h"
#include "container/recovery.h"
#include "container/writer.h"
#include "host/frame_reader.h"
#include "host/plugin_table.h"
#include "recording/recording_file.h"

namespace kinora::test {
namespace {

class Record : public ::testing::Test {
protected:
  Said run(const std::vector<std::string>& words) { return run_kinora(folder_, words); }
  std::string path(const char* name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  std::string capture_ = KINORA_SAMPLES "/carry_box";
};

std::vector<std::byte> bytes_of(const KinoraImage& image) {
  std::vector<std::byte> out;
  const std::size_t row = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels) *
                          (image.pixel_type == KINORA_PIXEL_U16 ? 2 : 1);
  for (int v = 0; image.data != nullptr && v < image.height; ++v) {
    const auto* from = static_cast<const std::byte*>(image.data) + image.row_bytes * static_cast<std::size_t>(v);
    out.insert(out.end(), from, from + row);
  }
  return out;
}

/// The frames of `recording` are the first ones of `capture`, bit by bit; how many there are.
int expect_same_frames(const std::string& recording, const std::string& capture) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  host::FrameReader recorded(plugins.recognise(recording), recording, {});
  host::FrameReader original(plugins.recognise(capture), capture, {});
  int count = 0;
  while (const auto a = recorded.next()) {
    const auto b = original.next();
    EXPECT_TRUE(b.has_value() && a->problem.empty()) << a->problem;
    if (!b) break;
    EXPECT_EQ(a->frame.time, b->frame.time);
    EXPECT_EQ(a->frame.depth_unit, b->frame.depth_unit);
    EXPECT_EQ(bytes_of(a->frame.color), bytes_of(b->frame.color));
    EXPECT_EQ(bytes_of(a->frame.depth), bytes_of(b->frame.depth));
    EXPECT_EQ(bytes_of(a->frame.labels), bytes_of(b->frame.labels));
    EXPECT_EQ(a->frame.has_pose, b->frame.has_pose);
    EXPECT_TRUE(std::ranges::equal(a->frame.camera_to_world, b->frame.camera_to_world));
    ++count;
  }
  return count;
}

TEST_F(Record, ReadsBackBitByBitAndIsSound) {
  const Said said = run({"record", capture_, path("r.mkv"), "--duration", "0.5"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_GE(expect_same_frames(path("r.mkv"), capture_), 10);
  EXPECT_EQ(run({"validate", path("r.mkv")}).code, 0);
  EXPECT_NE(run({"info", path("r.mkv")}).out.find("a recording"), std::string::npos);
}

TEST_F(Record, CutFileIsRecoveredUpToTheCut) {
  ASSERT_EQ(run({"record", capture_, path("r.mkv"), "--duration", "1.2"}).code, 0);
  fs::resize_file(path("r.mkv"), fs::file_size(path("r.mkv")) * 3 / 4);
  expect_error(run({"validate", path("r.mkv")}), 4, "kinora recover");
  const Said said = run({"recover", path("r.mkv"), path("saved.mkv")});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("Lost:"), std::string::npos);
  EXPECT_EQ(run({"validate", path("saved.mkv")}).code, 0);
  EXPECT_GE(expect_same_frames(path("saved.mkv"), capture_), 10);
}

/// Writes all of a recording but a part of its middle, whose bytes are gone without a trace.
void leave_out_middle(const std::string& whole, const std::string& without) {
  container::Reader reader(whole);
  container::FileHead head;
  head.kind = recording::kRecordingKind;
  for (std::size_t t = 0; t < reader.tracks().size(); ++t) {
    head.tracks.push_back(reader.tracks()[t].track);
    if (!reader.tracks()[t].ours) head.tracks.back().id = static_cast<std::uint16_t>(1000 + t);
  }
  for (const container::StoredAttachment& file : reader.attachments())
    head.attachments.push_back({file.name, file.media_type, file.description, reader.read_attachment(file)});
  container::WriterOptions any_order; // blocks' times are rounded
  any_order.any_order = true;
  container::Writer writer(without, head, any_order);
  container::StoredBlock block;
  while (reader.next_block(block)) {
    if (block.time_ns > 250'000'000 && block.time_ns < 350'000'000) continue;
    if (reader.tracks()[block.track].ours) {
      const container::Payload payload = reader.read_payload(block);
      writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
    } else {
      writer.write(static_cast<std::uint16_t>(1000 + block.track), block.time_ns, block.key, reader.read_block(block));
    }
  }
  writer.finish();
}

TEST_F(Record, FramesThatAreGoneWithoutATraceAreNoticed) {
  ASSERT_EQ(run({"record", capture_, path("r.mkv"), "--duration", "0.6"}).code, 0);
  leave_out_middle(path("r.mkv"), path("less.mkv"));
  expect_error(run({"validate", path("less.mkv")}), 4, "lacks 3 frames");
  const Said said = run({"recover", path("less.mkv"), path("saved.mkv")});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("lacks 3 frames"), std::string::npos) << said.out;
  EXPECT_EQ(said.out.find("Nothing was lost"), std::string::npos) << said.out;
}

TEST_F(Record, FlippedBitInAPictureIsFound) {
  ASSERT_EQ(run({"record", capture_, path("r.mkv"), "--duration", "0.3"}).code, 0);
  std::fstream file(path("r.mkv"), std::ios::in | std::ios::out | std::ios::binary);
  const auto middle = static_cast<std::streamoff>(fs::file_size(path("r.mkv")) / 2);
  file.seekg(middle);
  const char flipped = static_cast<char>(file.get() ^ 0x10);
  file.seekp(middle);
  file.put(flipped);
  file.close();
  expect_error(run({"validate", path("r.mkv")}), 4, "damaged");
}

TEST_F(Record, ExistingFileIsNotReplaced) {
  folder_.write("r.mkv", "precious");
  expect_error(run({"record", capture_, path("r.mkv")}), 5, "--overwrite");
  EXPECT_EQ(contents_of(path("r.mkv")), "precious");
}

TEST_F(Record, FullDiskLeavesACompleteRecordingOfWhatFitted) {
  ASSERT_EQ(run({"record", capture_, path("whole.mkv"), "--duration", "1.2"}).code, 0);
  Said said;
  {
    const SmallDisk disk(fs::file_size(path("whole.mkv")) * 3 / 4);
    said = run({"record", capture_, path("r.mkv"), "--duration", "1.2"});
  }
  expect_error(said, 5, "is complete up to there");
  EXPECT_EQ(run({"validate", path("r.mkv")}).code, 0);
  EXPECT_GE(expect_same_frames(path("r.mkv"), capture_), 10);
}

TEST_F(Record, FullDiskWithoutRoomForAFrameLeavesNoFileAndSaysSo) {
  for (const rlim_t bytes : {500U, 10'000U}) { // not even the head; not one segment
    const SmallDisk disk(bytes);
    expect_error(run({"record", capture_, path("r.mkv"), "--duration", "0.3"}), 5, "holds no frame");
    EXPECT_FALSE(fs::exists(path("r.mkv"))) << bytes;
  }
}

TEST_F(Record, PngColorAndPosesReadBackBitByBit) {
  write_3dmatch(folder_, 4);
  ASSERT_EQ(run({"record", folder_.path().string(), path("r.mkv")}).code, 0);
  EXPECT_EQ(expect_same_frames(path("r.mkv"), folder_.path().string()), 4);
}

TEST_F(Record, LiveRecordingEndsCompleteWhereTheCameraIsDisconnected) {
  folder_.write("faults.txt", "# of the camera\ndrop 0.03 0.02\ndisconnect 0.1\n");
  const Said said = run({"record", capture_, path("r.mkv"), "--live", "--live-script", path("faults.txt")});
  expect_error(said, 1, "disconnected");
  EXPECT_EQ(run({"validate", path("r.mkv")}).code, 0);
  const recording::RecordingFile file(path("r.mkv"));
  ASSERT_GE(file.frame_count(), 1U);
  EXPECT_TRUE(file.record(0).host_time_ns.has_value());
  EXPECT_LE(file.record(file.frame_count() - 1).index, 3);
}

TEST_F(Record, ScriptThatIsNoneIsRefusedBeforeAnythingIsWritten) {
  folder_.write("faults.txt", "stall 1 2\nexplode 3\n");
  expect_error(run({"record", capture_, path("r.mkv"), "--live", "--live-script", path("faults.txt")}), 4, "line 2");
  EXPECT_FALSE(fs::exists(path("r.mkv")));
}

TEST_F(Record, ArchiveHoldsTheCaptureBesideTheClip) {
  const Said said = run({"encode", capture_, path("clip.mkv"), "--archive", "--preset", "fast", "--frames", "0:2"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(run({"info", path("clip.mkv")}).out.find("background"), std::string::npos);
  EXPECT_GE(expect_same_frames(path("clip.mkv"), capture_), 50); // all of them, though two were encoded
}

/// Where the segments of a finished file end, and how many frames there are up to each.
std::vector<std::pair<std::uint64_t, int>> segment_ends(const std::string& path) {
  container::Reader reader(path);
  container::StoredBlock block;
  std::vector<std::pair<std::uint64_t, int>> ends;
  int frames = 0;
  std::uint64_t end = 0;
  while (reader.next_block(block)) {
    if (end != 0 && block.offset != end) ends.emplace_back(end, frames); // a segment's head lies between
    frames += reader.tracks()[block.track].ours ? 1 : 0;
    end = block.offset + block.stored_bytes;
  }
  ends.emplace_back(end, frames);
  return ends;
}

TEST_F(Record, KilledAtAnyMomentLosesTheUnfinishedSegmentAtMost) {
  constexpr int kFrames = 150, kMoments = 50;
  const TemporaryFolder capture;
  write_numbered(capture, kFrames);
  const std::string whole = path("whole.mkv");
  ASSERT_EQ(run({"record", capture.path().string(), whole}).code, 0);
  const auto ends = segment_ends(whole);
  ASSERT_GE(ends.size(), 8U);
  ASSERT_EQ(ends.back().second, kFrames);
  const std::uint64_t whole_bytes = fs::file_size(whole);
  const std::string file = path("r.mkv");
  Progress quiet;
  Random random(32);
  int killed_in_between = 0;
  for (int moment = 0; moment < kMoments; ++moment) {
    SCOPED_TRACE(moment);
    fs::remove(file);
    const std::uint64_t at = random.below(static_cast<std::uint32_t>(whole_bytes));
    const std::uint32_t later = random.below(2000);
    Running running(folder_.path(), {"record", capture.path().string(), file});
    std::error_code ignored;
    for (std::uintmax_t size = 0; size < at || size == static_cast<std::uintmax_t>(-1);)
      size = running.ended() ? at : fs::file_size(file, ignored);
    usleep(later); // of the moment, which the seed chooses; nothing depends on it
    running.kill_at_once();
    running.finish();
    const std::uint64_t bytes = fs::file_size(file, ignored);
    int promised = 0;
    for (const auto& [end, frames] : ends)
      if (end <= bytes) promised = frames;
    killed_in_between += promised > 0 && promised < kFrames ? 1 : 0;
    if (promised == 0) continue; // the first segment was not finished
    EXPECT_GE(expect_same_frames(file, capture.path().string()), promised);
    container::recover(file, path("saved.mkv"), quiet);
    EXPECT_GE(expect_same_frames(path("saved.mkv"), capture.path().string()), promised);
  }
  EXPECT_GE(killed_in_between, kMoments / 2);
}

} // namespace
} // namespace kinora::test
