// Frames out of a listing: decodes, checks sizes, and reads poses and masks, one frame at a time.
#pragma once

#include <string>
#include <vector>

#include "common/capture_info.h"
#include "common/label_file.h"
#include "core/image.h"
#include "kinora/plugin.h"
#include "rgbd_folder/listing.h"

namespace kinora::formats {

/// Not thread-safe. Images of a frame stay valid until the next call.
class FolderReader {
public:
  /// Finds the image size from the first frames that can be read. `folder` is searched for labels.json.
  /// Throws Error(kCorruptInput) if no frame can be read or colour and depth differ in size.
  FolderReader(Listing listing, const std::filesystem::path& folder, bool read_masks);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  void find_image_size();
  void read_images(const FrameFiles& files);
  LabelImage read_masks(const FrameFiles& files) const;

  Listing listing_;
  bool read_masks_;
  bool has_masks_ = false;
  LabelTable labels_;
  WarningTable warnings_;
  std::size_t next_ = 0;
  ColorImage color_;
  std::vector<std::byte> color_bytes_; ///< the file that colour was decoded from
  DepthImage16 depth_;
  LabelImage mask_;
};

} // namespace kinora::formats
