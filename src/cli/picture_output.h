// Where drawn pictures go: one picture, a folder of pictures, or a film.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/context.h"
#include "fields/rendering/renderer.h"
#include "host/options.h"
#include "host/picture_writer.h"

namespace kinora::cli {

enum class OutputKind { kPicture, kFolder, kFilm };

struct PictureRequest {
  std::filesystem::path path;
  host::Options options; ///< of the writer; "format" chooses it where the path does not
  bool overwrite = false;
  std::vector<std::string> passes; ///< besides colour: depth, normal, confidence, deep
  std::vector<std::filesystem::path> inputs;
  host::Facts facts = {}; ///< for the output's metadata
  bool resume = false;    ///< pictures of a folder that are there with all their passes stay, and are not drawn again
};

/// A layer drawn by itself.
struct DrawnLayer {
  fields::Picture picture;
  host::LabelMeaning label;
};

/// What was drawn, from where and when.
struct DrawnPicture {
  fields::Picture picture;
  std::string name;
  double seconds = 0; ///< from the start, never decreasing; in films increasing
  Camera camera;
  std::vector<host::LabelMeaning> labels = {}; ///< of the layers that are drawn, as picture.front counts them
  std::vector<DrawnLayer> layers = {};         ///< for the pass deep
};

/// .mp4 and other film extensions: a film; an extension of a picture format: one picture; else a folder.
/// Throws Error(kUsage) for extensions of pictures and films that no format writes.
OutputKind output_kind(const std::filesystem::path& path, const host::PluginTable& plugins);

/// The format that writes the output. Throws Error(kUsage) if there is none.
const KinoraFormat& picture_format(const PictureRequest& request, const host::PluginTable& plugins);

/// Nothing of an output is seen under its name until it is whole: a film appears at finish(), a folder's pictures one
/// by one.
class PictureOutput {
public:
  /// Checks everything that can be checked before drawing. `names`: of all pictures to come.
  /// Throws Error: kUnwritableOutput, kUsage.
  static std::unique_ptr<PictureOutput> open(const PictureRequest& request, const std::vector<std::string>& names,
                                             const host::PluginTable& plugins);
  virtual ~PictureOutput() = default;
  /// Whether the picture of this name is there already and stays.
  virtual bool is_done(const std::string& /*name*/) const { return false; }
  virtual void add(const DrawnPicture& drawn) = 0;
  virtual void finish() = 0;
};

} // namespace kinora::cli
