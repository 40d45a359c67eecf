// Shows a clip while it comes: over a slow connection, or while it is still being written; or what is left of a damaged
// one.
// usage: 04_follow CLIP.mkv
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <thread>

#include <kinora/player.hpp>

namespace {

// A file, as slow as a connection of 10 Mbit/s.
class SlowBytes final : public kinora::ClipSource {
public:
  explicit SlowBytes(const std::string& path) : path_(path), file_(path, std::ios::binary | std::ios::ate) {
    if (!file_) throw std::runtime_error(path + " cannot be opened");
    size_ = static_cast<std::uint64_t>(file_.tellg());
  }
  std::string name() const override { return path_; }
  std::uint64_t size() const override { return size_; }
  bool read(std::uint64_t offset, std::span<std::byte> out) noexcept override { // in a thread of the player's
    try {
      std::this_thread::sleep_for(std::chrono::microseconds(8 * out.size() / 10));
      file_.seekg(static_cast<std::streamoff>(offset));
      file_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
      return static_cast<bool>(file_);
    } catch (...) {
      return false;
    }
  }

private:
  std::string path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
};

void show(const kinora::ClipPlayer& clip) {
  const KinoraPlayerInfo info = clip.info();
  std::printf("%u layers, %llu frames\n", info.layers, static_cast<unsigned long long>(info.frames));
  KinoraPlayerCamera camera = clip.capture_camera(0);
  kinora_player_resize_camera(&camera, 160, 120);
  clip.render(camera, clip.time()); // here a viewer would show it
}

} // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: 04_follow CLIP.mkv\n");
    return 2;
  }
  try {
    SlowBytes bytes(words[1]); // must outlive the player
    auto clip = kinora::ClipPlayer::follow(bytes);
    show(clip);
    for (bool complete = false; !complete;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20)); // a viewer draws meanwhile
      const kinora::ClipArrival arrival = clip.update();
      complete = arrival.complete;
      if (arrival.more) show(clip);
      if (complete) std::printf("complete%s%s\n", arrival.message.empty() ? "" : ": ", arrival.message.c_str());
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
