// The channels and the header of one OpenEXR file, and its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <string>
#include <vector>

#include <Imath/half.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>

#include "core/image.h"
#include "core/se3.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class ExrCompression { kNone, kZip, kPiz };

/// "zip", "piz", "none".
ExrCompression compression_called(const std::string& name);

/// Built up one group of channels after another, each as large as the picture.
class ExrPicture {
public:
  ExrPicture(int width, int height, ExrCompression compression);

  void add(const char* name, std::vector<half> values);
  void add(const char* name, std::vector<float> values);
  void add(const char* name, std::vector<std::uint32_t> values);
  /// R G B A: linear light, multiplied by alpha. `color` has 3 or 4 channels.
  void add_colors(const ColorImage& color);
  /// As halfs from 0 to 1.
  void add_confidence(const Image<std::uint8_t>& confidence);
  /// fl_x fl_y cx cy, with the centre of the first pixel at (0.5, 0.5).
  void add_intrinsics(const KinoraCamera& camera);
  /// worldToCamera, in the axes of OpenEXR: x right, y up, z back, on both sides.
  void add_pose(const SE3& camera_to_world);

  Imf::Header& header() { return header_; }
  /// Throws Error(kUsage) if an image is of another size than the picture.
  void require_size(int width, int height) const;
  /// The whole file, the same for the same picture. `name`: for errors.
  std::vector<std::byte> bytes(const std::string& name) const;

private:
  void add_slice(const char* name, Imf::PixelType type, char* values, std::size_t size);

  Imf::Header header_;
  Imf::FrameBuffer slices_;
  std::list<std::vector<half>> halves_;
  std::list<std::vector<float>> floats_;
  std::list<std::vector<std::uint32_t>> numbers_;
};

} // namespace kinora::formats
