// Files that are spoilt in the ways that every reader must bear.
#pragma once

#include <filesystem>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/capture_frames.h"
#include "formats/sample_capture.h"

namespace kinora::test {

/// `file`, cut at each tenth of its length, is refused in one clear sentence or read as far as it goes: no more frames
/// than `frames`, and every frame whole or with a problem. `capture` is what is opened: the file, or a folder around
/// it.
inline void expect_bears_truncation(const fs::path& file, const fs::path& capture, const std::string& format,
                                    std::size_t frames) {
  const std::string whole = [&] {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  for (std::size_t tenth = 0; tenth < 10; ++tenth) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << whole.substr(0, whole.size() * tenth / 10);
    try {
      EXPECT_LE(read_capture(capture, format).frames.size(), frames) << tenth;
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << tenth << ": " << error.what();
      EXPECT_NE(std::string(error.what()).find(capture.filename().string()), std::string::npos) << error.what();
    }
  }
  std::ofstream(file, std::ios::binary | std::ios::trunc) << whole;
}

} // namespace kinora::test
