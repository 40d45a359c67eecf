#include "ingest/joints/joint_detector.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "formats/sample_capture.h"
#include "ingest/onnx/tiny_detector.h"

namespace kinora::ingest {
namespace {

using kinora::test::TemporaryFolder;
using kinora::test::onnx::joint_detector;

Eigen::Vector2i place_of(std::size_t joint) {
  return {180 + 12 * static_cast<int>(joint % 4), 105 + 20 * static_cast<int>(joint / 4)};
}

// Label 3 stands in the middle and has spots of seven pixels in its joints' colours, `hidden` has none.
Frame spotted_person(std::size_t hidden = kDetectedJoints) {
  Frame frame;
  frame.color = ColorImage(400, 300, 3, 128);
  frame.labels = LabelImage(400, 300);
  for (int v = 95; v < 205; ++v) {
    for (int u = 170; u < 230; ++u) frame.labels.at(u, v) = 3;
  }
  for (std::size_t i = 0; i < kDetectedJoints; ++i) {
    if (i == hidden) continue;
    for (int dv = -3; dv <= 3; ++dv) {
      for (int du = -3; du <= 3; ++du) {
        for (int c = 0; c < 3; ++c) {
          frame.color.at(place_of(i).x() + du, place_of(i).y() + dv, c) =
              test::onnx::joint_color(i)[static_cast<std::size_t>(c)];
        }
      }
    }
  }
  return frame;
}

std::unique_ptr<JointDetector> detector_of(const TemporaryFolder& folder, const std::string& network) {
  folder.write("net.onnx", network);
  return make_network_detector(folder.path() / "net.onnx");
}

TEST(JointDetector, FindsJointsWhereTheirHeatMapsAreLargest) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{96, 128}, std::pair{192, 256}, std::pair{128, 64}}) {
    const auto detector =
        detector_of(folder, joint_detector(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height)));
    const DetectedPerson person = detector->detect(spotted_person(), 3);
    EXPECT_EQ(person.label, 3);
    for (std::size_t i = 0; i < kDetectedJoints; ++i) {
      EXPECT_LT((person.joints[i].pixel - place_of(i).cast<double>()).norm(), 5) << width << ' ' << i;
      EXPECT_NEAR(person.joints[i].score, 0.9, 0.02) << width << ' ' << i;
    }
  }
}

TEST(JointDetector, AJointThatIsNotThereScoresLess) {
  const TemporaryFolder folder;
  const DetectedPerson person = detector_of(folder, joint_detector(96, 128))->detect(spotted_person(9), 3);
  for (std::size_t i = 0; i < kDetectedJoints; ++i) EXPECT_EQ(person.joints[i].score < 0.8, i == 9) << i;
}

TEST(JointDetector, NobodyHasNoJoints) {
  const TemporaryFolder folder;
  const auto detector = detector_of(folder, joint_detector(96, 128));
  Frame unlabelled = spotted_person();
  unlabelled.labels = {};
  for (const Frame& frame : {spotted_person(), unlabelled}) {
    for (const DetectedJoint& joint : detector->detect(frame, 1).joints) EXPECT_EQ(joint.score, 0);
  }
}

TEST(JointDetector, ThreadsDoNotMatter) {
  const TemporaryFolder folder;
  const auto detector = detector_of(folder, joint_detector(192, 256));
  const auto run = [&](int threads) {
    set_thread_count(threads);
    DetectedPerson person = detector->detect(spotted_person(), 3);
    set_thread_count(0);
    return person;
  };
  const DetectedPerson one = run(1);
  const DetectedPerson two = run(2);
  for (std::size_t i = 0; i < kDetectedJoints; ++i) {
    EXPECT_EQ(one.joints[i].pixel, two.joints[i].pixel);
    EXPECT_EQ(one.joints[i].score, two.joints[i].score);
  }
}

TEST(JointDetector, SaysWhatIsWrongWithTheNetwork) {
  const TemporaryFolder folder;
  folder.write("text.onnx", std::string("this is no network"));
  folder.write("cut.onnx", joint_detector(96, 128).substr(0, 200));
  folder.write("hands.onnx", joint_detector(96, 128, 21));
  folder.write("open.onnx", joint_detector(0, 0));
  folder.write("huge.onnx", joint_detector(100'000, 100'000));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"text.onnx", "is no ONNX network"}, {"cut.onnx", "is no ONNX network"}, {"missing.onnx", "is missing"},
      {"hands.onnx", "1 x 17 x h x w"},    {"open.onnx", "of a fixed size"},   {"huge.onnx", "of a fixed size"}};
  for (const auto& [name, why] : cases) {
    try {
      make_network_detector(folder.path() / name);
      ADD_FAILURE() << name << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find(name + ": "), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
}

} // namespace
} // namespace kinora::ingest
