// Pictures and films that kinora render leaves behind.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "clip/sample_clip.h"
#include "core/image_codec.h"
#include "fields/scenes/painted_field.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

class Render : public testing::Test {
protected:
  Render() { clip::write_clip(clip::testing::sample_clip(1, 5, true), path("clip.mkv")); }
  Said render(std::vector<std::string> words) const {
    words.insert(words.begin(), {"render", path("clip.mkv")});
    return run_kinora(folder_, words);
  }
  // Instead of the clip, one of two frames in which the capture camera sees a ball of 0.3 m, 1.2 m before it; in the
  // second it is so much further to the right.
  void show_ball(double metres = 0) const {
    clip::Clip clip = clip::testing::sample_clip(1, 2, false);
    clip.layers.resize(1);
    clip.layers[0].field = fields::testing::painted_field({{-0.5, -0.5, -0.5}, 1}, fields::testing::PaintedBall{});
    if (metres > 0) clip.layers[0].motion = motion::Motion::rigid({{}, {SE3(Eigen::Translation3d(metres, 0, 0))}});
    // As if cameras had stood on the capture camera's side alone.
    clip.layers[0].confidence.emplace(clip.layers[0].field.occupancy);
    for (auto& levels : clip.layers[0].confidence->levels()) {
      for (std::size_t n = 0; n < levels.size(); ++n) {
        if (fields::Confidence::normal(n).z() < -0.5F) levels[n] = fields::Confidence::kMax;
      }
    }
    clip.camera_to_world = {SE3(Eigen::Translation3d(0, 0, -1.2))};
    fs::remove(path("clip.mkv"));
    const auto levels = static_cast<std::size_t>(clip.layers[0].field.config.levels);
    constexpr clip::Rounding kFine{16}; // what is painted into few parameters would be lost among them
    clip::write_clip(clip, path("clip.mkv"), {{clip::FieldRounding(levels, kFine)}});
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  ColorImage picture(const std::string& name) const {
    const std::string bytes = contents_of(path(name));
    return decode_color(std::as_bytes(std::span(bytes)), name);
  }
  std::vector<std::string> names_in(const std::string& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(path(folder))) {
      if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(path(folder)).string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryFolder folder_;
};

TEST_F(Render, StillIsOnePictureOfTheAskedSize) {
  const Said said = render({path("o.png"), "--size", "32x24", "--orbit", "20", "--frames", "2:4"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(picture("o.png").width(), 32);
  EXPECT_EQ(picture("o.png").height(), 24);
  EXPECT_FALSE(fs::exists(path("o.png.part")));
  EXPECT_FALSE(fs::exists(path("o.png.parts")));
}

TEST_F(Render, DepthStandsBesideTheStill) {
  ASSERT_EQ(render({path("o.png"), "--size", "32x24", "--passes", "rgb,depth"}).code, 0);
  const std::string bytes = contents_of(path("o.depth.png"));
  EXPECT_EQ(decode_depth16(std::as_bytes(std::span(bytes)), "o.depth.png").width(), 32);
}

// As colours: red to the right, green up, blue towards the camera.
TEST_F(Render, NormalsStandBesideTheStillAsColours) {
  show_ball();
  ASSERT_EQ(render({path("o.png"), "--size", "64x48", "--passes", "rgb,normal"}).code, 0);
  EXPECT_FALSE(fs::exists(path("o.depth.png")));
  const ColorImage normals = picture("o.normal.png");
  ASSERT_EQ(normals.width(), 64);
  int seen = 0;
  for (std::size_t i = 0; i < normals.pixel_count(); ++i) {
    const std::uint8_t* n = normals.data() + 3 * i;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
    ++seen;
    EXPECT_NEAR(std::hypot(n[0] - 127.5, n[1] - 127.5, n[2] - 127.5), 127.5, 1.5);
  }
  EXPECT_GT(seen, 100);
  EXPECT_GT(normals.at(32, 24, 2), 250);
}

TEST_F(Render, TheSideThatNoCameraSawHasNoConfidenceAndFades) {
  show_ball();
  ASSERT_EQ(render({path("o.png"), "--size", "64x48", "--passes", "rgb,confidence"}).code, 0);
  folder_.write("behind.json", R"({"w": 64, "h": 48, "fl_x": 52, "frames": [{"file_path": "b", "time": 0,
    "transform_matrix": [[-1,0,0,0],[0,-1,0,0],[0,0,1,1.2],[0,0,0,1]]}]})");
  ASSERT_EQ(render({path("b.png"), "--cameras", path("behind.json"), "--passes", "rgb,confidence"}).code, 0);
  const auto confidence = [this](const std::string& name) {
    const std::string bytes = contents_of(path(name));
    return decode_labels(std::as_bytes(std::span(bytes)), name); // one channel of 8 bits
  };
  EXPECT_GT(confidence("o.confidence.png").at(32, 24), 250);
  EXPECT_GT(picture("b.png").at(32, 24, 2), 200); // the ball's far side is blue
  EXPECT_EQ(confidence("b.confidence.png").at(32, 24), 0);
  ASSERT_EQ(render({path("f.png"), "--cameras", path("behind.json"), "--unseen", "fade"}).code, 0);
  EXPECT_EQ(picture("f.png").at(32, 24, 2), 0);
}

TEST_F(Render, ConfidenceOfAClipThatDoesNotHoldItIsAnError) {
  expect_error(render({path("o.png"), "--size", "8x8", "--passes", "rgb,confidence"}), 1, "object");
  expect_error(render({path("o.png"), "--size", "8x8", "--unseen", "fade"}), 1, "object");
  EXPECT_FALSE(fs::exists(path("o.png")));
  EXPECT_EQ(render({path("o.png"), "--size", "8x8", "--passes", "rgb,confidence", "--layers", "background"}).code, 0);
}

TEST_F(Render, FolderHoldsAPictureForEachFrame) {
  ASSERT_EQ(render({path("out"), "--size", "32x24", "--frames", "::2", "--passes", "rgb,depth"}).code, 0);
  EXPECT_EQ(names_in("out"), (std::vector<std::string>{"000000.depth.png", "000000.png", "000002.depth.png",
                                                       "000002.png", "000004.depth.png", "000004.png"}));
}

TEST_F(Render, EachPictureShowsItsFrame) {
  show_ball(0.2);
  ASSERT_EQ(render({path("all"), "--size", "64x48", "--capture-view"}).code, 0);
  const auto middle_of_ball = [&](const std::string& name) {
    const ColorImage shown = picture(name);
    double sum = 0, weight = 0;
    for (int v = 0; v < shown.height(); ++v) {
      for (int u = 0; u < shown.width(); ++u) {
        const double light = shown.at(u, v, 0) + shown.at(u, v, 1) + shown.at(u, v, 2);
        sum += u * light;
        weight += light;
      }
    }
    return sum / weight;
  };
  const std::vector<std::string> names = names_in("all");
  ASSERT_EQ(names.size(), 2U);
  EXPECT_GT(middle_of_ball("all/" + names[1]), middle_of_ball("all/" + names[0]) + 3);
  ASSERT_EQ(render({path("second.png"), "--size", "64x48", "--capture-view", "--frames", "1"}).code, 0);
  EXPECT_TRUE(std::ranges::equal(picture("second.png").values(), picture("all/" + names[1]).values()));
}

TEST_F(Render, CameraFileNamesThePictures) {
  folder_.write("t.json", R"({"w": 20, "h": 10, "fl_x": 20, "frames": [
    {"file_path": "a/left", "time": 0, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
    {"file_path": "right", "frame": 3, "transform_matrix": [[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  const Said said = render({path("out"), "--cameras", path("t.json"), "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(names_in("out"), (std::vector<std::string>{"a/left.png", "right.png"}));
  EXPECT_EQ(picture("out/a/left.png").width(), 20);
  EXPECT_EQ(Json::parse(said.out).at("pictures"), 2);
}

TEST_F(Render, ViewsAreInOrderOfTimeAndThoseOfOneTimeInOneFileIfAskedFor) {
  folder_.write("t.json", R"({"w": 20, "h": 10, "fl_x": 20, "frames": [
    {"file_path": "left 0", "frame": 0, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
    {"file_path": "left 3", "frame": 3, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
    {"file_path": "right 0", "frame": 0, "transform_matrix": [[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  const Said said = render(
      {path("out"), "--cameras", path("t.json"), "-O", "format=exr", "-O", "views=parts", "--passes", "rgb,deep"});
  if (said.code == 6) GTEST_SKIP() << "OpenEXR is not installed";
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(names_in("out"), (std::vector<std::string>{"000000.exr", "000001.exr", "left 0.deep.exr", "left 3.deep.exr",
                                                       "right 0.deep.exr"}));
  ASSERT_EQ(render({path("set"), "--cameras", path("t.json"), "-O", "format=data-set"}).code, 0);
  std::ifstream file(path("set/transforms.json"));
  const Json frames = Json::parse(file)["frames"];
  EXPECT_EQ(frames[1]["file_path"], "images/right 0.png");
  EXPECT_EQ(frames[1]["time"], 0) << "of one time with the first";
  EXPECT_GT(frames[2]["time"], 0);
  expect_error(render({path("o.png"), "--size", "8x8", "--passes", "rgb,deep"}), 2, "deep");
}

TEST_F(Render, FilmIsAFilm) {
  const Said said = render({path("o.mp4"), "--size", "64x48", "--orbit", "10"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(contents_of(path("o.mp4")).substr(4, 4), "ftyp");
  EXPECT_FALSE(fs::exists(path("o.mp4.part")));
}

TEST_F(Render, AFilmGoesOnWithThePicturesOfARunThatEndedEarly) {
  const std::vector<std::string> words{path("o.mp4"), "--orbit", "10", "--size", "320x240", "--resume"};
  ASSERT_EQ(render({path("whole.mp4"), "--orbit", "10", "--size", "320x240"}).code, 0);
  std::vector<std::string> all{"render", path("clip.mkv")};
  all.insert(all.end(), words.begin(), words.end());
  for (const bool exchanged : {false, true}) {
    Running running(folder_.path(), all);
    while (!fs::exists(path("o.mp4.drawn")) || names_in("o.mp4.drawn").size() < 3) usleep(1000);
    running.kill_at_once();
    running.finish();
    EXPECT_FALSE(fs::exists(path("o.mp4")));
    const std::vector<std::string> kept = names_in("o.mp4.drawn");
    const std::string first = contents_of(path("o.mp4.drawn/" + kept[0]));
    // Half a picture is drawn again; a whole one is taken for what it is called.
    folder_.write("o.mp4.drawn/" + kept[1], exchanged ? first : first.substr(0, first.size() / 2));
    ASSERT_EQ(render(words).code, 0);
    EXPECT_EQ(contents_of(path("o.mp4")) == contents_of(path("whole.mp4")), !exchanged);
    EXPECT_FALSE(fs::exists(path("o.mp4.drawn")));
    fs::remove(path("o.mp4"));
  }
}

TEST_F(Render, AFilmTakesPicturesThatWereDrawnOtherwiseFromNoRun) {
  Running running(folder_.path(), {"render", path("clip.mkv"), path("o.mp4"), "--size", "320x240", "--resume"});
  while (!fs::exists(path("o.mp4.drawn")) || names_in("o.mp4.drawn").size() < 2) usleep(1000);
  running.kill_at_once();
  running.finish();
  folder_.write("o.mp4.drawn/mine", "mine");
  const std::vector<std::string> otherwise{"--size", "320x240", "--quality", "fast"};
  std::vector<std::string> words{path("o.mp4"), "--resume"};
  words.insert(words.end(), otherwise.begin(), otherwise.end());
  ASSERT_EQ(render(words).code, 0);
  words[0] = path("whole.mp4");
  words.erase(words.begin() + 1);
  ASSERT_EQ(render(words).code, 0);
  EXPECT_EQ(contents_of(path("o.mp4")), contents_of(path("whole.mp4")));
  EXPECT_EQ(contents_of(path("o.mp4.drawn/mine")), "mine");
}

TEST_F(Render, LayersThatAreNotThereAreWarnedOfAndDrawNothing) {
  const Said said = render({path("o.png"), "--size", "32x24", "--layers", "person,spirit"});
  EXPECT_EQ(said.code, 0);
  EXPECT_NE(said.err.find("\"person\""), std::string::npos);
  EXPECT_NE(said.err.find("\"spirit\""), std::string::npos);
}

TEST_F(Render, ExistingPicturesStayUnlessOverwritten) {
  folder_.write("out/000003.png", "mine");
  expect_error(render({path("out"), "--size", "8x8"}), 5, "000003.png");
  EXPECT_EQ(contents_of(path("out/000003.png")), "mine");
  EXPECT_EQ(names_in("out").size(), 1U);
  EXPECT_EQ(render({path("out"), "--size", "8x8", "--overwrite"}).code, 0);
  EXPECT_NE(contents_of(path("out/000003.png")), "mine");
}

TEST_F(Render, WordsThatMakeNoSenseAreUsageErrors) {
  expect_error(render({path("o.png"), "--size", "big"}), 2, "big");
  expect_error(render({path("o.png"), "--size", "0x5"}), 2, "0x5");
  expect_error(render({path("o.png"), "--passes", "rgb,heat"}), 2, "heat");
  expect_error(render({path("o.png"), "--passes", "depth"}), 2, "rgb");
  expect_error(render({path("o.mp4"), "--passes", "rgb,depth"}), 2, "film");
  expect_error(render({path("o.mp4"), "--passes", "rgb,normal"}), 2, "normal");
  expect_error(render({path("o.avi")}), 2, ".avi");
  expect_error(render({path("o.png"), "--frames", "9:12"}), 2, "9:12");
  expect_error(render({path("o.png"), "--orbit", "3", "--capture-view"}), 2, "--help");
  expect_error(render({path("o.png"), "--cameras", path("none.json")}), 2, "none.json");
  expect_error(render({path("out"), "-O", "format=gold"}), 2, "gold");
  EXPECT_FALSE(fs::exists(path("o.png")));
}

TEST_F(Render, SamePictureForOneThreadAndTwo) {
  ASSERT_EQ(render({path("a.png"), "--size", "96x72", "--threads", "1"}).code, 0);
  ASSERT_EQ(render({path("b.png"), "--size", "96x72", "--threads", "2"}).code, 0);
  EXPECT_EQ(contents_of(path("a.png")), contents_of(path("b.png")));
}

} // namespace
} // namespace kinora::test
