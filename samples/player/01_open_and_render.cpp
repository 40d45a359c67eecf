// Opens a clip and draws its middle from where it was captured.
// usage: 01_open_and_render CLIP.mkv PICTURE.pam
#include <cstdio>
#include <exception>
#include <fstream>

#include <kinora/player.hpp>

namespace {

// PAM: the simplest format that keeps opacity. ffmpeg, GIMP and netpbm read it.
void write_pam(const kinora::ClipPicture& picture, const char* path) {
  std::ofstream file(path, std::ios::binary);
  file << "P7\nWIDTH " << picture.width << "\nHEIGHT " << picture.height
       << "\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n";
  file.write(reinterpret_cast<const char*>(picture.color.data()), static_cast<std::streamsize>(picture.color.size()));
  if (!file.flush()) throw std::runtime_error(std::string(path) + " cannot be written");
}

} // namespace

int main(int count, char** words) {
  if (count != 3) {
    std::fprintf(stderr, "usage: 01_open_and_render CLIP.mkv PICTURE.pam\n");
    return 2;
  }
  try {
    const auto clip = kinora::ClipPlayer::open(words[1]);
    const KinoraPlayerInfo info = clip.info();
    std::printf("%llu frames, %.2f s\n", static_cast<unsigned long long>(info.frames), info.duration);
    for (const KinoraPlayerLayer& layer : clip.layers()) std::printf("layer %s: %s\n", layer.name, layer.motion);
    const double middle = clip.frame_time(info.frames / 2);
    write_pam(clip.render(clip.capture_camera(middle), middle), words[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
