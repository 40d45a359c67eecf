#include "host/format_fault.h"

#include <algorithm>

#include <fmt/format.h>

#include "host/plugin_table.h"

namespace kinora::host {
namespace {

struct Capability {
  std::uint64_t flag;
  const char* name;
};

constexpr Capability kCapabilities[] = {
    {KINORA_READS_FRAMES, "read-frames"},
    {KINORA_SEEKS, "seek"},
    {KINORA_READS_POSES, "read-poses"},
    {KINORA_READS_MASKS, "read-masks"},
    {KINORA_READS_CONFIDENCE, "read-confidence"},
    {KINORA_READS_INFRARED, "read-infrared"},
    {KINORA_READS_DEVICE, "read-device"},
    {KINORA_READS_SOUND, "read-sound"},
    {KINORA_WRITES_FRAMES, "write-frames"},
    {KINORA_WRITES_TIMES, "write-times"},
    {KINORA_WRITES_POSES, "write-poses"},
    {KINORA_WRITES_MASKS, "write-masks"},
    {KINORA_WRITES_INFRARED, "write-infrared"},
    {KINORA_WRITES_DEPTH_CAMERA, "write-depth-camera"},
    {KINORA_WRITES_SOUND, "write-sound"},
    {KINORA_WRITES_PICTURES, "write-pictures"},
    {KINORA_WRITES_FILM, "write-film"},
    {KINORA_WRITES_ALPHA, "write-alpha"},
    {KINORA_WRITES_DEPTH, "write-depth"},
    {KINORA_WRITES_MESHES, "write-meshes"},
    {KINORA_WRITES_SKINS, "write-skins"},
    {KINORA_WRITES_VOLUMES, "write-volumes"},
    {KINORA_WRITES_NORMALS, "write-normals"},
    {KINORA_WRITES_CONFIDENCE, "write-confidence"},
    {KINORA_WRITES_TEXTURES, "write-textures"},
    {KINORA_WRITES_MESH_FRAME, "write-mesh-frame"},
    {KINORA_WRITES_METRIC_DEPTH, "write-metric-depth"},
    {KINORA_WRITES_LABELS, "write-labels"},
    {KINORA_WRITES_CAMERAS, "write-cameras"},
    {KINORA_WRITES_FILES_BESIDE, "write-files-beside"},
    {KINORA_WRITES_HIDDEN, "write-hidden"},
    {KINORA_WRITES_VOLUME_INDEX, "write-volume-index"},
    {KINORA_WRITES_PICTURE_LAYERS, "write-picture-layers"},
};

/// Every format has the members before this one; see plugin.h.
constexpr std::size_t kSmallestFormat = offsetof(KinoraFormat, writer_mesh);

bool is_format_name(const char* name) {
  const std::string_view text = name != nullptr ? name : "";
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

bool writes_anything(const KinoraFormat& format) {
  return (format.capabilities &
          (KINORA_WRITES_PICTURES | KINORA_WRITES_MESHES | KINORA_WRITES_VOLUMES | KINORA_WRITES_FRAMES)) != 0;
}

/// What a format that writes lacks for it; empty if nothing.
std::string fault_of_writing(const KinoraFormat& format) {
  if (format.open_writer == nullptr || format.writer_finish == nullptr || format.writer_abandon == nullptr ||
      (supports(format, KINORA_WRITES_PICTURES) && format.writer_write == nullptr))
    return " lacks a function for writing";
  const bool grown = format.struct_size >= offsetof(KinoraFormat, writer_capture); // since meshes and volumes
  if (supports(format, KINORA_WRITES_MESHES) && (!grown || format.writer_mesh == nullptr)) return " lacks writer_mesh";
  if (supports(format, KINORA_WRITES_SKINS) && (!grown || format.writer_pose == nullptr)) return " lacks writer_pose";
  if (supports(format, KINORA_WRITES_VOLUMES) && (!grown || format.writer_volume == nullptr))
    return " lacks writer_volume";
  if (supports(format, KINORA_WRITES_FRAMES) && (format.struct_size < offsetof(KinoraFormat, writer_facts) ||
                                                 format.writer_capture == nullptr || format.writer_frame == nullptr))
    return " lacks writer_capture or writer_frame";
  if (supports(format, KINORA_WRITES_SOUND) &&
      (format.struct_size < offsetof(KinoraFormat, index_extension) || format.writer_sound == nullptr ||
       format.writer_sound_packet == nullptr))
    return " lacks writer_sound or writer_sound_packet";
  if (supports(format, KINORA_WRITES_VOLUME_INDEX) &&
      (format.struct_size < sizeof(KinoraFormat) || format.index_extension == nullptr ||
       format.write_volume_index == nullptr))
    return " lacks write_volume_index";
  return {};
}

} // namespace

std::string fault_of_description(const KinoraFormat& format) {
  if (!is_format_name(format.name)) return "a format has no name of lower-case letters, digits and '-'";
  const std::string name = format.name;
  if (format.description == nullptr || format.extensions == nullptr) return name + " has no description";
  if (format.option_count > 0 && format.options == nullptr) return name + " has no list of options";
  for (std::size_t i = 0; i < format.option_count; ++i) {
    const KinoraOption& option = format.options[i];
    if (option.name == nullptr || option.type == nullptr || option.default_value == nullptr || option.help == nullptr)
      return name + " has an incomplete option";
  }
  if (!supports(format, KINORA_READS_FRAMES) && !writes_anything(format)) return name + " neither reads nor writes";
  return {};
}

std::string fault_of(const KinoraFormat* format) {
  if (format == nullptr) return "a format is missing";
  if (format->abi_version != KINORA_PLUGIN_ABI || format->struct_size < kSmallestFormat)
    return fmt::format("a format is made for version {} of the plugin interface, not {}", format->abi_version,
                       KINORA_PLUGIN_ABI);
  if (std::string fault = fault_of_description(*format); !fault.empty()) return fault;
  const std::string name = format->name;
  const bool reads = supports(*format, KINORA_READS_FRAMES);
  if (reads && (format->probe == nullptr || format->open_reader == nullptr || format->reader_info == nullptr ||
                format->reader_next == nullptr || format->reader_close == nullptr))
    return name + " lacks a function for reading";
  if (reads && supports(*format, KINORA_SEEKS) && format->reader_seek == nullptr) return name + " lacks reader_seek";
  if (reads && supports(*format, KINORA_READS_SOUND) &&
      (format->struct_size < offsetof(KinoraFormat, writer_sound) || format->reader_sound == nullptr ||
       format->reader_sound_packet == nullptr))
    return name + " lacks reader_sound or reader_sound_packet";
  const std::string fault = writes_anything(*format) ? fault_of_writing(*format) : "";
  return fault.empty() ? fault : name + fault;
}

std::uint64_t capability_called(std::string_view name) {
  for (const Capability& capability : kCapabilities)
    if (name == capability.name) return capability.flag;
  return 0;
}

bool supports(const KinoraFormat& format, std::uint64_t capability) {
  return (format.capabilities & capability) == capability;
}

std::vector<std::string> capability_names(const KinoraFormat& format) {
  std::vector<std::string> names;
  for (const Capability& capability : kCapabilities)
    if (supports(format, capability.flag)) names.emplace_back(capability.name);
  return names;
}

} // namespace kinora::host
