#include "azure_kinect/format.h"

#include <fstream>

#include "azure_kinect/kinect_reader.h"
#include "common/captures.h"

namespace kinora::formats {
namespace {

/// The words stand in the head of the file, within its Tracks.
void probe_kinect(const char* path, KinoraProbe* answer) {
  constexpr std::size_t kHead = 64 << 10;
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  if (!head.starts_with("\x1a\x45\xdf\xa3")) return answer_probe(answer, 0, "no Matroska file");
  const bool tracks = head.find("COLOR") != std::string::npos && head.find("DEPTH") != std::string::npos;
  if (!tracks) return answer_probe(answer, 0, "Matroska without tracks COLOR and DEPTH");
  const bool tags = head.find("K4A_") != std::string::npos || head.find("CalibrationInformation") != std::string::npos;
  answer_probe(answer, tags ? 92 : 60, "Matroska with tracks COLOR and DEPTH");
}

std::unique_ptr<KinectReader> open_kinect(const char* path, const OptionMap& /*options*/) {
  return std::make_unique<KinectReader>(path);
}

constexpr KinoraFormat kinect_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "azure-kinect";
  format.description = "recording of an Azure Kinect (k4arecorder), or of an Orbbec camera in that form";
  format.extensions = "";
  format.capabilities = KINORA_READS_INFRARED;
  format.probe = safe_probe<probe_kinect>;
  set_reader<KinectReader, open_kinect>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kAzureKinectFormat = kinect_format();

} // namespace kinora::formats
