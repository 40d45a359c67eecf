// A plugin that does not come with Kinora. Its library is opened when one of its formats is first used.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "host/plugin_manifest.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// An external format's answer to a probe.
struct ExternalAnswer {
  int confidence = 0;
  std::string reason;
  bool refused = false; ///< the plugin broke: it crashed, hung, or is not what it says
};

/// Opens a library and asks it for its plugin, after a child process has done the same and lived: a library that
/// crashes or hangs there is refused. Stays open for the life of the process. Throws Error(kMissingComponent).
const KinoraPlugin& load_library(const std::filesystem::path& path);

/// Asks in a child process.
ExternalAnswer probe_isolated(const std::function<void(KinoraProbe*)>& probe);

/// A folder with plugin.json. Thread-safe.
class ExternalPlugin {
public:
  explicit ExternalPlugin(Manifest manifest) : manifest_(std::move(manifest)) {}

  const Manifest& manifest() const { return manifest_; }
  bool installed() const;
  /// Whether an input has the magic bytes of a format; false where the format has none.
  static bool has_magic(const ManifestFormat& format, const std::filesystem::path& input);
  /// Without the library where the magic bytes already say no; else in a child process.
  ExternalAnswer probe(const ManifestFormat& format, const std::filesystem::path& input) const;
  /// The library's own descriptor. Throws Error(kMissingComponent) if the library is missing, breaks, or is not what
  /// plugin.json says.
  const KinoraFormat& open(const ManifestFormat& format) const;

private:
  const KinoraFormat& checked_format(const KinoraPlugin& plugin, const ManifestFormat& format) const;

  Manifest manifest_;
  mutable std::mutex mutex_;
  mutable const KinoraPlugin* opened_ = nullptr;
};

} // namespace kinora::host
