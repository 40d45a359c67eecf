#include "clip/payloads/deformation_codec.h"

#include <gtest/gtest.h>

#include "clip/payloads/graph_codec.h"
#include "clip/sample_clip.h"
#include "clip/sample_motion.h"
#include "core/error.h"

namespace kinora::clip {
namespace {

using motion::DeformationGraph;
using motion::Motion;
using testing::walker;
using testing::WalkerOptions;

struct Stored {
  Bytes graph;
  std::vector<DeformationEncoder::Coded> payloads;
};

Stored store(const Motion& motion) {
  Stored stored{encode_graph(*motion.graph()), {}};
  DeformationEncoder encoder(*motion.graph());
  for (const Motion::Deformation& deformation : motion.deformations()) {
    stored.payloads.push_back(encoder.encode(deformation));
  }
  return stored;
}

Motion load(const Stored& stored) {
  auto graph = decode_graph(stored.graph, "a.mkv");
  DeformationDecoder decoder(*graph);
  std::vector<Motion::Deformation> deformations;
  for (const auto& [key, bytes] : stored.payloads) deformations.push_back(decoder.decode(bytes, key, "a.mkv"));
  return Motion::deforming(std::move(graph), std::move(deformations));
}

std::size_t bytes_of(const Stored& stored) {
  std::size_t sum = 0;
  for (const auto& payload : stored.payloads) sum += payload.bytes.size();
  return sum;
}

/// Nodes anywhere, turned anyhow: nothing that a prediction could use.
Motion scattered(std::uint64_t seed, std::size_t nodes, std::size_t frames) {
  Random random(seed);
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < nodes; ++i) positions.emplace_back(testing::random_pose(random).translation());
  if (nodes > 2) positions[2] = positions[0]; // two in one place
  std::vector<Motion::Deformation> deformations(frames);
  for (Motion::Deformation& deformation : deformations) {
    for (std::size_t i = 0; i < nodes; ++i) {
      deformation.node_to_world.push_back(DualQuaternion::from(testing::random_pose(random)));
    }
  }
  auto graph = std::make_shared<const DeformationGraph>(std::move(positions), 0.05, 0.1);
  return Motion::deforming(std::move(graph), std::move(deformations));
}

/// Quarter, third and half turns: components of the quaternion are of one size, or zero.
Motion turned_evenly() {
  std::vector<Eigen::Vector3d> positions;
  Motion::Deformation deformation;
  const double pi = std::numbers::pi;
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 1, 1),
        Eigen::Vector3d(-1, 1, 1), Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(-1, 1, 1e-9)}) {
    for (const double angle : {0.0, pi, -pi, pi / 2, 2 * pi / 3, -pi / 3, pi - 1e-9, 1e-9, 2 * pi}) {
      positions.emplace_back(0.1 * axis + Eigen::Vector3d(0, 0, 0.01 * static_cast<double>(positions.size())));
      SE3 transform = SE3::Identity();
      transform.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
      deformation.node_to_world.push_back(DualQuaternion::from(transform));
    }
  }
  auto graph = std::make_shared<const DeformationGraph>(std::move(positions), 0.05, 0.1);
  return Motion::deforming(std::move(graph), {deformation, deformation});
}

std::vector<Motion> hard_motions() {
  std::vector<Motion> motions{scattered(1, 1, 3), scattered(2, 2, 3), scattered(3, 40, 65), turned_evenly()};
  WalkerOptions options;
  options.frames = 40;
  options.nodes = 120;
  motions.push_back(walker(options));
  return motions;
}

/// A point at a node or, along one axis, at a weight radius from it.
Eigen::Vector3d point_about(const DeformationGraph& graph, std::size_t node, int direction) {
  const Eigen::Vector3d& position = graph.nodes()[node];
  if (direction == 6) return position;
  return position + (direction % 2 == 0 ? 1 : -1) * graph.weight_radius() * Eigen::Vector3d::Unit(direction / 2);
}

TEST(DeformationCodec, KeepsNodesToHalfAMillimetreAndSevenMilliradians) {
  for (const Motion& motion : hard_motions()) {
    const Motion back = load(store(motion));
    ASSERT_EQ(back.deformations().size(), motion.deformations().size());
    for (std::size_t f = 0; f < motion.deformations().size(); ++f) {
      EXPECT_EQ(back.health(f), motion.health(f));
      for (std::size_t i = 0; i < motion.graph()->nodes().size(); ++i) {
        const SE3 a = motion.deformations()[f].node_to_world[i].to_se3();
        const SE3 b = back.deformations()[f].node_to_world[i].to_se3();
        const Eigen::Vector3d error = b * back.graph()->nodes()[i] - a * motion.graph()->nodes()[i];
        EXPECT_LE(error.norm(), kLargestMotionError);
        EXPECT_LE(rotation_angle(a.inverse() * b), 7e-3);
      }
    }
  }
}

TEST(DeformationCodec, KeepsPointsAboutNodesToHalfAMillimetre) {
  WalkerOptions options;
  options.frames = 40;
  const Motion motion = walker(options);
  const Motion back = load(store(motion));
  for (std::size_t f = 0; f < motion.deformations().size(); ++f) {
    const motion::Warp a = motion.warp(static_cast<double>(f));
    const motion::Warp b = back.warp(static_cast<double>(f));
    for (std::size_t i = 0; i < motion.graph()->nodes().size(); ++i) {
      for (int direction = 0; direction < 7; ++direction) {
        const Eigen::Vector3d point = point_about(*motion.graph(), i, direction);
        const motion::Influence influence = motion.graph()->influence(point);
        if (influence.count == 0) continue;
        EXPECT_LE((a.at(influence) * point - b.at(influence) * point).norm(), kLargestMotionError + 2e-6);
      }
    }
  }
}

