#include "host/plugin_table.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"
#include "host/interface_struct.h"

namespace kinora::host {
namespace fs = std::filesystem;

namespace {

constexpr int kSureEnough = 50; ///< as plugin.h says: "looks like it"

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
  return (format.capabilities & (KINORA_WRITES_PICTURES | KINORA_WRITES_MESHES | KINORA_WRITES_VOLUMES)) != 0;
}

/// What a format that writes lacks for it; empty if nothing.
std::string fault_of_writing(const KinoraFormat& format) {
  if (format.open_writer == nullptr || format.writer_finish == nullptr || format.writer_abandon == nullptr ||
      (supports(format, KINORA_WRITES_PICTURES) && format.writer_write == nullptr))
    return " lacks a function for writing";
  const bool grown = format.struct_size >= sizeof(KinoraFormat);
  if (supports(format, KINORA_WRITES_MESHES) && (!grown || format.writer_mesh == nullptr)) return " lacks writer_mesh";
  if (supports(format, KINORA_WRITES_SKINS) && (!grown || format.writer_pose == nullptr)) return " lacks writer_pose";
  if (supports(format, KINORA_WRITES_VOLUMES) && (!grown || format.writer_volume == nullptr))
    return " lacks writer_volume";
  return {};
}

/// Why a descriptor cannot be used; empty if it can.
std::string fault_of(const KinoraFormat* format) {
  if (format == nullptr) return "a format is missing";
  if (format->abi_version != KINORA_PLUGIN_ABI || format->struct_size < kSmallestFormat)
    return fmt::format("a format is made for version {} of the plugin interface, not {}", format->abi_version,
                       KINORA_PLUGIN_ABI);
  if (!is_format_name(format->name)) return "a format has no name of lower-case letters, digits and '-'";
  const std::string name = format->name;
  if (format->description == nullptr || format->extensions == nullptr) return name + " has no description";
  if (format->option_count > 0 && format->options == nullptr) return name + " has no list of options";
  for (std::size_t i = 0; i < format->option_count; ++i) {
    const KinoraOption& option = format->options[i];
    if (option.name == nullptr || option.type == nullptr || option.default_value == nullptr || option.help == nullptr)
      return name + " has an incomplete option";
  }
  const bool reads = supports(*format, KINORA_READS_FRAMES);
  const bool writes = writes_anything(*format);
  if (!reads && !writes) return name + " neither reads nor writes";
  if (reads && (format->probe == nullptr || format->open_reader == nullptr || format->reader_info == nullptr ||
                format->reader_next == nullptr || format->reader_close == nullptr))
    return name + " lacks a function for reading";
  if (reads && supports(*format, KINORA_SEEKS) && format->reader_seek == nullptr) return name + " lacks reader_seek";
  const std::string fault = writes ? fault_of_writing(*format) : "";
  return fault.empty() ? fault : name + fault;
}

} // namespace

bool supports(const KinoraFormat& format, std::uint64_t capability) {
  return (format.capabilities & capability) == capability;
}

std::vector<std::string> capability_names(const KinoraFormat& format) {
  std::vector<std::string> names;
  for (const Capability& capability : kCapabilities)
    if (supports(format, capability.flag)) names.emplace_back(capability.name);
  return names;
}

PluginTable PluginTable::builtin() {
  PluginTable table;
  table.add(*kinora_builtin_plugin(), "built-in");
  return table;
}

void PluginTable::add(const KinoraPlugin& plugin, const std::string& origin) {
  if (plugin.abi_version != KINORA_PLUGIN_ABI || plugin.struct_size < sizeof(KinoraPlugin) ||
      (plugin.format_count > 0 && plugin.formats == nullptr))
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}: made for version {} of the plugin interface, not {}; get a matching build", origin,
                            plugin.abi_version, KINORA_PLUGIN_ABI));
  std::vector<FormatEntry> grown = formats_;
  for (std::size_t i = 0; i < plugin.format_count; ++i) {
    const KinoraFormat* format = plugin.formats[i];
    if (const std::string fault = fault_of(format); !fault.empty())
      throw Error(ErrorCode::kMissingComponent, fmt::format("{}: {}; get a corrected build", origin, fault));
    for (const FormatEntry& entry : grown)
      if (std::string_view(entry.format->name) == format->name)
        throw Error(ErrorCode::kFailure, fmt::format("{}: the format name {} is already taken ({}); remove one of them",
                                                     origin, format->name, entry.origin));
    grown.push_back({format, origin});
  }
  formats_ = std::move(grown);
}

const KinoraFormat& PluginTable::find(const std::string& name) const {
  std::vector<std::string> names;
  for (const FormatEntry& entry : formats_) {
    if (name == entry.format->name) return *entry.format;
    names.emplace_back(entry.format->name);
  }
  throw Error(ErrorCode::kUsage, fmt::format("no format is called \"{}\"; there are {}", name, fmt::join(names, ", ")));
}

std::vector<ProbeScore> PluginTable::probe(const fs::path& path) const {
  std::vector<ProbeScore> scores;
  for (const FormatEntry& entry : formats_) {
    if (!supports(*entry.format, KINORA_READS_FRAMES)) continue;
    auto answer = make_struct<KinoraProbe>();
    entry.format->probe(path.c_str(), &answer);
    answer.reason[sizeof answer.reason - 1] = '\0';
    scores.push_back({entry.format, std::clamp(answer.confidence, 0, 100), answer.reason});
  }
  std::stable_sort(scores.begin(), scores.end(),
                   [](const ProbeScore& a, const ProbeScore& b) { return a.confidence > b.confidence; });
  return scores;
}

const KinoraFormat& PluginTable::recognise(const fs::path& path) const {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    throw Error(ErrorCode::kUsage, path.string() + ": there is no such file or folder; check the path");
  const std::vector<ProbeScore> scores = probe(path);
  if (!scores.empty() && scores.front().confidence >= kSureEnough) return *scores.front().format;
  if (!scores.empty() && scores.front().confidence > 0)
    throw Error(ErrorCode::kNotRecognised,
                fmt::format("{}: no format recognises it; the closest is {}, which finds {}", path.string(),
                            scores.front().format->name, scores.front().reason));
  throw Error(ErrorCode::kNotRecognised,
              path.string() + ": no format recognises it; a capture is a folder with rgb/ or color/ and depth/ images "
                              "and intrinsics.json");
}

const KinoraFormat& PluginTable::writer_for(const fs::path& path, std::uint64_t capabilities) const {
  const std::string extension = path.extension().string();
  std::vector<std::string> known;
  for (const FormatEntry& entry : formats_) {
    if ((entry.format->capabilities & capabilities) == 0) continue;
    std::string_view rest = entry.format->extensions;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(' '), rest.size());
      const std::string_view candidate = rest.substr(0, end);
      if (candidate == extension) return *entry.format;
      known.emplace_back(candidate);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  throw Error(ErrorCode::kUsage, fmt::format("{}: no format writes files called *{}; there are {}", path.string(),
                                             extension, fmt::join(known, ", ")));
}

} // namespace kinora::host
