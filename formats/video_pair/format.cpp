#include "video_pair/format.h"

#include <iterator>

#include "common/captures.h"
#include "common/files.h"
#include "video_pair/pair_reader.h"

namespace kinora::formats {
namespace {
namespace fs = std::filesystem;

void probe_pair(const char* path, KinoraProbe* answer) {
  if (!fs::is_directory(path)) return answer_probe(answer, 0, "not a folder");
  const std::optional<VideoPair> files = find_video_pair(path);
  if (!files) return answer_probe(answer, 0, "no pair of videos, of which one has \"depth\" in its name");
  answer_probe(answer, 70, files->color.filename().string() + " and " + files->depth.filename().string());
}

double metres_of(const OptionMap& options, const char* name, double otherwise) {
  const auto given = options.find(name);
  return given == options.end() ? otherwise : parse_number(given->second).value_or(-1);
}

std::unique_ptr<PairReader> open_pair(const char* path, const OptionMap& options) {
  const HueRange usual;
  return std::make_unique<PairReader>(
      path, HueRange{metres_of(options, "near", usual.near), metres_of(options, "far", usual.far)});
}

constexpr KinoraOption kOptions[] = {
    {"near", "number", "0.3", "Of depth as hue: the metres of red, where the hue begins.", nullptr},
    {"far", "number", "6", "Of depth as hue: the metres where it comes back to red.", nullptr}};

constexpr KinoraFormat pair_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "video-pair";
  format.description = "folder with a video of colour, a video of depth (16-bit grey, or hue) and intrinsics.json";
  format.extensions = "";
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe_pair>;
  set_reader<PairReader, open_pair>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kVideoPairFormat = pair_format();

} // namespace kinora::formats
