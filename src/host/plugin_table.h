// The formats that this process knows: those that come with Kinora, in an explicit table, and external ones.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/progress.h"
#include "kinora/plugin.h"

namespace kinora::host {

class ExternalPlugin;
struct ManifestFormat;

/// One format and where it comes from.
struct FormatEntry {
  const KinoraFormat* format; ///< without functions where a plugin.json describes it: `find` gives those
  std::string origin;         ///< "built-in", or the path of the external plugin's library or plugin.json
  std::shared_ptr<const ExternalPlugin> plugin = nullptr; ///< whose library is not open yet
  const ManifestFormat* promised = nullptr;               ///< what its plugin.json says

  bool is_external() const { return origin != "built-in"; }
  /// Whether its library is there; what comes with Kinora says so itself when it is used.
  bool installed() const;
};

/// How sure a format is that an input is its own.
struct ProbeScore {
  const KinoraFormat* format;
  int confidence;     ///< 0–100
  std::string reason; ///< what was found, or what is missing
  std::string origin; ///< as FormatEntry has it
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

  /// Adds what a plugin.json describes, or nothing. Throws Error(kFailure) for a name that is taken.
  void add(const std::shared_ptr<const ExternalPlugin>& plugin);

  const std::vector<FormatEntry>& formats() const { return formats_; }

  /// With its functions: an external library is opened. Throws Error(kUsage), listing the names there are, and
  /// Error(kMissingComponent) for a plugin that is not installed or cannot be used.
  const KinoraFormat& find(const std::string& name) const;

  /// What every reading format says of an input, the surest first (equal ones in the order of the table). External
  /// plugins are asked in a child process, so that one that crashes or hangs is named as the reason and nothing more.
  std::vector<ProbeScore> probe(const std::filesystem::path& path) const;

  /// The surest format of all; of "NAME:DEVICE" the format of that name, if it reads live cameras. Throws Error: kUsage
  /// if there is no such file or folder, kNotRecognised, naming what came closest, if no format is sure enough.
  const KinoraFormat& recognise(const std::filesystem::path& path) const;

  /// Whether an input is "NAME:DEVICE" of a format that reads live cameras, and no file.
  bool is_device(const std::filesystem::path& input) const { return device_format(input) != nullptr; }

  /// The format that writes files of this path's extension and has one of the capabilities (bits). Throws
  /// Error(kUsage), listing what can be written.
  const KinoraFormat& writer_for(const std::filesystem::path& path,
                                 std::uint64_t capabilities = KINORA_WRITES_PICTURES) const;

private:
  void check_free(const char* name, const std::string& origin) const;
  const FormatEntry* device_format(const std::filesystem::path& input) const;
  /// The format with its functions.
  static const KinoraFormat& opened(const FormatEntry& entry);

  std::vector<FormatEntry> formats_;
};

/// Folders that external plugins are looked for in: `extra`, then those of KINORA_PLUGIN_PATH, then the installation's
/// lib/kinora/plugins beside the program's folder.
std::vector<std::filesystem::path> plugin_folders(std::span<const std::filesystem::path> extra);

/// Adds every folder with a plugin.json, whose library is opened when it is used, and loads every *.so that lies in a
/// folder itself; in the order of names. A plugin that cannot be used gives one warning and is left
/// out; a folder that does not exist is passed over. Loaded libraries stay for the life of the process.
void load_external_plugins(PluginTable& table, std::span<const std::filesystem::path> folders, Progress& progress);

} // namespace kinora::host
