#include "kinora_clip/format.h"

#include <iterator>

#include "clip/codec_ids.h"
#include "common/captures.h"
#include "container/reader.h"
#include "kinora_clip/clip_reader.h"

namespace kinora::formats {
namespace {

/// Less sure than of the recording that may stand behind it, which is what the camera saw.
void probe_clip(const char* path, KinoraProbe* answer) {
  const container::Reader reader(path, container::Reading::kSalvage);
  if (reader.tag(container::kKindTag) == clip::kClipKind) return answer_probe(answer, 80, "a Kinora clip");
  answer_probe(answer, 0, "a Matroska file without a clip");
}

std::unique_ptr<ClipReader> open_reader(const char* path, const OptionMap& options) {
  return std::make_unique<ClipReader>(path, option_is_set(options, "masks", true));
}

constexpr KinoraOption kOptions[] = {{"masks", "bool", "true", "Give the layers as masks.", nullptr}};

constexpr KinoraFormat clip_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "kinora-clip";
  format.description = "a clip, drawn as its capture's camera saw it, with the depth of what is drawn";
  format.extensions = "";
  format.capabilities = KINORA_READS_POSES | KINORA_READS_MASKS;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe_clip>;
  set_reader<ClipReader, open_reader>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kClipFormat = clip_format();

} // namespace kinora::formats
