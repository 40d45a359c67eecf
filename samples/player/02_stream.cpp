// Fetches a clip's bytes itself, as from a network, and shows coarse pictures before the full one.
// usage: 02_stream CLIP.mkv
#include <cstdio>
#include <exception>
#include <fstream>

#include <kinora/player.hpp>

namespace {

// Here a file; elsewhere an archive, a database, a connection.
class Bytes final : public kinora::ClipSource {
public:
  explicit Bytes(const std::string& path) : path_(path), file_(path, std::ios::binary | std::ios::ate) {
    if (!file_) throw std::runtime_error(path + " cannot be opened");
    size_ = static_cast<std::uint64_t>(file_.tellg());
  }
  std::string name() const override { return path_; }
  std::uint64_t size() const override { return size_; }
  bool read(std::uint64_t offset, std::span<std::byte> out) noexcept override {
    try {
      file_.seekg(static_cast<std::streamoff>(offset));
      file_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
      fetched_ += out.size();
      return static_cast<bool>(file_);
    } catch (...) {
      return false;
    }
  }
  std::uint64_t fetched() const { return fetched_; }

private:
  std::string path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::uint64_t fetched_ = 0;
};

} // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: 02_stream CLIP.mkv\n");
    return 2;
  }
  try {
    Bytes bytes(words[1]);
    const auto clip = kinora::ClipPlayer::open(bytes);
    std::printf("opened with %llu bytes fetched\n", static_cast<unsigned long long>(bytes.fetched()));
    int pictures = 0;
    // Called with each picture; a viewer would show it, and return false when the camera has moved on.
    const auto refined = [&](const kinora::ClipPicture& picture, bool finest) {
      std::printf("picture %d of %dx%d%s\n", ++pictures, picture.width, picture.height, finest ? ": full" : "");
      return true;
    };
    clip.render(clip.capture_camera(0), 0, KINORA_PLAYER_COLOR, refined);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
