// A format's writer behind C++: statuses become errors; what is not finished is abandoned.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "host/open_writer.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// What a label of pictures means: the name and the kind ("still", "rigid", "deforming") of a layer.
struct LabelMeaning {
  int label = 0;
  std::string name;
  std::string kind;
};

/// One picture to write.
struct Picture {
  std::string name;                    ///< without extension; may hold '/' for folders
  double time = 0;                     ///< seconds from the start, never decreasing; in films increasing
  ColorImage color;                    ///< 3 channels sRGB, or 4 with straight alpha
  DepthImage16 depth;                  ///< millimetres, 0 = nothing; may be empty
  Image<float> normal = {};            ///< 3 channels: unit vectors along the camera's axes, 0 = nothing; may be empty
  Image<std::uint8_t> confidence = {}; ///< may be empty
  DepthImage metric_depth = {};        ///< metres along the optical axis, 0 = nothing; may be empty
  LabelImage labels = {};              ///< of what is in front, 0 where nothing is; may be empty
  std::span<const LabelMeaning> label_meanings = {}; ///< of labels
  std::optional<Camera> camera = std::nullopt;       ///< that sees the picture
  /// What it was composited of: of each layer the colour, the metric depth and what its label means.
  std::vector<Picture> layers = {};
};

/// Moveable, one thread at a time. The format must outlive it. Writes exactly to the path that it is given.
class PictureWriter {
public:
  /// Throws what the plugin reports, and Error(kUsage) for options that the format does not declare or a format that
  /// does not write. `facts`: for the output's metadata, if its format has a place for them.
  PictureWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                const Facts& facts = {});

  const KinoraFormat& format() const { return *format_; }
  /// Formats without alpha get the colour composited on black. Depth and what else stands beside colour
  /// is dropped where the format has no place for it.
  /// Throws Error, normally kUnwritableOutput.
  void write(const Picture& picture);
  /// Completes the output. Nothing may be written afterwards.
  void finish();

private:
  const KinoraFormat* format_;
  WriterHandle writer_;
};

} // namespace kinora::host
