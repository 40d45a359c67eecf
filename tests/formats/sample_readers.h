// A small capture of every format that is read: how it comes to be, and how it can be spoilt.
#pragma once

#include <string>
#include <vector>

#include "formats/sample_capture.h"
#include "host/plugin_table.h"

namespace kinora::formats {

struct SampleReader {
  const char* format;
  /// Makes the capture in `folder`/in; false: a program for it is not installed.
  bool (*make)(const test::TemporaryFolder& folder);
  const char* input;               ///< in the folder "in"; "": that folder
  std::vector<std::string> spoilt; ///< files of "in"
  std::string removed;             ///< of a capture in many files, one of its middle frame
  /// Lets the times of what `make` made run backwards; null: no file of the format can be made so. False as of `make`.
  bool (*turn_back)(const test::TemporaryFolder& folder);
  /// Of a capture in one file or in videos: takes its middle frame away. False as of `make`.
  bool (*lose_frame)(const test::TemporaryFolder& folder) = nullptr;
};

/// At least one of each format that reads captures from files.
const std::vector<SampleReader>& sample_readers();

std::ostream& operator<<(std::ostream& out, const SampleReader& reader);
/// For tests with one of them as parameter.
std::string name_of(const testing::TestParamInfo<SampleReader>& chosen);

inline constexpr int kSampleFrames = 3;

const host::PluginTable& sample_plugins();

std::string contents(const test::fs::path& path);

} // namespace kinora::formats
