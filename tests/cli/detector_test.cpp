// kinora encode --detector on somebody whose joints have colours that a network of one layer knows, and --body.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "core/image_codec.h"
#include "ingest/files/body_file.h"
#include "ingest/onnx/tiny_detector.h"
#include "tracking/body/joint_observations.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

// Spots of five pixels, before whatever they lie behind.
void paint_joints(const tracking::BodyState& state, ingest::Frame& frame) {
  const tracking::PosedBody body = tracking::pose_body(state.pose, state.shape);
  for (std::size_t i = 0; i < ingest::kDetectedJoints; ++i) {
    const Eigen::Vector2d pixel =
        frame.camera.intrinsics.project(tracking::position_of(tracking::landmark_of(i), body));
    for (int dv = -2; dv <= 2; ++dv) {
      for (int du = -2; du <= 2; ++du) {
        const int u = static_cast<int>(std::lround(pixel.x())) + du;
        const int v = static_cast<int>(std::lround(pixel.y())) + dv;
        if (!frame.color.contains(u, v)) continue;
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = onnx::joint_color(i)[static_cast<std::size_t>(c)];
      }
    }
  }
}

class Detector : public testing::Test {
protected:
  Detector() {
    tracking::testing::BodyScene scene;
    scene.width = 160;
    scene.height = 120;
    scene.focal = 133;
    capture_.write("intrinsics.json", std::string(R"({"width": 160, "height": 120, "fx": 133, "fy": 133, "cx": 80,
                                                      "cy": 60, "depth_factor": 1000, "fps": 30})"));
    for (int i = 0; i < 11; ++i) {
      tracking::BodyState state = tracking::testing::standing(5 * i);
      state.pose.root.translation().z() = 2.9; // the crop keeps within the picture
      scene.seed = static_cast<std::uint64_t>(i);
      ingest::Frame frame = tracking::testing::render_body(state, scene);
      paint_joints(state, frame);
      DepthImage16 depth(scene.width, scene.height);
      for (std::size_t p = 0; p < depth.values().size(); ++p) {
        depth.values()[p] = static_cast<std::uint16_t>(std::lround(1000 * frame.depth.values()[p]));
      }
      const std::string name = six_digits(i) + ".png";
      capture_.write("color/" + name, encode_png(frame.color));
      capture_.write("depth/" + name, encode_png16(depth));
      capture_.write("mask/" + name, encode_png(frame.labels));
    }
    folder_.write("pose.onnx", onnx::joint_detector(96, 128));
  }

  Said encode(std::vector<std::string> words) const {
    words.insert(words.begin(), {"encode", capture_.path().string()});
    words.insert(words.end(), {"--preset", "fast"});
    return run_kinora(folder_, words);
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder capture_;
  TemporaryFolder folder_;
};

Json person_in(const Json& report) {
  for (const Json& layer : report.at("layers")) {
    if (layer.at("name") == "person") return layer;
  }
  return {};
}

TEST_F(Detector, TellsThePersonsBodyOfItsJoints) {
  const Said said = encode({path("a.mkv"), "--detector", path("pose.onnx"), "--json", "--threads", "1"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json report = Json::parse(said.out);
  EXPECT_EQ(report.at("config").at("joints_from"), "network pose.onnx");
  const Json body = person_in(report).at("motion").at("body");
  EXPECT_EQ(body.at("verdict"), "person") << body;
  EXPECT_GT(body.at("detected_joints"), 14) << body;
  ASSERT_EQ(encode({path("b.mkv"), "--detector", path("pose.onnx"), "--threads", "2"}).code, 0);
  EXPECT_EQ(contents_of(path("a.mkv")), contents_of(path("b.mkv")));
}

TEST_F(Detector, NeedsNobody) {
  fs::remove_all(capture_.path() / "mask");
  for (int i = 0; i < 11; ++i) {
    capture_.write("mask/" + six_digits(i) + ".png", encode_png(ColorImage(160, 120, 1)));
  }
  const Said said = encode({path("a.mkv"), "--detector", path("pose.onnx")});
  EXPECT_EQ(said.code, 0) << said.err;
}

TEST_F(Detector, ABodyOfTheUsersChangesThePersonsMeasures) {
  ingest::testing::write_npz(path("body.npz"), ingest::testing::body_file());
  const auto thigh_of = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all{path("a.mkv"), "--overwrite"};
    all.insert(all.end(), words.begin(), words.end());
    EXPECT_EQ(encode(all).code, 0);
    for (const clip::Layer& layer : clip::read_clip(path("a.mkv")).layers) {
      if (!layer.joints) continue;
      const auto& last = layer.joints->positions.back();
      return (last[tracking::kLeftKnee] - last[tracking::kLeftHip]).norm();
    }
    return 0.0;
  };
  const double average = thigh_of({});
  const double told = thigh_of({"--body", path("body.npz")});
  EXPECT_GT(average, 0);
  EXPECT_GT(std::abs(told - average), 0.005) << told << " and " << average << " m";
}

TEST_F(Detector, ThatIsNoneIsRefusedBeforeAnyWork) {
  folder_.write("cut.onnx", onnx::joint_detector(96, 128).substr(0, 300));
  folder_.write("hands.onnx", onnx::joint_detector(96, 128, 21));
  for (const std::string name : {"cut.onnx", "hands.onnx"}) {
    const Said said = encode({path("a.mkv"), "--detector", path(name)});
    expect_error(said, 4, name);
    EXPECT_EQ(said.err.find("reading"), std::string::npos) << said.err;
  }
  EXPECT_FALSE(fs::exists(path("a.mkv")));
}

} // namespace
} // namespace kinora::test
