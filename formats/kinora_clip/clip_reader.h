// A clip's frames as its capture's camera sees them: drawn, with the depth of what is drawn.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/capture_info.h"
#include "common/label_file.h"
#include "core/image.h"
#include "player/player.h"

namespace kinora::formats {

/// Colour is composited on black. Depth is that of the clip's surfaces, without noise, in steps of kFloatDepthUnit; 0
/// where less than half of the light is stopped. Labels are those of the layers. Not thread-safe. Images of a frame
/// stay valid until the next call.
class ClipReader {
public:
  /// Reads the whole clip; of a damaged one, what is whole, with a warning. Throws Error: kNotRecognised,
  /// kCorruptInput.
  ClipReader(const std::filesystem::path& path, bool read_masks);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  void take(const fields::Picture& picture, const clip::LayerChoice& drawn); ///< `drawn`: those of its `front`

  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  player::Player player_;
  bool has_masks_;
  LabelTable labels_;
  std::size_t next_ = 0;
  ColorImage color_;
  DepthImage16 depth_;
  LabelImage mask_;
};

} // namespace kinora::formats
