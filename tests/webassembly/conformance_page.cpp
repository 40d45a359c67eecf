// Decodes files of the conformance corpus in a page (tests/page) and compares the bits.
#include <cstddef>
#include <exception>
#include <memory>
#include <span>
#include <string>

#include "clip/clip_io.h"
#include "conformance/expected.h"

namespace {

std::string said; // NOLINT: what went wrong last; a page has one thread

bool is_as_expected(const kinora::conformance::Expected& expected, const kinora::clip::Clip& clip) {
  if (clip.layers.size() != expected.layers.size() || clip.times.size() != expected.frames) return false;
  for (std::size_t i = 0; i < clip.layers.size(); ++i) {
    if (kinora::conformance::checksums(clip.layers[i]) != expected.layers[i]) return false;
  }
  return true;
}

} // namespace

extern "C" {

std::size_t conformance_files() { return kinora::conformance::kExpected.size(); }
const char* conformance_file(std::size_t i) { return kinora::conformance::kExpected.at(i).file; }

/// Empty: the bytes decode to the bits that are expected of the file.
const char* conformance_difference(std::size_t i, const std::byte* bytes, std::size_t size) {
  said.clear();
  try {
    auto source = std::make_unique<kinora::container::MemorySource>(std::span(bytes, size), conformance_file(i));
    if (!is_as_expected(kinora::conformance::kExpected.at(i), kinora::clip::read_clip(std::move(source)))) {
      said = "other bits";
    }
  } catch (const std::exception& error) {
    said = error.what();
  }
  return said.c_str();
}

} // extern "C"