TEST(DeformationCodec, EncodesWhatItDecodedToTheSameBytes) {
  for (const Motion& motion : hard_motions()) {
    const Stored once = store(motion);
    const Stored again = store(load(once));
    EXPECT_EQ(again.graph, once.graph);
    ASSERT_EQ(again.payloads.size(), once.payloads.size());
    for (std::size_t f = 0; f < once.payloads.size(); ++f) {
      EXPECT_EQ(again.payloads[f].key, once.payloads[f].key);
      EXPECT_EQ(again.payloads[f].bytes, once.payloads[f].bytes) << "frame " << f;
    }
  }
}

TEST(DeformationCodec, GivesUnitDualQuaternions) {
  for (const Motion& motion : hard_motions()) {
    const Motion back = load(store(motion));
    for (const Motion::Deformation& deformation : back.deformations()) {
      for (const DualQuaternion& q : deformation.node_to_world) {
        EXPECT_NEAR(q.real.norm(), 1, 1e-12);
        EXPECT_NEAR(q.real.coeffs().dot(q.dual.coeffs()), 0, 1e-12);
      }
    }
  }
}

TEST(DeformationCodec, TakesLittleRoomForAWalker) {
  WalkerOptions options; // 450 nodes
  const Motion motion = walker(options);
  const Stored stored = store(motion);
  EXPECT_LT(bytes_of(stored) / options.frames, 900U);
  const Motion back = load(stored);
  Random random(3);
  double sum = 0;
  int count = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d point = testing::walker_point(static_cast<std::size_t>(i) % 5, random);
    const auto frame = static_cast<double>(random.below(90));
    const auto wanted = motion.warp(frame).to_world(point);
    const auto got = back.warp(frame).to_world(point);
    if (!wanted || !got) continue;
    EXPECT_LT((*got - *wanted).norm(), 0.6e-3);
    sum += (*got - *wanted).norm();
    ++count;
  }
  EXPECT_GT(count, 1900);
  EXPECT_LT(sum / count, 0.2e-3);
}

TEST(DeformationCodec, TakesHardlyAnyRoomWhenALayerIsHeld) {
  WalkerOptions options;
  options.frames = 20;
  const Motion motion = walker(options);
  const Motion held = Motion::deforming(motion.graph(), std::vector(60, motion.deformations().back()));
  const Stored stored = store(held);
  EXPECT_LT(stored.payloads[29].bytes.size(), 40U);
  EXPECT_EQ(stored.payloads[30].bytes, stored.payloads[0].bytes) << "a key payload depends on earlier ones";
}

TEST(DeformationCodec, CanBeReadFromEveryKeyPayloadOn) {
  WalkerOptions options;
  options.frames = 2 * kKeyInterval + 5;
  options.nodes = 60;
  const Stored stored = store(walker(options));
  const Motion all = load(stored);
  const auto graph = decode_graph(stored.graph, "a.mkv");
  DeformationDecoder decoder(*graph);
  EXPECT_THROW(decoder.decode(stored.payloads[kKeyInterval - 1].bytes, false, "a.mkv"), Error);
  for (std::size_t f = kKeyInterval; f < stored.payloads.size(); ++f) {
    const Motion::Deformation d = decoder.decode(stored.payloads[f].bytes, stored.payloads[f].key, "a.mkv");
    for (std::size_t i = 0; i < d.node_to_world.size(); ++i) {
      EXPECT_EQ(d.node_to_world[i].real.coeffs(), all.deformations()[f].node_to_world[i].real.coeffs());
      EXPECT_EQ(d.node_to_world[i].dual.coeffs(), all.deformations()[f].node_to_world[i].dual.coeffs());
    }
  }
}

TEST(DeformationCodec, RejectsPayloadsThatAreNotWhole) {
  const Stored stored = store(scattered(5, 12, 1));
  const auto graph = decode_graph(stored.graph, "a.mkv");
  const Bytes& good = stored.payloads[0].bytes;
  const auto expect_corrupt = [&](const Bytes& bad) {
    DeformationDecoder decoder(*graph);
    try {
      decoder.decode(bad, true, "a.mkv: byte 7");
      ADD_FAILURE() << "decoded";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_EQ(std::string(error.what()).rfind("a.mkv: byte 7", 0), 0U) << error.what();
    }
  };
  for (std::size_t size = 0; size + 5 < good.size(); ++size) {
    // Of the last bytes a code may lack some and still say all of it.
    expect_corrupt(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  Bytes longer = good;
  longer.resize(good.size() + 8);
  expect_corrupt(longer);
  Bytes other = good;
  other[0] = std::byte{3}; // version
  expect_corrupt(other);
  other = good;
  other[1] = std::byte{3}; // health
  expect_corrupt(other);
}

TEST(DeformationCodec, RefusesToStoreWhatIsNotRigidOrNotFinite) {
  const Motion motion = scattered(7, 5, 1);
  const auto expect_refused = [&motion](const DualQuaternion& bad) {
    Motion::Deformation deformation = motion.deformations()[0];
    deformation.node_to_world[3] = bad;
    DeformationEncoder encoder(*motion.graph());
    EXPECT_THROW(encoder.encode(deformation), Error);
  };
  DualQuaternion bad;
  bad.real.w() = 2;
  expect_refused(bad);
  bad.real.w() = std::nan("");
  expect_refused(bad);
  bad = {};
  bad.dual.x() = std::nan("");
  expect_refused(bad);
  bad.dual.x() = 1e9;
  expect_refused(bad);
}

} // namespace
} // namespace kinora::clip
