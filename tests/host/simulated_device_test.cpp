#include "host/simulated_device.h"

#include <gtest/gtest.h>

#include "host/frame_reader.h"
#include "host/interface_struct.h"

namespace kinora::host {
namespace {

constexpr double kRate = 10; // frames per second
constexpr std::int64_t kFrames = 40;

/// Time passes only where somebody sleeps or works.
class FakeClock final : public DeviceClock {
public:
  double now() const override { return now_; }
  void sleep(double seconds) override { now_ += seconds; }
  void work(double seconds) { now_ += seconds; }

private:
  double now_ = 1000;
};

/// A format whose frames have the times 100, 100.1, …
struct Reader {
  std::int64_t next = 0;
};
Reader* reader_of(KinoraReader* reader) { return reinterpret_cast<Reader*>(reader); }

KinoraStatus open_reader(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*count*/,
                         KinoraReader** reader, KinoraMessage* /*message*/) {
  *reader = reinterpret_cast<KinoraReader*>(new Reader);
  return KINORA_OK;
}
KinoraStatus reader_info(KinoraReader* /*reader*/, KinoraCaptureInfo* info, KinoraMessage* /*message*/) {
  info->frame_count = kFrames;
  info->frames_per_second = kRate;
  info->camera = {16, 12, 20, 20, 7.5, 5.5, {}, {}};
  return KINORA_OK;
}
KinoraStatus reader_next(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* /*message*/) {
  static const std::uint16_t pixels[16 * 12 * 2] = {};
  if (reader_of(reader)->next == kFrames) return KINORA_END;
  frame->color = {16, 12, 3, KINORA_PIXEL_U8, 16 * 3, pixels, {}};
  frame->depth = {16, 12, 1, KINORA_PIXEL_U16, 16 * 2, pixels, {}};
  frame->depth_unit = 0.001;
  frame->index = reader_of(reader)->next++;
  frame->time = 100 + static_cast<double>(frame->index) / kRate;
  return KINORA_OK;
}
KinoraStatus reader_seek(KinoraReader* reader, int64_t index, KinoraMessage* /*message*/) {
  reader_of(reader)->next = index;
  return KINORA_OK;
}
void close_reader(KinoraReader* reader) { delete reader_of(reader); }

KinoraFormat format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "test";
  format.capabilities = KINORA_READS_FRAMES | KINORA_SEEKS;
  format.open_reader = open_reader;
  format.reader_info = reader_info;
  format.reader_next = reader_next;
  format.reader_seek = reader_seek;
  format.reader_close = close_reader;
  return format;
}

/// What comes out of a device if every frame costs `work` seconds.
struct Replay {
  std::vector<std::int64_t> frames;
  std::vector<double> ages; ///< when they came
  std::uint32_t dropped = 0;
};

Replay replay(const std::string& script, double max_age, double work) {
  FakeClock clock;
  const KinoraFormat test = format();
  FrameReader reader(test, "a.test", {});
  const auto device =
      std::make_shared<SimulatedDevice>(parse_device_faults(script, "script"), max_age, clock, [] { return false; });
  reader.replay(device);
  Replay out;
  while (const auto read = reader.next()) {
    out.frames.push_back(read->frame.index);
    out.ages.push_back(device->age(read->frame.time));
    out.dropped += read->dropped_before;
    clock.work(work);
  }
  return out;
}

double oldest(const Replay& replay) { return *std::max_element(replay.ages.begin(), replay.ages.end()); }

TEST(SimulatedDevice, GivesEveryFrameAtItsTimeToWhoKeepsUp) {
  const Replay out = replay("", 0.2, 0.09);
  EXPECT_EQ(out.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(out.dropped, 0U);
  EXPECT_LT(oldest(out), 1e-6);
}

TEST(SimulatedDevice, LosesAndCountsWhatIsNotTakenInTime) {
  const Replay out = replay("", 0.2, 0.25);
  EXPECT_NEAR(static_cast<double>(out.frames.size()), kFrames / 2.5, 2);
  EXPECT_EQ(out.frames.size() + out.dropped, static_cast<std::size_t>(out.frames.back()) + 1);
  EXPECT_LE(oldest(out), 0.2 + 1e-6);
}

TEST(SimulatedDevice, StallLosesAllButTheNewestFrames) {
  const Replay out = replay("stall 0.95 1.07", 0.25, 0.01); // frames 10 to 20 come at 2.02 s
  EXPECT_EQ(out.dropped, 8U);                               // 10 to 17
  EXPECT_EQ(out.frames[9], 9);
  EXPECT_EQ(out.frames[10], 18);
  EXPECT_EQ(out.frames.back(), kFrames - 1);
}

TEST(SimulatedDevice, DroppedFramesNeverCome) {
  const Replay out = replay("drop 0.95 0.3", 0.2, 0.01);
  EXPECT_EQ(out.dropped, 3U);
  EXPECT_EQ(out.frames[10], 13);
  EXPECT_EQ(out.frames.size(), static_cast<std::size_t>(kFrames) - 3);
}

TEST(SimulatedDevice, DisconnectEndsTheCapture) { EXPECT_EQ(replay("disconnect 1.95", 0.2, 0.01).frames.size(), 20U); }

TEST(SimulatedDevice, StopEndsTheWait) {
  FakeClock clock;
  SimulatedDevice device({}, 0.2, clock, [&] { return clock.now() > 1003; });
  EXPECT_EQ(device.wait_for(0), SimulatedDevice::Delivery::kThere);
  EXPECT_EQ(device.wait_for(1e6), SimulatedDevice::Delivery::kEnded);
  EXPECT_LT(clock.now(), 1004);
  EXPECT_FALSE(device.was_disconnected());
}

TEST(SimulatedDevice, ScriptMayHoldRemarksAndEmptyLines) {
  EXPECT_EQ(parse_device_faults("# all\n\n stall 1 2 # long\r\n\ndisconnect 5", "script").size(), 2U);
}

TEST(SimulatedDevice, RefusesScriptsAndNamesTheLine) {
  for (const char* line : {"explode 3", "stall 1", "stall 1 2 3", "drop -1 2", "disconnect", "stall x 2"}) {
    SCOPED_TRACE(line);
    try {
      parse_device_faults("stall 1 2\n" + std::string(line), "script");
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find("script, line 2"), std::string::npos) << error.what();
    }
  }
}

} // namespace
} // namespace kinora::host
