#include "record3d/format.h"

#include <zip.h>

#include "common/captures.h"
#include "record3d/record3d_reader.h"

namespace kinora::formats {
namespace {

void probe_record3d(const char* path, KinoraProbe* answer) {
  zip_t* const archive = std::filesystem::is_regular_file(path) ? zip_open(path, ZIP_RDONLY, nullptr) : nullptr;
  if (archive == nullptr) return answer_probe(answer, 0, "no archive");
  const bool metadata = zip_name_locate(archive, "metadata", 0) >= 0;
  const bool frames = zip_name_locate(archive, "rgbd/0.jpg", 0) >= 0;
  zip_discard(archive);
  if (metadata && frames) return answer_probe(answer, 95, "archive with metadata and rgbd/0.jpg");
  answer_probe(answer, 0, "archive without metadata and rgbd/0.jpg");
}

std::unique_ptr<Record3dReader> open_record3d(const char* path, const OptionMap& /*options*/) {
  return std::make_unique<Record3dReader>(path);
}

constexpr KinoraFormat record3d_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "record3d";
  format.description = "recording of the iPhone app Record3D (.r3d)";
  format.extensions = "";
  format.capabilities = KINORA_READS_POSES | KINORA_READS_CONFIDENCE;
  format.probe = safe_probe<probe_record3d>;
  set_reader<Record3dReader, open_record3d>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kRecord3dFormat = record3d_format();

} // namespace kinora::formats
