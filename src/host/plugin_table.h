// The formats that this process knows: those that come with Kinora, in an explicit table, and external ones.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/progress.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// One format and where it comes from.
struct FormatEntry {
  const KinoraFormat* format;
  std::string origin; ///< "built-in", or the path of the external plugin
};

/// How sure a format is that an input is its own.
struct ProbeScore {
  const KinoraFormat* format;
  int confidence;     ///< 0–100
  std::string reason; ///< what was found, or what is missing
};

/// A capability's word, for people and for `--json`: "read-frames", "seek", "write-film", …
std::vector<std::string> capability_names(const KinoraFormat& format);
bool supports(const KinoraFormat& format, std::uint64_t capability);

/// Thread-safe to read once it is filled. Formats live as long as the process.
class PluginTable {
public:
  /// The formats that come with Kinora.
  static PluginTable builtin();

  /// Adds all formats of a plugin, or none. Throws Error(kMissingComponent), naming `origin`, if the plugin is for
  /// another version of the interface or a descriptor is incomplete, and Error(kFailure) for a name that is taken.
  void add(const KinoraPlugin& plugin, const std::string& origin);

  const std::vector<FormatEntry>& formats() const { return formats_; }

  /// Throws Error(kUsage), listing the names there are.
  const KinoraFormat& find(const std::string& name) const;

  /// What every reading format says of an input, the surest first (equal ones in the order of the table).
  std::vector<ProbeScore> probe(const std::filesystem::path& path) const;

  /// The surest format of all. Throws Error: kUsage if there is no such file or folder, kNotRecognised, naming what
  /// came closest, if no format is sure enough.
  const KinoraFormat& recognise(const std::filesystem::path& path) const;

  /// The format that writes files of this path's extension and has one of the capabilities (bits). Throws
  /// Error(kUsage), listing what can be written.
  const KinoraFormat& writer_for(const std::filesystem::path& path,
                                 std::uint64_t capabilities = KINORA_WRITES_PICTURES) const;

private:
  std::vector<FormatEntry> formats_;
};

/// Folders that external plugins are looked for in: `extra`, then those of KINORA_PLUGIN_PATH, then the installation's
/// lib/kinora/plugins beside the program's folder.
std::vector<std::filesystem::path> plugin_folders(std::span<const std::filesystem::path> extra);

/// Loads every *.so of the folders, in the order of names. A plugin that cannot be used gives one warning and is left
/// out; a folder that does not exist is passed over. Loaded libraries stay for the life of the process.
void load_external_plugins(PluginTable& table, std::span<const std::filesystem::path> folders, Progress& progress);

} // namespace kinora::host
