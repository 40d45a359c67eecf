// Every reader of captures against files that are spoilt: cut at each tenth, overwritten, with files missing, with
// times that run backwards.
#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "formats/damage.h"
#include "formats/sample_readers.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

class BadInput : public testing::TestWithParam<SampleReader> {
protected:
  void SetUp() override {
    fs::create_directories(in());
    if (!GetParam().make(folder_)) GTEST_SKIP() << "ffmpeg is not installed";
    frames_ = read_capture(input(), GetParam().format).frames.size();
    ASSERT_GT(frames_, 0U);
  }
  fs::path in() const { return folder_.path() / "in"; }
  fs::path input() const { return *GetParam().input == '\0' ? in() : in() / GetParam().input; }

  /// Refused in one sentence that names it, or read as far as it goes, in order of time.
  void expect_borne(const std::string& what) {
    try {
      const CopiedCapture capture = read_capture(input(), GetParam().format);
      EXPECT_LE(capture.frames.size(), frames_ + 1) << what;
      double last = -std::numeric_limits<double>::infinity();
      for (const CopiedFrame& frame : capture.frames) {
        if (!frame.problem.empty()) continue;
        EXPECT_FALSE(frame.depth.empty()) << what;
        EXPECT_GE(frame.time, last) << what;
        last = frame.time;
      }
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << what << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  void spoil(const std::string& file, const std::string& bytes) const {
    std::ofstream(in() / file, std::ios::binary | std::ios::trunc) << bytes;
  }

  TemporaryFolder folder_;
  std::size_t frames_ = 0;
};

TEST_P(BadInput, IsBorneWhenCutAtEachTenth) {
  for (const std::string& file : GetParam().spoilt)
    expect_bears_truncation(in() / file, input(), GetParam().format, frames_);
}

TEST_P(BadInput, AnotherMagicIsNotTakenForAWholeFile) {
  for (const std::string& file : GetParam().spoilt) {
    const std::string whole = contents(in() / file);
    std::string bytes = whole;
    std::fill_n(bytes.begin(), std::min<std::size_t>(bytes.size(), 16), 'X');
    spoil(file, bytes);
    expect_borne(file);
    if (in() / file == input() && in() / file != in() / "sample.r3d") { // a ZIP archive is told by its end
      EXPECT_THROW((void)read_capture(input()), Error) << "nobody takes it for a capture";
    }
    spoil(file, whole);
  }
}

/// Wherever a size may stand, it is absurd once.
TEST_P(BadInput, AbsurdSizesAreBorne) {
  constexpr std::size_t kPlaces = 32;
  for (const std::string& file : GetParam().spoilt) {
    const std::string whole = contents(in() / file);
    for (std::size_t k = 0; k < kPlaces; ++k) {
      for (const char value : {'\xFF', '\x7F'}) {
        std::string bytes = whole;
        const std::size_t at = k < kPlaces / 2 ? 4 * k : whole.size() * k / kPlaces; // heads are thick with sizes
        for (std::size_t i = at; i < std::min(at + 4, bytes.size()); ++i) bytes[i] = value;
        spoil(file, bytes);
        expect_borne(file + " at " + std::to_string(at));
      }
    }
    spoil(file, whole);
  }
}

/// The same in text: each number is once the largest that many programs hold, and once beyond all of them.
TEST_P(BadInput, AbsurdNumbersInTextAreBorne) {
  constexpr std::size_t kNumbers = 48;
  constexpr std::string_view kDigits = "0123456789";
  for (const std::string& file : GetParam().spoilt) {
    const std::string whole = contents(in() / file);
    if (whole.find('\0') != std::string::npos) continue; // no text
    std::size_t begin = 0;
    for (std::size_t k = 0; k < kNumbers; ++k) {
      begin = whole.find_first_of(kDigits, begin);
      if (begin == std::string::npos) break;
      const std::size_t end = std::min(whole.find_first_not_of(kDigits, begin), whole.size());
      for (const char* number : {"2147483647", "-99999999999999999999999"}) {
        spoil(file, whole.substr(0, begin) + number + whole.substr(end));
        expect_borne(file + " at " + std::to_string(begin));
      }
      begin = end;
    }
    spoil(file, whole);
  }
}

INSTANTIATE_TEST_SUITE_P(All, BadInput, testing::ValuesIn(sample_readers()), name_of);

// ---- a frame that is missing

class MissingFrame : public BadInput {};

TEST_P(MissingFrame, IsAllThatIsMissing) {
  if (GetParam().lose_frame != nullptr)
    ASSERT_TRUE(GetParam().lose_frame(folder_));
  else
    ASSERT_TRUE(fs::remove(in() / GetParam().removed));
  const CopiedCapture capture = read_capture(input(), GetParam().format);
  const auto whole =
      std::ranges::count_if(capture.frames, [](const CopiedFrame& frame) { return frame.problem.empty(); });
  EXPECT_EQ(static_cast<std::size_t>(whole), frames_ - 1);
}

bool can_lose_a_frame(const SampleReader& reader) { return !reader.removed.empty() || reader.lose_frame != nullptr; }

std::vector<SampleReader> readers_of_frames() {
  std::vector<SampleReader> readers = sample_readers();
  std::erase_if(readers, std::not_fn(can_lose_a_frame));
  return readers;
}
INSTANTIATE_TEST_SUITE_P(All, MissingFrame, testing::ValuesIn(readers_of_frames()), name_of);

/// Formats whose frames are drawn when they are asked for.
constexpr std::string_view kWithoutFrames[] = {"kinora-clip", "gltf-scene"};

// ---- times that run backwards

class BackwardTimes : public BadInput {};

/// Frames come in order of time; that they did not stand so is said, or why the file or a frame of it is refused.
TEST_P(BackwardTimes, AreReadInOrderOrRefusedAndSaid) {
  ASSERT_TRUE(GetParam().turn_back(folder_));
  std::vector<std::string> said;
  try {
    const CopiedCapture capture = read_capture(input(), GetParam().format);
    said = capture.warnings;
    EXPECT_EQ(capture.frames.size(), frames_);
    double last = -std::numeric_limits<double>::infinity();
    for (const CopiedFrame& frame : capture.frames) {
      if (!frame.problem.empty()) {
        said.push_back(frame.problem);
        continue;
      }
      EXPECT_GE(frame.time, last);
      last = frame.time;
    }
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << error.what();
    said.emplace_back(error.what());
  }
  const auto about_time = [](const std::string& sentence) {
    return sentence.find("out of order") != std::string::npos || sentence.find("do not increase") != std::string::npos;
  };
  EXPECT_TRUE(std::ranges::any_of(said, about_time)) << testing::PrintToString(said);
}

std::vector<SampleReader> readers_with_times() {
  std::vector<SampleReader> readers = sample_readers();
  std::erase_if(readers, [](const SampleReader& reader) { return reader.turn_back == nullptr; });
  return readers;
}
INSTANTIATE_TEST_SUITE_P(All, BackwardTimes, testing::ValuesIn(readers_with_times()), name_of);

/// Formats that number their frames and keep no times, and clips, which are not written unless times increase.
constexpr std::string_view kWithoutTimes[] = {"numbered-folder", "3dmatch", "m3t", "kinora-clip"};

// ---- the table

template <class Has> bool is_any(const char* format, const Has& has) {
  return std::ranges::any_of(sample_readers(), [&](const SampleReader& reader) {
    return std::string_view(reader.format) == format && has(reader);
  });
}
template <class List> bool is_among(const List& list, const char* format) {
  return std::ranges::find(list, format) != std::end(list);
}

TEST(BadInputTable, HasEveryReader) {
  for (const host::FormatEntry& entry : sample_plugins().formats()) {
    const char* const name = entry.format->name;
    if (!host::supports(*entry.format, KINORA_READS_FRAMES) || host::supports(*entry.format, KINORA_READS_DEVICE))
      continue;
    EXPECT_TRUE(is_any(name, [](const SampleReader&) { return true; })) << name;
    EXPECT_NE(is_any(name, can_lose_a_frame), is_among(kWithoutFrames, name)) << name;
    EXPECT_NE(is_any(name, [](const SampleReader& reader) { return reader.turn_back != nullptr; }),
              is_among(kWithoutTimes, name))
        << name;
  }
}

} // namespace
} // namespace kinora::formats
