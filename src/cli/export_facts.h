// What an export says of itself: in its files, and on the last line of its command.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/conversion.h"
#include "player/view_path.h"

namespace kinora::cli {

/// Pictures of a clip: what is drawn, and for which format.
struct PictureExport {
  const clip::Clip& clip;
  const KinoraFormat& format;
  std::filesystem::path input;
  std::string cameras; ///< in a few words
  const std::vector<player::View>& views;
  const clip::LayerChoice& layers;
  const std::vector<std::string>& passes; ///< besides colour
};

/// What a file may say of how it was made, beside what its format adds: names and values.
host::Facts facts_of(const Conversion& conversion);
host::Facts facts_of(const PictureExport& pictures);

/// What no output of this kind carries, in a few words each.
std::vector<std::string> losses_of(const Conversion& conversion);
std::vector<std::string> losses_of(const PictureExport& pictures);

/// "Not in it: …" and the end of the line.
std::string losses_text(const std::vector<std::string>& losses);

} // namespace kinora::cli
