#include "clip/payloads/births_codec.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace kinora::clip {
namespace {

constexpr std::size_t kFrames = 300;

motion::DeformationGraph graph_of(std::size_t nodes, Random& random) {
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < nodes; ++i)
    positions.emplace_back(random.uniform_double(), random.uniform_double(), random.uniform_double());
  return {positions, 0.1, 0.2};
}

TEST(BirthsCodec, GivesBackWhateverBirths) {
  Random random(1);
  AllocationBudget budget(1 << 20);
  for (int round = 0; round < 50; ++round) {
    const motion::DeformationGraph graph = graph_of(1 + random.below(60), random);
    std::vector<std::uint32_t> frames(graph.nodes().size());
    for (std::uint32_t& frame : frames) frame = random.below(4) == 0 ? random.below(kFrames + 1) : 0;
    const motion::NodeBirths births(frames);
    const Bytes coded = encode_births(births, graph);
    EXPECT_EQ(decode_births(coded, graph, kFrames, "here", budget), births);
  }
}

TEST(BirthsCodec, PartsThatAreBornTogetherCostLittle) {
  Random random(2);
  const motion::DeformationGraph graph = graph_of(400, random);
  std::vector<std::uint32_t> frames;
  for (const Eigen::Vector3d& node : graph.nodes()) frames.push_back(node.x() > 0.7 ? 120 : 0);
  EXPECT_LT(encode_births(motion::NodeBirths(frames), graph).size(), 60U);
}

TEST(BirthsCodec, RefusesWhatIsNotThere) {
  Random random(3);
  AllocationBudget budget(1 << 20);
  const motion::DeformationGraph graph = graph_of(20, random);
  std::vector<std::uint32_t> frames(20, 7);
  const Bytes coded = encode_births(motion::NodeBirths(frames), graph);
  const auto refuses = [&](const Bytes& bytes, std::size_t count) {
    try {
      (void)decode_births(bytes, graph, count, "here", budget);
      return false;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_EQ(std::string(error.what()).rfind("here", 0), 0U) << error.what();
      return true;
    }
  };
  EXPECT_FALSE(refuses(coded, 7));
  EXPECT_TRUE(refuses(coded, 6)) << "born behind the end";
  EXPECT_TRUE(refuses({}, 7));
  Bytes changed = coded;
  changed[0] = std::byte{9};
  EXPECT_TRUE(refuses(changed, 7)) << "of another version";
  changed = coded;
  changed.resize(changed.size() + 8);
  EXPECT_TRUE(refuses(changed, 7)) << "something is left";
  EXPECT_THROW((void)encode_births(motion::NodeBirths({1, 2}), graph), Error);
}

TEST(BirthsCodec, SurvivesRandomBytes) {
  Random random(4);
  const motion::DeformationGraph graph = graph_of(20, random);
  for (int round = 0; round < 2000; ++round) {
    AllocationBudget budget(1 << 20);
    Bytes bytes(1 + random.below(20));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.below(256));
    bytes[0] = std::byte{1};
    try {
      const motion::NodeBirths births = decode_births(bytes, graph, kFrames, "here", budget);
      for (const std::uint32_t frame : births.frames()) EXPECT_LE(frame, kFrames);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    }
  }
}

} // namespace
} // namespace kinora::clip
