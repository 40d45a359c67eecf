// Kinora's file: the container as bytes, and clips whose payloads and attachments are spoilt under checksums that are
// right, as a hostile writer would make them.
#include "clip/clip_io.h"
#include "clip/sample_clip.h"
#include "container/ebml_builder.h"
#include "container/sample_file.h"
#include "container/writer.h"
#include "core/error.h"
#include "fuzz/fuzzer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"

namespace kinora::fuzz {
namespace {

using container::testing::load;

/// A file is refused in one of two ways.
template <class Call> void expect_refusal_or_success(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    require(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised, error.what());
    throw;
  }
}

std::vector<Bytes> container_seeds() {
  using namespace container::testing;
  const container::testing::TemporaryFolder folder;
  std::vector<Bytes> seeds;
  for (std::uint64_t seed = 31; seed < 35; ++seed) {
    write_sample(sample_file(seed, 12, 200), folder / "a.mkv");
    seeds.push_back(load(folder / "a.mkv"));
  }
  const Bytes frame = container::wrap_payload(7, 5, true, container::testing::bytes_of("hello"));
  const Bytes cluster = unknown_size(container::ids::kCluster, simple_block(1, frame));
  seeds.push_back(ebml_head() + unknown_size(container::ids::kSegment,
                                             element(container::ids::kTracks, track_entry(1, 7)) + cluster + cluster));
  return seeds;
}

void read_container(std::span<const std::byte> input) {
  const Bytes file(input.begin(), input.end()); // the reader looks into it
  expect_refusal_or_success([&] {
    container::Reader reader = container::testing::open(file);
    for (const container::StoredAttachment& attachment : reader.attachments()) reader.read_attachment(attachment);
    container::testing::read_all(reader);
  });
}

/// How a clip is to be spoilt: steps of 8 bytes, each for one part of the file (a track's private data, an attachment,
/// a payload) in their order.
class Damage {
public:
  explicit Damage(std::span<const std::byte> script) : script_(script) {}

  /// Nothing: the part is left out.
  std::optional<Bytes> of_next_part(Bytes bytes) {
    const std::uint8_t part = part_++;
    for (std::size_t i = 0; i + 8 <= script_.size(); i += 8) {
      const auto step = script_.subspan(i, 8);
      if (std::to_integer<std::uint8_t>(step[0]) != part) continue;
      if (std::to_integer<int>(step[1]) % 6 == 5) return std::nullopt;
      change(bytes, step);
    }
    return bytes;
  }

private:
  static void change(Bytes& bytes, std::span<const std::byte> step) {
    const std::size_t place = std::to_integer<std::size_t>(step[2]) + 256 * std::to_integer<std::size_t>(step[3]);
    const std::size_t at = bytes.empty() ? 0 : place % bytes.size();
    const auto here = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t left = bytes.size() - at;
    switch (std::to_integer<int>(step[1]) % 6) {
    case 0:
      std::copy_n(step.begin() + 4, std::min<std::size_t>(left, 1), here);
      break;
    case 1:
      std::copy_n(step.begin() + 4, std::min<std::size_t>(left, 4), here);
      break;
    case 2:
      bytes.insert(here, step.begin() + 4, step.end());
      break;
    case 3:
      bytes.erase(here, here + static_cast<std::ptrdiff_t>(std::min(left, std::to_integer<std::size_t>(step[4]))));
      break;
    default:
      bytes.resize(at);
    }
  }

  std::span<const std::byte> script_;
  std::uint8_t part_ = 0;
};

void write_damaged(const std::filesystem::path& path, const std::filesystem::path& to, Damage damage) {
  container::Reader reader(path);
  container::FileHead head;
  head.kind = "clip";
  for (const container::StoredTrack& stored : reader.tracks()) {
    head.tracks.push_back(stored.track);
    Bytes& graph = head.tracks.back().private_data;
    graph = damage.of_next_part(std::move(graph)).value_or(Bytes());
  }
  for (const container::StoredAttachment& stored : reader.attachments())
    if (auto bytes = damage.of_next_part(reader.read_attachment(stored)))
      head.attachments.push_back({stored.name, stored.media_type, stored.description, std::move(*bytes)});
  container::Writer writer(to, head);
  container::Payload payload;
  while (reader.next(payload))
    if (const auto bytes = damage.of_next_part(std::move(payload.bytes)))
      writer.write(payload.track, payload.time_ns, payload.key, *bytes);
  writer.finish();
}

/// That cut nothing out, of one part after the other.
std::vector<Bytes> damage_scripts() {
  std::vector<Bytes> scripts;
  for (std::uint8_t part = 0; part < 32; ++part) {
    Bytes script;
    for (const std::uint8_t each : {part, static_cast<std::uint8_t>(part * 7 % 32)}) {
      const Bytes step{std::byte{each}, std::byte{3}, std::byte{part}, {}, {}, {}, {}, {}};
      script.insert(script.end(), step.begin(), step.end());
    }
    scripts.push_back(script);
  }
  return scripts;
}

void read_clip(std::span<const std::byte> input) {
  static const container::testing::TemporaryFolder folder;
  static const bool written = [] {
    clip::Clip clip = clip::testing::bending_clip(1, 4, true);
    clip.layers[1].presence = motion::Presence::away_during({{0, 1}, {2, 4}});
    clip::write_clip(clip, folder / "a.mkv");
    return true;
  }();
  require(written, "the sample cannot be written");
  write_damaged(folder / "a.mkv", folder / "b.mkv", Damage(input));
  expect_refusal_or_success([&] { clip::read_clip(folder / "b.mkv"); });
}

/// Also drawn, as a capture; few pixels of small fields, or hardly any input would have its turn.
void read_clip_as_capture(std::span<const std::byte> input) {
  static const container::testing::TemporaryFolder folder;
  static const host::PluginTable plugins = host::PluginTable::builtin();
  static const bool written = [] {
    clip::Clip clip = clip::testing::bending_clip(1, 2, false);
    clip.intrinsics = {16, 12, 12, 12, 7.5, 5.5};
    clip.camera_to_world = {SE3::Identity()}; // the fields stand before it
    clip::write_clip(clip, folder / "a.mkv");
    return true;
  }();
  require(written, "the sample cannot be written");
  write_damaged(folder / "a.mkv", folder / "b.mkv", Damage(input));
  ingest::CaptureOptions options;
  options.format = "kinora-clip";
  options.frames.end = 1;
  Progress progress;
  const auto capture = ingest::Capture::open(plugins, folder / "b.mkv", options, progress);
  while (capture->next()) {
  }
}

} // namespace

std::vector<Fuzzer> file_fuzzers() {
  return {{"container", container_seeds, read_container, 8000},
          {"clip", damage_scripts, read_clip, 100},
          {"clip_capture", damage_scripts, read_clip_as_capture, 100}};
}

} // namespace kinora::fuzz
