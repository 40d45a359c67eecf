#include "clip/clip_description.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace kinora::clip {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

std::string text_of(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

const std::string kGood = R"({"version": 1, "times_ns": [0, 5, 9], "capture_frames": [0, 2, 4], "held_out": [1],
  "camera": {"track": 1, "moves": false},
  "layers": [{"name": "background", "label": 0, "kind": "still", "field_track": 2},
             {"name": "object", "label": 2, "kind": "rigid", "field_track": 3, "motion_track": 4}]})";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kGood;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_code(const std::string& text, ErrorCode code) {
  try {
    parse_clip_description(bytes_of(text), "a.mkv: clip.json");
    FAIL() << "parsed without an error: " << text;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_EQ(std::string(error.what()).rfind("a.mkv: clip.json", 0), 0U) << error.what();
  }
}

TEST(ClipDescription, IsReadAsItIsWritten) {
  const ClipDescription clip = parse_clip_description(bytes_of(kGood), "a.mkv: clip.json");
  EXPECT_EQ(clip.times_ns, (std::vector<std::int64_t>{0, 5, 9}));
  EXPECT_EQ(clip.capture_frames, (std::vector<int>{0, 2, 4}));
  EXPECT_EQ(clip.held_out, (std::vector<bool>{false, true, false}));
  EXPECT_EQ(clip.camera_track, 1);
  ASSERT_EQ(clip.layers.size(), 2U);
  EXPECT_EQ(clip.layers[1].name, "object");
  EXPECT_EQ(clip.layers[1].label, 2);
  EXPECT_EQ(clip.layers[1].kind, motion::MotionKind::kRigid);
  EXPECT_EQ(clip.layers[1].motion_track, 4);
  const ClipDescription deforming = parse_clip_description(bytes_of(changed("rigid", "deforming")), "a.mkv: clip.json");
  EXPECT_EQ(deforming.layers[1].kind, motion::MotionKind::kDeforming);
  EXPECT_EQ(deforming.layers[1].motion_track, 4);
  EXPECT_EQ(deforming.layers[1].joints_track, 0);
  EXPECT_EQ(text_of(to_json(clip)), text_of(to_json(parse_clip_description(to_json(clip), "again"))));
}

TEST(ClipDescription, SaysWhenALayerIsAwayAndNothingOfOneThatIsAlwaysThere) {
  const std::string stated = changed("\"label\": 2", "\"label\": 2, \"away\": [[0, 1], [2, 3]]");
  const ClipDescription clip = parse_clip_description(bytes_of(stated), "a.mkv: clip.json");
  EXPECT_TRUE(clip.layers[0].presence.is_always());
  EXPECT_EQ(clip.layers[1].presence.away(), (std::vector<motion::FrameSpan>{{0, 1}, {2, 3}}));
  const std::string written = text_of(to_json(clip));
  EXPECT_NE(written.find("\"away\":[[0,1],[2,3]]"), std::string::npos) << written;
  EXPECT_EQ(text_of(to_json(parse_clip_description(bytes_of(kGood), "a"))).find("away"), std::string::npos);
}

TEST(ClipDescription, RejectsWhatDoesNotFitTogether) {
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"[0, 5, 9]", "[0, 5, 5]"},
           {"[0, 5, 9]", "[-1, 5, 9]"},
           {"[0, 5, 9]", "[0, 5, 9.5]"},
           {"[0, 5, 9]", "[0, 5, 99999999999999999999]"},
           {"[0, 5, 9]", "[]"},
           {"[0, 5, 9]", "7"},
           {"[0, 2, 4]", "[0, 2]"},
           {"[0, 2, 4]", "[0, 2, 4294967296]"},
           {"[1]", "[3]"},
           {"[1]", "[-1]"},
           {"\"track\": 1", "\"track\": 70000"},
           {"\"track\": 1", "\"track\": 2"},
           {"\"moves\": false", "\"moves\": 0"},
           {"\"background\"", "\"object\""},
           {"\"background\"", "\"\""},
           {"\"background\"", "5"},
           {"\"still\"", "\"boiling\""},
           {", \"motion_track\": 4", ""},
           {"\"motion_track\": 4", "\"motion_track\": 4, \"joints_track\": 5"},
           {"\"motion_track\": 4", "\"motion_track\": 4, \"births_track\": 5"},
           {"\"label\": 2", "\"label\": 2, \"away\": 5"},
           {"\"label\": 2", "\"label\": 2, \"away\": [1, 2]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[1]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[-1, 1]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[0, 4]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[1, 1]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[0, 1], [1, 2]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[2, 3], [0, 1]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[0, 1.5]]"},
           {"\"label\": 2", "\"label\": 2, \"away\": [[0, 99999999999999999999]]"},
           {"\"version\": 1, ", ""},
           {"{\"version\": 1", "[{\"version\": 1"}}) {
    expect_code(changed(from, to), ErrorCode::kCorruptInput);
  }
}

TEST(ClipDescription, PassesOverMembersThatItDoesNotKnow) {
  const ClipDescription known = parse_clip_description(bytes_of(kGood), "a.mkv: clip.json");
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"{\"version\": 1", "{\"weather\": {\"wind\": [3, null]}, \"version\": 1"},
           {"\"moves\": false", "\"moves\": false, \"lens\": \"wide\""},
           {"\"kind\": \"rigid\"", "\"kind\": \"rigid\", \"weight\": 2.5"}}) {
    const ClipDescription clip = parse_clip_description(bytes_of(changed(from, to)), "a.mkv: clip.json");
    EXPECT_EQ(text_of(to_json(clip)), text_of(to_json(known))) << to;
  }
}

TEST(ClipDescription, SaysThatAFileOfALaterVersionNeedsANewerKinora) {
  expect_code(changed("\"version\": 1", "\"version\": 2"), ErrorCode::kNotRecognised);
}

TEST(ClipDescription, RejectsEveryCutText) {
  for (std::size_t size = 0; size < kGood.size(); ++size) expect_code(kGood.substr(0, size), ErrorCode::kCorruptInput);
}

TEST(ClipDescription, RejectsNestingThatWouldExhaustTheStack) {
  EXPECT_THROW(parse_json(bytes_of(std::string(1'000'000, '[')), "a.mkv"), Error);
  std::string nested;
  for (int i = 0; i < 100'000; ++i) nested += "{\"a\":";
  EXPECT_THROW(parse_json(bytes_of(nested), "a.mkv"), Error);
}

TEST(ClipDescription, KeepsIntrinsicsToTheLastBit) {
  const Intrinsics intrinsics{640, 480, 525.1 / 3, 1e3 / 7, 319.123456789012345, 0.1};
  EXPECT_EQ(parse_intrinsics(to_json(intrinsics), "a.mkv"), intrinsics);
}

TEST(ClipDescription, RejectsAbsurdIntrinsics) {
  EXPECT_THROW(parse_intrinsics(to_json(Intrinsics{640, 480, -5, 500, 320, 240}), "a.mkv"), Error);
  EXPECT_THROW(parse_intrinsics(to_json(Intrinsics{640, 480, std::nan(""), 500, 320, 240}), "a.mkv"), Error);
  EXPECT_THROW(parse_intrinsics(to_json(Intrinsics{1 << 30, 480, 500, 500, 320, 240}), "a.mkv"), Error);
}

TEST(ClipDescription, ReplacesTextThatIsNotUtf8) {
  const nlohmann::json metadata = {{"name", "a\xFF"}};
  EXPECT_EQ(parse_json(to_json(metadata), "a.mkv")["name"], "a\xEF\xBF\xBD");
}

} // namespace
} // namespace kinora::clip
