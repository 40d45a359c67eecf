// plugin.json: what an external plugin says of itself, so that its library need not be opened to know it.
#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "kinora/plugin.h"

namespace kinora::host {

/// Bytes that a file of the format has at a place.
struct Magic {
  std::size_t offset = 0;
  std::string bytes;
};

/// One format, as plugin.json has it.
struct ManifestFormat {
  KinoraFormat description; ///< without functions; its texts are the manifest's
  std::vector<Magic> magic; ///< any of them; empty: only the library can tell
};

struct Manifest {
  std::filesystem::path path; ///< of plugin.json
  std::string name;
  std::string version;
  std::string license; ///< as SPDX writes it
  std::filesystem::path library;
  std::vector<ManifestFormat> formats;

  std::deque<std::string> texts; ///< what the descriptions point to
  std::deque<std::vector<KinoraOption>> options;
};

/// Throws Error(kMissingComponent), naming the file and what to write, if it is not as docs/plugins.md says or its
/// range of interface versions leaves out this program's.
Manifest read_manifest(const std::filesystem::path& path);

} // namespace kinora::host
