// What a jump to any frame costs on one core, beyond reading the fields: each layer's motion decoded from the last
// payload with the key flag on, its field carried there. Frames are chosen by chance, always the same. Prints the
// machine's own speed and the slowest frame, then CSV: median, 99th in 100 and slowest of decoding, of carrying and of
// both.
//   bench_seeking CLIP.mkv [jumps]
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "clip/clip_edit.h"
#include "clip/clip_io.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/pose_codec.h"
#include "core/parallel.h"
#include "core/random.h"
#include "fields/calibration.h"
#include "player/player.h"
#include "stopwatch.h"

using namespace kinora;

namespace {

constexpr const char* kPlace = "the clip";

// One for each layer that deforms, as a reader has them once it has read the graphs.
std::vector<std::optional<clip::DeformationDecoder>> decoders_of(const clip::Clip& clip) {
  std::vector<std::optional<clip::DeformationDecoder>> decoders(clip.layers.size());
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    if (clip.layers[l].motion.graph()) decoders[l].emplace(*clip.layers[l].motion.graph());
  }
  return decoders;
}

// All layers' motions at a frame, from their payloads alone.
void decode_frame(const clip::StoredClip& stored, std::vector<std::optional<clip::DeformationDecoder>>& decoders,
                  std::size_t frame) {
  for (std::size_t l = 0; l < decoders.size(); ++l) {
    const std::uint16_t track = stored.description.layers[l].motion_track;
    if (track == 0) continue;
    const std::vector<container::Payload>& payloads = stored.payloads.at(track);
    if (!decoders[l]) {
      clip::decode_pose(payloads.at(frame).bytes, kPlace);
      continue;
    }
    std::size_t first = frame;
    while (!payloads.at(first).key) --first;
    for (std::size_t f = first; f <= frame; ++f) decoders[l]->decode(payloads[f].bytes, payloads[f].key, kPlace);
  }
}

void print(const char* what, std::vector<double> milliseconds) {
  std::sort(milliseconds.begin(), milliseconds.end());
  std::printf("%s,%.2f,%.2f,%.2f\n", what, milliseconds[milliseconds.size() / 2],
              milliseconds[milliseconds.size() * 99 / 100], milliseconds.back());
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: bench_seeking CLIP.mkv [jumps]\n");
    return 2;
  }
  try {
    const std::size_t jumps = argc == 3 ? std::stoul(argv[2]) : 300;
    set_thread_count(1);
    bench::print_calibration();
    const clip::StoredClip stored = clip::load_stored_clip(argv[1]);
    const player::Player player(clip::read_clip(argv[1]));
    std::vector<std::optional<clip::DeformationDecoder>> decoders = decoders_of(player.clip());
    std::vector<double> decode, carry, both;
    std::size_t slowest = 0;
    Random random(1);
    for (std::size_t i = 0; i < jumps; ++i) {
      const auto frame = random.below(static_cast<std::uint32_t>(player.frame_count()));
      const bench::Stopwatch watch;
      decode_frame(stored, decoders, frame);
      decode.push_back(watch.processor_milliseconds());
      player.posed_layers(frame, player.all_layers());
      both.push_back(watch.processor_milliseconds());
      carry.push_back(both.back() - decode.back());
      if (both.back() >= *std::max_element(both.begin(), both.end())) slowest = frame;
    }
    std::printf("# %zu jumps in %zu frames; the slowest to frame %zu\nwhat,median_ms,p99_ms,slowest_ms\n", jumps,
                player.frame_count(), slowest);
    print("decode", decode);
    print("carry", carry);
    print("both", both);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_seeking: %s\n", error.what());
    return 1;
  }
  return 0;
}
