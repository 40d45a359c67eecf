// Mutated payloads and attachments under checksums that are right: what a hostile writer would make.
#include <array>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "clip/live_clip_writer.h"
#include "clip/payloads/confidence_codec.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/payloads/pose_codec.h"
#include "clip/sample_clip.h"
#include "container/ebml_builder.h"
#include "container/writer.h"
#include "core/error.h"
#include "fuzz/mutate.h"

namespace kinora::encode {
namespace {

using container::testing::TemporaryFolder;

// Same tracks, attachments and payloads as `path`, with damage in some of them.
void write_mutated(const std::filesystem::path& path, const std::filesystem::path& to, Random& random) {
  container::Reader reader(path);
  container::FileHead head;
  head.kind = reader.tag(container::kKindTag).value();
  for (const container::StoredTrack& stored : reader.tracks()) {
    head.tracks.push_back(stored.track);
    clip::Bytes& graph = head.tracks.back().private_data;
    if (!graph.empty() && random.below(4) == 0) graph = fuzz::mutate(std::move(graph), random);
  }
  for (const container::StoredAttachment& stored : reader.attachments()) {
    clip::Bytes bytes = reader.read_attachment(stored);
    if (random.below(4) == 0) bytes = fuzz::mutate(std::move(bytes), random);
    head.attachments.push_back({stored.name, stored.media_type, stored.description, std::move(bytes)});
  }
  container::Writer writer(to, head);
  container::Payload payload;
  while (reader.next(payload)) {
    if (random.below(6) == 0) payload.bytes = fuzz::mutate(std::move(payload.bytes), random);
    if (random.below(30) == 0) continue;
    writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
    if (random.below(30) == 0) writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
  }
  writer.finish();
}

TEST(ClipFuzz, ReaderRefusesOrReadsClipsOfHostileWriters) {
  const TemporaryFolder folder;
  clip::write_clip(clip::testing::bending_clip(1, 4, true), folder / "a.mkv");
  for (std::uint64_t i = 0; i < 300; ++i) {
    Random random(7, i);
    write_mutated(folder / "a.mkv", folder / "b.mkv", random);
    try {
      clip::read_clip(folder / "b.mkv");
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << i << ": " << error.what();
    }
  }
}

TEST(ClipFuzz, ReaderRefusesOrReadsLiveClipsOfHostileWriters) {
  const TemporaryFolder folder;
  clip::Clip clip = clip::testing::bending_clip(2, 5, true);
  {
    clip::LiveClipWriter writer(folder / "a.mkv", clip.intrinsics);
    for (int update = 0; update < 5; ++update) {
      clip.layers.front().field.table[7] += 0.2F;
      writer.write(clip);
    }
  }
  for (std::uint64_t i = 0; i < 300; ++i) {
    Random random(17, i);
    write_mutated(folder / "a.mkv", folder / "b.mkv", random);
    try {
      clip::read_clip(folder / "b.mkv");
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << i << ": " << error.what();
    }
  }
}

TEST(ClipFuzz, FieldDecoderRefusesOrDecodesMutatedPayloads) {
  const std::array payloads{clip::encode_field(clip::testing::random_field(2)),
                            clip::encode_field(clip::testing::random_field(3))};
  for (std::uint64_t i = 0; i < 2000; ++i) {
    Random random(8, i);
    const clip::Bytes& payload = payloads[i % 2];
    clip::Bytes mutated = payload;
    // Most damage goes to the header, where the numbers are that decide about memory.
    clip::Bytes header(mutated.begin(), mutated.begin() + 72);
    header = fuzz::mutate(std::move(header), random);
    header.resize(72);
    std::copy(header.begin(), header.end(), mutated.begin());
    if (i % 3 == 0) mutated = fuzz::mutate(payload, random);
    clip::AllocationBudget budget(mutated.size());
    try {
      clip::decode_field(mutated, "mutated", budget);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << i << ": " << error.what();
    }
  }
}

TEST(ClipFuzz, ConfidenceDecoderRefusesOrDecodesMutatedPayloads) {
  const fields::Occupancy occupancy = clip::testing::random_field(2).occupancy;
  const clip::Bytes payload = clip::encode_confidence(clip::testing::random_confidence(occupancy, 2));
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(12, i);
    const clip::Bytes mutated = fuzz::mutate(payload, random);
    clip::AllocationBudget budget(mutated.size());
    try {
      const fields::Confidence confidence = clip::decode_confidence(mutated, occupancy, "mutated", budget);
      for (const auto& levels : confidence.levels()) {
        for (const std::uint8_t level : levels) ASSERT_LE(level, fields::Confidence::kMax);
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << i << ": " << error.what();
    }
  }
}

TEST(ClipFuzz, JointsDecoderRefusesOrDecodesMutatedPayloads) {
  const clip::Bytes payload = clip::encode_joints(clip::testing::random_joints(2, 10));
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(14, i);
    const clip::Bytes mutated = fuzz::mutate(payload, random);
    clip::AllocationBudget budget(mutated.size());
    try {
      const motion::JointPaths joints = clip::decode_joints(mutated, 10, "mutated", budget);
      ASSERT_EQ(joints.positions.size(), 10U);
      for (const auto& positions : joints.positions) ASSERT_EQ(positions.size(), joints.names.size());
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << i << ": " << error.what();
    }
  }
}

TEST(ClipFuzz, PoseDecoderRefusesOrDecodesMutatedPayloads) {
  Random poses(9);
  for (std::uint64_t i = 0; i < 5000; ++i) {
    Random random(10, i);
    const clip::Bytes payload = clip::encode_pose({clip::testing::random_pose(poses), motion::Health::kTracked});
    try {
      const SE3 pose = clip::decode_pose(fuzz::mutate(payload, random), "mutated").canonical_to_world;
      EXPECT_TRUE(pose.matrix().allFinite());
      EXPECT_NEAR(pose.linear().determinant(), 1, 1e-12);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << i << ": " << error.what();
    }
  }
}

TEST(ClipFuzz, DeformationDecoderRefusesOrDecodesMutatedPayloads) {
  clip::testing::WalkerOptions options;
  options.nodes = 40;
  options.frames = 3;
  const motion::Motion motion = clip::testing::walker(options);
  clip::DeformationEncoder encoder(*motion.graph());
  std::vector<clip::Bytes> payloads;
  for (const auto& deformation : motion.deformations()) payloads.push_back(encoder.encode(deformation).bytes);
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(11, i);
    try {
      const clip::Bytes graph_bytes = clip::encode_graph(*motion.graph());
      const auto graph = clip::decode_graph(i % 4 == 0 ? fuzz::mutate(graph_bytes, random) : graph_bytes, "mutated");
      clip::DeformationDecoder decoder(*graph);
      for (const clip::Bytes& payload : payloads) {
        const bool key = &payload == payloads.data();
        const auto deformation = decoder.decode(fuzz::mutate(payload, random), key, "mutated");
        for (const DualQuaternion& q : deformation.node_to_world) {
          EXPECT_NEAR(q.real.norm(), 1, 1e-12);
          EXPECT_TRUE(q.dual.coeffs().allFinite());
        }
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << i << ": " << error.what();
    }
  }
}

} // namespace
} // namespace kinora::encode
