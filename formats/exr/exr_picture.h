// The channels and the header of one OpenEXR file, and its bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <vector>

#include <Imath/half.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>

#include "core/image.h"
#include "core/se3.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class ExrCompression { kNone, kZip, kPiz };

/// Linear light of the 256 codes of sRGB.
const std::array<float, 256>& linear_codes();

/// The bytes of what `write` writes into a stream of this name.
std::vector<std::byte> bytes_written(const std::string& name, const std::function<void(Imf::OStream&)>& write);

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
  /// A file with a part for each picture, called and marked as the view that it is. Throws Error(kUsage) if they have
  /// different sizes.
  static std::vector<std::byte> bytes_of_views(std::vector<ExrPicture>& pictures, const std::vector<std::string>& views,
                                               const std::string& name);

private:
  void add_slice(const char* name, Imf::PixelType type, char* values, std::size_t size);

  Imf::Header header_;
  Imf::FrameBuffer slices_;
  std::list<std::vector<half>> halves_;
  std::list<std::vector<float>> floats_;
  std::list<std::vector<std::uint32_t>> numbers_;
};

} // namespace kinora::formats
