// Draws the middle of a clip from where it was captured. Built for this machine it keeps the picture, built for
// WebAssembly it compares its own with that.
// usage: clip_picture draw CLIP PICTURE | clip_picture compare CLIP PICTURE
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "clip/clip_io.h"
#include "core/error.h"
#include "core/metrics.h"
#include "player/player.h"

namespace kinora {
namespace {

// Not equal: vectors have another length here and no fused multiply-add, so that sums round differently, and a ray
// that ends a hair before a surface's rim there passes it here. 40 dB is a difference that nobody sees.
constexpr double kSamePicture = 40; // dB

ColorImage middle_of(const std::filesystem::path& clip) {
  const player::Player player(clip::read_clip(clip));
  const double frame = 0.5 * static_cast<double>(player.frame_count() - 1);
  return player.draw(player.clip().capture_camera(frame), frame, player.all_layers()).color;
}

void keep(const ColorImage& picture, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(picture.data()), static_cast<std::streamsize>(picture.values().size()));
  if (!file.flush()) throw Error(ErrorCode::kUnwritableOutput, fmt::format("{}: cannot be written", path.string()));
}

double psnr(const ColorImage& picture, const std::filesystem::path& expected) {
  std::ifstream file(expected, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.size() != picture.values().size()) {
    throw Error(ErrorCode::kFailure,
                fmt::format("{}: {} bytes instead of {}", expected.string(), bytes.size(), picture.values().size()));
  }
  double sum = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const int difference = picture.values()[i] - static_cast<std::uint8_t>(bytes[i]);
    sum += difference * difference;
  }
  return psnr_from_mse(sum / static_cast<double>(bytes.size()));
}

int run(const std::string& what, const std::filesystem::path& clip, const std::filesystem::path& picture) {
  if (what == "draw") {
    keep(middle_of(clip), picture);
    return 0;
  }
  const double similarity = psnr(middle_of(clip), picture);
  fmt::print("{:.2f} dB between this picture and {}; wanted: {} dB\n", similarity, picture.string(), kSamePicture);
  return similarity >= kSamePicture ? 0 : 1;
}

} // namespace
} // namespace kinora

int main(int count, char** words) {
  try {
    if (count == 4) return kinora::run(words[1], words[2], words[3]);
    fmt::print(stderr, "usage: clip_picture draw|compare CLIP PICTURE\n");
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
