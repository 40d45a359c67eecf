// Decodes the conformance corpus and compares the bits. usage: conformance FOLDER
#include <cstdio>
#include <exception>
#include <filesystem>

#include <fmt/format.h>

#include "clip/clip_io.h"
#include "conformance/expected.h"

int main(int count, char** words) {
  using namespace kinora; // NOLINT: a program of one function
  if (count != 2) return 2;
  try {
    bool same = true;
    for (const conformance::Expected& expected : conformance::kExpected) {
      const clip::Clip clip = clip::read_clip(std::filesystem::path(words[1]) / expected.file);
      same &= clip.layers.size() == expected.layers.size() && clip.times.size() == expected.frames;
      for (std::size_t i = 0; same && i < clip.layers.size(); ++i) {
        same = conformance::checksums(clip.layers[i]) == expected.layers[i];
      }
      fmt::print("{}: {}\n", expected.file, same ? "the same bits" : "other bits");
    }
    return same ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
