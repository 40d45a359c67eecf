// Each decoder of a clip's payloads by itself, with payloads of the conformance corpus as seeds.
#include "clip/codec_ids.h"
#include "clip/payloads/births_codec.h"
#include "clip/payloads/confidence_codec.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/payloads/pose_codec.h"
#include "clip/payloads/update_codec.h"
#include "clip/sample_clip.h"
#include "clip/sample_motion.h"
#include "container/little_endian.h"
#include "container/reader.h"
#include "core/error.h"
#include "fuzz/fuzzer.h"

namespace kinora::fuzz {
namespace {

namespace fs = std::filesystem;
using Span = std::span<const std::byte>;

const std::string kWhere = "payload";

/// A payload is refused in one way.
template <class Call> void expect_refusal_or_success(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    require(error.code() == ErrorCode::kCorruptInput, error.what());
    throw;
  }
}

/// Two payloads as one input: both, then the size of the first.
Bytes joined(Span first, Span second) {
  Bytes input(first.begin(), first.end());
  input.insert(input.end(), second.begin(), second.end());
  container::put(input, static_cast<std::uint16_t>(first.size()));
  return input;
}

std::pair<Span, Span> parted(Span input) {
  if (input.size() < 2) return {};
  const Span both = input.first(input.size() - 2);
  const std::size_t size = std::min<std::size_t>(container::get<std::uint16_t>(input, both.size()), both.size());
  return {both.first(size), both.subspan(size)};
}

struct Track {
  std::string codec;
  Bytes private_data;
  std::vector<Bytes> payloads;
};

/// Of the corpus.
std::vector<Track> tracks_of(std::string_view codec) {
  std::vector<Track> found;
  for (const fs::directory_entry& file : fs::directory_iterator(KINORA_CONFORMANCE_CORPUS)) {
    if (file.path().extension() != ".mkv") continue;
    container::Reader reader(file.path());
    std::map<std::uint16_t, Track> tracks;
    for (const container::StoredTrack& stored : reader.tracks())
      tracks[stored.track.id] = {stored.track.codec, stored.track.private_data, {}};
    container::Payload payload;
    while (reader.next(payload)) tracks[payload.track].payloads.push_back(payload.bytes);
    for (auto& [id, track] : tracks)
      if (track.codec == codec) found.push_back(std::move(track));
  }
  return found;
}

// ---- motion

std::vector<Bytes> poses() {
  std::vector<Bytes> seeds;
  for (const std::string_view codec : {clip::kCameraCodec, clip::kMotionCodec}) {
    for (const Track& track : tracks_of(codec))
      if (track.private_data.empty()) seeds.insert(seeds.end(), track.payloads.begin(), track.payloads.end());
  }
  return seeds;
}
void read_pose(Span input) {
  expect_refusal_or_success([&] {
    const motion::Motion::Pose pose = clip::decode_pose(input, kWhere);
    require(pose.canonical_to_world.matrix().allFinite(), "a pose is finite");
    const Bytes again = clip::encode_pose(pose);
    require(clip::encode_pose(clip::decode_pose(again, kWhere)) == again, "a pose stays as it was read");
  });
}

std::vector<Bytes> graphs() {
  std::vector<Bytes> seeds;
  for (const Track& track : tracks_of(clip::kMotionCodec))
    if (!track.private_data.empty()) seeds.push_back(track.private_data);
  return seeds;
}
void read_graph(Span input) {
  expect_refusal_or_success([&] {
    const auto graph = clip::decode_graph(input, kWhere);
    constexpr std::size_t kQuick = 2000; // nodes: writing looks at each pair of them
    if (graph->nodes().size() > kQuick) return;
    const Bytes again = clip::encode_graph(*graph);
    require(clip::encode_graph(*clip::decode_graph(again, kWhere)) == again, "a graph stays as it was read");
  });
}

const motion::Motion& walker() {
  static const motion::Motion motion = [] {
    clip::testing::WalkerOptions options;
    options.nodes = 40;
    options.frames = 6;
    return clip::testing::walker(options);
  }();
  return motion;
}
std::vector<Bytes> deformations() {
  std::vector<Bytes> seeds;
  for (std::size_t f = 0; f + 1 < walker().deformations().size(); ++f) {
    clip::DeformationEncoder encoder(*walker().graph());
    const Bytes key = encoder.encode(walker().deformations()[f]).bytes;
    seeds.push_back(joined(key, encoder.encode(walker().deformations()[f + 1]).bytes));
  }
  return seeds;
}
void read_deformations(Span input) {
  expect_refusal_or_success([&] {
    clip::DeformationDecoder decoder(*walker().graph());
    const auto [key, other] = parted(input);
    for (const auto& deformation : {decoder.decode(key, true, kWhere), decoder.decode(other, false, kWhere)}) {
      for (const DualQuaternion& node : deformation.node_to_world)
        require(std::abs(node.real.norm() - 1) < 1e-9 && node.dual.coeffs().allFinite(), "a node moves rigidly");
    }
  });
}

// ---- fields

std::vector<Bytes> fields() {
  std::vector<Bytes> seeds;
  for (const Track& track : tracks_of(clip::kFieldCodec))
    seeds.push_back(joined(track.payloads[0], track.payloads.size() > 1 ? track.payloads[1] : Bytes()));
  return seeds;
}
void read_field(Span input) {
  expect_refusal_or_success([&] {
    clip::AllocationBudget budget(0);
    clip::FieldDecoder decoder;
    const auto [first, level] = parted(input);
    decoder.take(first, kWhere, budget);
    if (!level.empty()) decoder.take(level, kWhere, budget);
  });
}

std::vector<Bytes> field_differences() {
  std::vector<Bytes> seeds;
  for (const std::uint64_t seed : {3, 5, 7})
    seeds.push_back(clip::encode_field_difference(clip::testing::random_field(seed), clip::testing::random_field(1)));
  return seeds;
}
void read_field_difference(Span input) {
  static const fields::Field base = clip::testing::random_field(1);
  expect_refusal_or_success([&] {
    clip::AllocationBudget budget(0);
    clip::decode_field_difference(input, base, kWhere, budget);
  });
}

std::vector<Bytes> confidences() {
  const fields::Field field = clip::testing::random_field(1);
  std::vector<Bytes> seeds;
  for (std::uint64_t seed = 1; seed < 5; ++seed)
    seeds.push_back(clip::encode_confidence(clip::testing::random_confidence(field.occupancy, seed)));
  return seeds;
}
void read_confidence(Span input) {
  static const fields::Field field = clip::testing::random_field(1);
  expect_refusal_or_success([&] {
    clip::AllocationBudget budget(0);
    clip::decode_confidence(input, field.occupancy, kWhere, budget);
  });
}

// ---- the rest

constexpr std::size_t kFrames = 6;
std::vector<Bytes> joints() {
  std::vector<Bytes> seeds;
  for (std::uint64_t seed = 1; seed < 5; ++seed)
    seeds.push_back(clip::encode_joints(clip::testing::random_joints(seed, kFrames)));
  return seeds;
}
void read_joints(Span input) {
  expect_refusal_or_success([&] {
    clip::AllocationBudget budget(0);
    clip::decode_joints(input, kFrames, kWhere, budget);
  });
}

std::vector<Bytes> births() {
  std::vector<Bytes> seeds;
  for (std::uint32_t first = 0; first < 4; ++first) {
    std::vector<std::uint32_t> frames;
    for (std::uint32_t n = 0; n < walker().graph()->nodes().size(); ++n) frames.push_back((first + n / 8) % kFrames);
    seeds.push_back(clip::encode_births(motion::NodeBirths(std::move(frames)), *walker().graph()));
  }
  return seeds;
}

void read_births(Span input) {
  expect_refusal_or_success([&] {
    clip::AllocationBudget budget(0);
    const auto read = clip::decode_births(input, *walker().graph(), kFrames, kWhere, budget);
    for (const std::uint32_t frame : read.frames()) require(frame <= kFrames, "a node is born in the clip, or not");
  });
}

std::vector<Bytes> updates() {
  std::vector<Bytes> seeds;
  Bytes frames;
  for (const Bytes& pose : poses()) {
    clip::append_frame(frames, {true, pose});
    const Bytes other = bytes_of("{}");
    seeds.push_back(clip::encode_update(
        {static_cast<std::uint32_t>(seeds.size()),
         {{clip::UpdatePart::kDescription, 0, 0, other}, {clip::UpdatePart::kMotion, 3, 0, frames}}}));
    if (seeds.size() == 4) break;
  }
  return seeds;
}
void read_update(Span input) {
  expect_refusal_or_success([&] {
    for (const clip::PartView& part : clip::decode_update(input, kWhere).parts) {
      if (part.what == clip::UpdatePart::kMotion) clip::frames_of(part.bytes, kWhere);
    }
  });
}

} // namespace

std::vector<Fuzzer> payload_fuzzers() {
  return {{"pose_payload", poses, read_pose, 4000},
          {"graph_payload", graphs, read_graph, 1000},
          {"deformation_payload", deformations, read_deformations, 1500},
          {"field_payload", fields, read_field, 150},
          {"field_difference_payload", field_differences, read_field_difference, 150},
          {"confidence_payload", confidences, read_confidence, 1000},
          {"joints_payload", joints, read_joints, 1500},
          {"births_payload", births, read_births, 1500},
          {"update_payload", updates, read_update, 3000}};
}

} // namespace kinora::fuzz
