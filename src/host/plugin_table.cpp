#include "host/plugin_table.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"
#include "host/external_plugin.h"
#include "host/format_fault.h"
#include "host/interface_struct.h"

namespace kinora::host {
namespace fs = std::filesystem;

namespace {

constexpr int kSureEnough = 50; ///< as plugin.h says: "looks like it"

ExternalAnswer answer_of(const FormatEntry& entry, const fs::path& path) {
  if (entry.plugin != nullptr) return entry.plugin->probe(*entry.promised, path);
  const auto ask = [&](KinoraProbe* answer) { entry.format->probe(path.c_str(), answer); };
  if (entry.is_external()) return probe_isolated(ask);
  auto answer = make_struct<KinoraProbe>();
  ask(&answer);
  answer.reason[sizeof answer.reason - 1] = '\0';
  return {std::clamp(answer.confidence, 0, 100), answer.reason, false};
}

} // namespace

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
  PluginTable grown = *this;
  for (std::size_t i = 0; i < plugin.format_count; ++i) {
    const KinoraFormat* format = plugin.formats[i];
    if (const std::string fault = fault_of(format); !fault.empty())
      throw Error(ErrorCode::kMissingComponent, fmt::format("{}: {}; get a corrected build", origin, fault));
    grown.check_free(format->name, origin);
    grown.formats_.push_back({format, origin});
  }
  formats_ = std::move(grown.formats_);
}

void PluginTable::add(const std::shared_ptr<const ExternalPlugin>& plugin) {
  const std::string origin = plugin->manifest().path.string();
  PluginTable grown = *this;
  for (const ManifestFormat& format : plugin->manifest().formats) {
    grown.check_free(format.description.name, origin);
    grown.formats_.push_back({&format.description, origin, plugin, &format});
  }
  formats_ = std::move(grown.formats_);
}

void PluginTable::check_free(const char* name, const std::string& origin) const {
  for (const FormatEntry& entry : formats_)
    if (std::string_view(entry.format->name) == name)
      throw Error(ErrorCode::kFailure, fmt::format("{}: the format name {} is already taken ({}); remove one of them",
                                                   origin, name, entry.origin));
}

bool FormatEntry::installed() const { return plugin == nullptr || plugin->installed(); }

const KinoraFormat& PluginTable::opened(const FormatEntry& entry) {
  return entry.plugin == nullptr ? *entry.format : entry.plugin->open(*entry.promised);
}

const KinoraFormat& PluginTable::find(const std::string& name) const {
  std::vector<std::string> names;
  for (const FormatEntry& entry : formats_) {
    if (name == entry.format->name) return opened(entry);
    names.emplace_back(entry.format->name);
  }
  throw Error(ErrorCode::kUsage, fmt::format("no format is called \"{}\"; there are {}", name, fmt::join(names, ", ")));
}

std::vector<ProbeScore> PluginTable::probe(const fs::path& path) const {
  std::vector<ProbeScore> scores;
  for (const FormatEntry& entry : formats_) {
    if (!supports(*entry.format, KINORA_READS_FRAMES)) continue;
    const ExternalAnswer answer = answer_of(entry, path);
    scores.push_back({entry.format, answer.confidence, answer.reason, entry.origin});
  }
  std::stable_sort(scores.begin(), scores.end(),
                   [](const ProbeScore& a, const ProbeScore& b) { return a.confidence > b.confidence; });
  return scores;
}

const FormatEntry* PluginTable::device_format(const fs::path& input) const {
  std::error_code ignored;
  const std::string name = input.string().substr(0, input.string().find(':'));
  if (name == input.string() || fs::exists(input, ignored)) return nullptr;
  const auto found = std::ranges::find_if(formats_, [&](const FormatEntry& entry) {
    return name == entry.format->name && supports(*entry.format, KINORA_READS_DEVICE);
  });
  return found == formats_.end() ? nullptr : &*found;
}

const KinoraFormat& PluginTable::recognise(const fs::path& path) const {
  std::error_code ignored;
  if (const FormatEntry* device = device_format(path); device != nullptr) return opened(*device);
  if (!fs::exists(path, ignored))
    throw Error(ErrorCode::kUsage, path.string() + ": there is no such file or folder; check the path");
  const std::vector<ProbeScore> scores = probe(path);
  if (!scores.empty() && scores.front().confidence >= kSureEnough) return find(scores.front().format->name);
  for (const FormatEntry& entry : formats_)
    if (!entry.installed() && ExternalPlugin::has_magic(*entry.promised, path))
      throw Error(ErrorCode::kMissingComponent,
                  fmt::format("{}: could have been read by the format {}, which is not installed: {} is missing; "
                              "install the plugin {} again",
                              path.string(), entry.format->name, entry.plugin->manifest().library.string(),
                              entry.plugin->manifest().name));
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
      if (candidate == extension) return opened(entry);
      known.emplace_back(candidate);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  throw Error(ErrorCode::kUsage, fmt::format("{}: no format writes files called *{}; there are {}, and --to names "
                                             "a format by itself, for a folder with such a name too",
                                             path.string(), extension, fmt::join(known, ", ")));
}

} // namespace kinora::host
