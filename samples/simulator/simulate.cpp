// usage: simulate DATA OUT [NAME…]    Makes the samples anew in OUT. DATA holds body_cc0 and mocap_cmu.
#include <algorithm>
#include <exception>

#include <fmt/format.h>

#include "capture_folder.h"

int main(int count, char** arguments) {
  using namespace kinora::simulator;
  const std::vector<std::string> words(arguments + 1, arguments + count);
  if (words.size() < 2) {
    fmt::print(stderr, "usage: simulate DATA OUT [NAME...]\n");
    return 2;
  }
  try {
    for (const auto& make : sample_scenes()) {
      const Scene scene = make(words[0]);
      const std::string name(scene.parameters().name);
      if (words.size() > 2 && std::find(words.begin() + 2, words.end(), name) == words.end()) continue;
      fmt::print("{}\n", name);
      write_capture(scene, std::filesystem::path(words[1]) / name, scene.parameters().frames);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "simulate: {}\n", error.what());
    return 1;
  }
  return 0;
}
