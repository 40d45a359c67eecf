#include "gltf_scene/format.h"

#include <cstring>

#include "common/captures.h"
#include "common/deferred.h"
#include "common/random_access_file.h"
#include "gltf_scene/description.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"gltf_scene", "gltf-scene", "to read glTF scenes"};

const KinoraFormat& gltf_scene_format() {
  static const KinoraFormat format = [] {
    KinoraFormat made = deferred_format<kModule>(gltf_scene_description());
    made.probe = safe_probe<probe_gltf_scene>;
    return made;
  }();
  return format;
}

void probe_gltf_scene(const char* path, KinoraProbe* answer) {
  constexpr std::uint64_t kHeadBytes = 12;
  const RandomAccessFile file(path);
  const std::vector<std::byte> head = file.read(0, std::min(file.size(), kHeadBytes));
  std::uint32_t version = 0;
  if (head.size() == kHeadBytes) std::memcpy(&version, head.data() + 4, sizeof version);
  if (head.size() == kHeadBytes && std::memcmp(head.data(), "glTF", 4) == 0)
    return version == 2 ? answer_probe(answer, 100, "a binary glTF file")
                        : answer_probe(answer, 20, "a binary glTF file, but not of version 2");
  const bool named = std::filesystem::path(path).extension() == ".gltf";
  const bool json = !head.empty() && (head[0] == std::byte{'{'} || head[0] == std::byte{' '});
  if (named && json) return answer_probe(answer, 80, "a glTF file");
  answer_probe(answer, 0, "no glTF file");
}

} // namespace kinora::formats
