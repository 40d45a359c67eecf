#include "stray_scanner/format.h"

#include "common/captures.h"
#include "stray_scanner/stray_reader.h"

namespace kinora::formats {
namespace {
namespace fs = std::filesystem;

void probe_stray(const char* path, KinoraProbe* answer) {
  const fs::path folder = path;
  const bool poses = fs::is_regular_file(folder / "odometry.csv");
  const bool video = fs::is_regular_file(folder / "rgb.mp4");
  if (!poses && !video) return answer_probe(answer, 0, "no odometry.csv and no rgb.mp4");
  if (!poses || !video)
    return answer_probe(answer, 20, poses ? "odometry.csv without rgb.mp4" : "rgb.mp4 without odometry.csv");
  if (!fs::is_directory(folder / "depth")) return answer_probe(answer, 40, "rgb.mp4 and odometry.csv without depth/");
  answer_probe(answer, 95, "rgb.mp4, odometry.csv and depth/");
}

std::unique_ptr<StrayReader> open_stray(const char* path, const OptionMap& /*options*/) {
  return std::make_unique<StrayReader>(path);
}

constexpr KinoraFormat stray_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "stray-scanner";
  format.description = "folder of the iPhone app Stray Scanner: rgb.mp4, depth/, confidence/, odometry.csv";
  format.extensions = "";
  format.capabilities = KINORA_READS_POSES | KINORA_READS_CONFIDENCE;
  format.probe = safe_probe<probe_stray>;
  set_reader<StrayReader, open_stray>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kStrayFormat = stray_format();

} // namespace kinora::formats
