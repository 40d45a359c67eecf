// What reading a whole clip costs: processor time, the memory of what is given, and the most that was needed besides.
// Prints the machine's own speed, then CSV.
//   bench_decoding CLIP.mkv
//   bench_decoding --largest=LAYERS CLIP.mkv           writes such a clip: LAYERS fields of the largest size
//   bench_decoding --largest-packed=LAYERS CLIP.mkv    the same in the oldest version (largest_clip.h)
#include <cstdio>
#include <cstdlib>
#include <string>

#include "clip/clip_io.h"
#include "core/parallel.h"
#include "fields/calibration.h"
#include "largest_clip.h"
#include "peak_memory.h"
#include "stopwatch.h"

using namespace kinora;

namespace {

// Of the arrays that grow with a clip.
std::size_t bytes_of(const clip::Clip& clip) {
  std::size_t bytes = clip.camera_to_world.size() * sizeof(SE3) + clip.times.size() * sizeof(double);
  for (const clip::Layer& layer : clip.layers) {
    bytes += layer.field.parameter_count() * sizeof(float) + layer.field.occupancy.words().size() * 8;
    if (layer.confidence) bytes += layer.confidence->levels().size() * sizeof(layer.confidence->levels().front());
    if (layer.motion.kind() == motion::MotionKind::kRigid) {
      bytes += layer.motion.poses().size() * sizeof(motion::Motion::Pose);
    } else if (layer.motion.kind() == motion::MotionKind::kDeforming) {
      bytes += layer.motion.deformations().size() * layer.motion.graph()->nodes().size() * sizeof(DualQuaternion);
    }
  }
  return bytes;
}

} // namespace

int main(int argc, char** argv) {
  const std::string option = argc == 3 ? argv[1] : "";
  const std::size_t name_length = option.find('=');
  const std::string name = option.substr(0, name_length);
  const bool packed = name == "--largest-packed";
  const bool writes = name_length != std::string::npos && (packed || name == "--largest");
  if (argc != 2 && !writes) {
    std::fprintf(stderr, "usage: bench_decoding [--largest=LAYERS | --largest-packed=LAYERS] CLIP.mkv\n");
    return 2;
  }
  try {
    const std::string path = argv[argc - 1];
    if (writes) {
      bench::write_largest_clip(path, std::stoul(option.substr(name_length + 1)), packed);
      return 0;
    }
    set_thread_count(1);
    bench::print_calibration();
    bench::forget_peak_memory();
    const double before = bench::megabytes_of("VmRSS:");
    const bench::Stopwatch watch;
    const clip::Clip clip = clip::read_clip(path);
    const double milliseconds = watch.processor_milliseconds();
    const double given = static_cast<double>(bytes_of(clip)) / 1e6;
    std::printf("frames,layers,processor_ms,clip_mb,besides_mb\n%zu,%zu,%.0f,%.1f,%.1f\n", clip.times.size(),
                clip.layers.size(), milliseconds, given, bench::megabytes_of("VmHWM:") - before - given);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_decoding: %s\n", error.what());
    return 1;
  }
  return 0;
}
