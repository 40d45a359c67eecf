// Small pictures for tests, and a JPEG of one, which the library itself never writes.
#pragma once

#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>

#include "core/image.h"
#include "core/image_codec.h"
#include "core/random.h"

namespace kinora::test {

/// Smooth colours with a little noise, different for each seed.
inline ColorImage sample_color(int width, int height, int channels = 3, std::uint64_t seed = 1) {
  ColorImage image(width, height, channels);
  Random random(seed);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      for (int c = 0; c < channels; ++c)
        image.at(u, v, c) = static_cast<std::uint8_t>((u * (3 + c) + v * (7 - c) + random.below(8)) & 0xFF);
  return image;
}

/// A slope from 1 m on, in millimetres, with one hole.
inline DepthImage16 sample_depth(int width, int height, std::uint16_t start = 1000) {
  DepthImage16 image(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) image.at(u, v) = static_cast<std::uint16_t>(start + u + 2 * v);
  image.at(0, 0) = 0;
  return image;
}

/// Quality 95, without subsampling.
inline Bytes jpeg_of(const ColorImage& image, bool progressive = false) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &buffer, &size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width());
  jpeg.image_height = static_cast<JDIMENSION>(image.height());
  jpeg.input_components = image.channels();
  jpeg.in_color_space = image.channels() == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  for (int c = 0; c < jpeg.num_components; ++c) jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
  if (progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  for (int v = 0; v < image.height(); ++v) {
    std::vector<std::uint8_t> row(image.pixel(0, v), image.pixel(0, v) + image.width() * image.channels());
    JSAMPROW rows[1] = {row.data()};
    jpeg_write_scanlines(&jpeg, rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  const auto* begin = reinterpret_cast<const std::byte*>(buffer);
  Bytes bytes(begin, begin + size);
  jpeg_destroy_compress(&jpeg);
  std::free(buffer); // NOLINT: libjpeg's memory
  return bytes;
}

} // namespace kinora::test
