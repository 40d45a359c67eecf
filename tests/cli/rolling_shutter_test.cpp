// A camera that reads its pictures row by row while it moves, from the capture to what is drawn and compared.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "clip/readout.h"
#include "core/image_codec.h"
#include "core/metrics.h"
#include "core/velocity.h"
#include "end_to_end/box_capture.h"
#include "support/source_folder.h"
#include "tracking/scenes/room_scene.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

constexpr int kFrames = 60;
constexpr double kFrameTime = 1.0 / 30;
constexpr double kReadout = 0.02; // seconds

// A hand that carries the camera along and looks about, at a time in frames.
SE3 hand(double t) {
  return tracking::testing::pose_at(
      {0.25 * std::sin(0.25 * t), 0.1 * std::sin(0.4 * t), 0.15 * (1 - std::cos(0.2 * t))}, 4 * std::sin(0.3 * t),
      15 * std::sin(0.2 * t), 3 * std::sin(0.4 * t));
}

ColorImage read_color_picture(const fs::path& file) {
  const std::string bytes = contents_of(file);
  return decode_color(std::as_bytes(std::span(bytes)), file.string());
}

class RollingShutter : public testing::Test {
protected:
  RollingShutter() {
    capture_.write("intrinsics.json", R"({"width": 96, "height": 72, "fx": 90, "fy": 90, "cx": 47.5, "cy": 35.5,
                                          "depth_factor": 1000, "fps": 30})");
    for (int f = 0; f < kFrames; ++f) {
      tracking::testing::RoomOptions room;
      room.width = 96;
      room.height = 72;
      room.focal = 90;
      room.readout = kReadout * velocity_between(hand(f - 1), hand(f + 1), 2 * kFrameTime);
      const ingest::Frame frame = tracking::testing::render_room(hand(f), f, room);
      DepthImage16 depth(room.width, room.height);
      for (std::size_t i = 0; i < depth.values().size(); ++i) {
        depth.values()[i] = static_cast<std::uint16_t>(std::lround(1000 * frame.depth.values()[i]));
      }
      const std::string stem = "frame-" + six_digits(f);
      capture_.write(stem + ".color.png", encode_png(frame.color));
      capture_.write(stem + ".depth.png", encode_png16(depth));
      capture_.write(stem + ".pose.txt", matrix_text(hand(f)));
    }
  }

  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  Said run(const std::vector<std::string>& words) const { return run_kinora(folder_, words); }
  double compared(const std::string& clip) const {
    const Said said = run({"eval", path(clip), "--against", capture_.path(), "--json"});
    EXPECT_EQ(said.code, 0) << said.err;
    return Json::parse(said.out).at("picture").at("trained").at("psnr").get<double>();
  }
  ColorImage drawn(int frame, const std::string& shutter) const {
    const std::string picture = path(shutter + ".png");
    const Said said = run({"render", path("c.mkv"), picture, "--capture-view", "--shutter", shutter, "--frames",
                           std::to_string(frame), "--overwrite"});
    EXPECT_EQ(said.code, 0) << said.err;
    return read_color_picture(picture);
  }

  TemporaryFolder capture_;
  TemporaryFolder folder_;
};

TEST_F(RollingShutter, IsFoundAndPutBackWhereTheCapturesOwnPicturesAreMeant) {
  const Said said = run({"encode", capture_.path(), path("c.mkv"), "--preset", "fast", "--report", path("r.json")});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json report = Json::parse(contents_of(path("r.json")));
  EXPECT_NEAR(report.at("camera").at("refinement").at("rolling_shutter_s").get<double>(), kReadout, 0.003);
  clip::Clip clip = clip::read_clip(path("c.mkv"));
  EXPECT_NEAR(clip::stored_readout(clip.metadata).color, kReadout, 0.003);

  const int fast = 31; // the camera turns at 90 degrees a second
  const ColorImage recorded = read_color_picture(capture_.path() / ("frame-" + six_digits(fast) + ".color.png"));
  const auto likeness = [&](const char* shutter) { return compare_images(drawn(fast, shutter), recorded).psnr_full; };
  EXPECT_GT(likeness("capture"), likeness("global") + 2);

  clip.metadata.erase("rolling_shutter");
  clip::write_clip(clip, path("unaware.mkv"));
  EXPECT_GT(compared("c.mkv"), compared("unaware.mkv") + 1);

  expect_error(run({"render", path("c.mkv"), path("o.png"), "--orbit", "10", "--shutter", "capture"}), 2, "--shutter");
}

} // namespace
} // namespace kinora::test
