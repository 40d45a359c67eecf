// Packs a depth image with ROS's own encoder, as compressed_depth_image_transport sends it after the 12 bytes of its
// header: image_transport.rvl beside this file was made so, with rvl_codec.cpp of
// https://github.com/ros-perception/image_transport_plugins (BSD; it is not part of this repository).
// usage: make_rvl FILE
#include <compressed_depth_image_transport/rvl_codec.h>

#include <cstdint>
#include <fstream>
#include <vector>

#include "formats/oni_samples/pattern.h"

int main(int count, char** words) {
  using namespace kinora::test::oni;
  if (count != 2) return 2;
  std::vector<unsigned short> depth;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) depth.push_back(depth_at(u, v, 3));
  std::vector<unsigned char> packed(4 * depth.size());
  compressed_depth_image_transport::RvlCodec codec;
  const int bytes = codec.CompressRVL(depth.data(), packed.data(), static_cast<int>(depth.size()));
  std::ofstream file(words[1], std::ios::binary);
  const std::uint32_t size[] = {kWidth, kHeight};
  file.write(reinterpret_cast<const char*>(size), sizeof size);
  file.write(reinterpret_cast<const char*>(packed.data()), bytes);
  return file.good() ? 0 : 1;
}
