// Where drawn pictures go, and what they must not replace.
#include "cli/picture_output.h"

#include <algorithm>

#include "cli/run_kinora.h"
#include "core/error.h"
#include "core/module.h"

namespace kinora::cli {
namespace {

using test::contents_of;
using test::names_in;
using Names = std::vector<std::string>;

class Pictures : public testing::Test {
protected:
  PictureRequest request(const std::string& name, bool overwrite, std::vector<std::string> passes = {}) const {
    return {path(name), {}, overwrite, std::move(passes), {}};
  }
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  Names names() const { return names_in(folder_.path()); }

  /// As it is drawn: with normals only if they are asked for.
  static fields::Picture picture_for(const PictureRequest& request) {
    fields::Picture picture;
    picture.color = ColorImage(4, 3, 4);
    picture.depth = DepthImage(4, 3);
    const Names& passes = request.passes;
    if (std::find(passes.begin(), passes.end(), "normal") != passes.end()) picture.normal = Image<float>(4, 3, 3);
    return picture;
  }
  void write(const PictureRequest& request, const Names& views) const {
    const auto output = PictureOutput::open(request, views, table_);
    double seconds = 0;
    for (const std::string& view : views) {
      DrawnPicture drawn{picture_for(request), view, seconds++, {}};
      if (std::ranges::find(request.passes, "deep") != request.passes.end())
        drawn.layers.push_back({picture_for(request), {1, "person", "deforming"}});
      output->add(drawn);
    }
    output->finish();
  }
  void expect_refused(const PictureRequest& request, const Names& views, const std::string& word) const {
    try {
      write(request, views);
      FAIL() << "it is not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUnwritableOutput);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }

  test::TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(Pictures, OfAFolderAreThereWithTheirPassesAndNothingElse) {
  write(request("out", false, {"depth"}), {"a/left", "right"});
  EXPECT_EQ(names(), (Names{"out/a/left.depth.png", "out/a/left.png", "out/right.depth.png", "out/right.png"}));
  EXPECT_FALSE(std::filesystem::exists(path("out/.part")));
}

TEST_F(Pictures, ThatHoldTheirPassesAreOneFileEach) {
  if (!std::filesystem::exists(module_path("exr"))) GTEST_SKIP() << "OpenEXR is not installed";
  PictureRequest wanted = request("out", false, {"depth", "normal"});
  wanted.options = {{"format", "exr"}};
  write(wanted, {"left", "right"});
  write(request("still.exr", false, {"depth"}), {"view"});
  wanted = request("deep", false, {"deep"});
  wanted.options = {{"format", "exr"}};
  write(wanted, {"left"});
  write(request("deep.exr", false, {"deep"}), {"view"});
  EXPECT_EQ(names(), (Names{"deep.deep.exr", "deep.exr", "deep/left.deep.exr", "deep/left.exr", "out/left.exr",
                            "out/right.exr", "still.exr"}));
}

TEST_F(Pictures, ForWhichTheFormatHasNoPlaceAreRefused) {
  PictureRequest wanted = request("out", false, {"normal"});
  wanted.options = {{"format", "data-set"}};
  EXPECT_THROW(write(wanted, {"left"}), Error);
  EXPECT_EQ(names(), Names{});
}

TEST_F(Pictures, ThatExistStayWithTheirPassesUnlessOverwritten) {
  for (const std::string name : {"out/b.png", "out/b.depth.png", "out/a.normal.png"}) {
    folder_.write(name, "mine");
    expect_refused(request("out", false, {"depth", "normal"}), {"a", "b"}, name);
    EXPECT_EQ(contents_of(path(name)), "mine");
    EXPECT_EQ(names(), Names{name}) << "it is told before anything is written";
    write(request("out", true, {"depth", "normal"}), {"a", "b"});
    EXPECT_NE(contents_of(path(name)), "mine");
    EXPECT_EQ(names().size(), 6U);
    folder_.remove("out");
  }
}

TEST_F(Pictures, BesideAStillStayUnlessOverwritten) {
  folder_.write("o.depth.png", "mine");
  expect_refused(request("o.png", false, {"depth"}), {"view"}, "o.depth.png");
  EXPECT_EQ(names(), Names{"o.depth.png"});
  EXPECT_EQ(contents_of(path("o.depth.png")), "mine");
  write(request("o.png", true, {"depth"}), {"view"});
  EXPECT_EQ(names(), (Names{"o.depth.png", "o.png"}));
  EXPECT_NE(contents_of(path("o.depth.png")), "mine");
}

TEST_F(Pictures, OfOneNameAreNeverOneFile) {
  expect_refused(request("out", true, {"depth"}), {"a", "a.depth"}, "two pictures have this name");
}

TEST_F(Pictures, NeverReplaceTheInput) {
  folder_.write("out/a.png", "a clip of this name");
  PictureRequest wanted = request("out", true);
  wanted.inputs = {path("out/a.png")};
  expect_refused(wanted, {"a"}, "also the input");
  EXPECT_EQ(contents_of(path("out/a.png")), "a clip of this name");
}

TEST_F(Pictures, LeaveAloneWhatHasTheNameOfSomethingUnfinished) {
  const Names mine{"o.png.2.part/notes.txt", "o.png.part", "o.png.parts/notes.txt", "out/.part/notes.txt"};
  for (const std::string& name : mine) folder_.write(name, "mine");
  write(request("out", false), {"a"});
  write(request("o.png", false), {"view"});
  for (const std::string& name : mine) EXPECT_EQ(contents_of(path(name)), "mine") << name;
  Names all = mine;
  all.insert(all.end(), {"o.png", "out/a.png"});
  std::sort(all.begin(), all.end());
  EXPECT_EQ(names(), all);
}

TEST_F(Pictures, ThatAreNotFinishedLeaveNothing) {
  { const auto still = PictureOutput::open(request("o.png", false, {"depth"}), {"view"}, table_); }
  { const auto folder = PictureOutput::open(request("out", false), {"a"}, table_); }
  EXPECT_EQ(names(), Names{});
}

} // namespace
} // namespace kinora::cli
