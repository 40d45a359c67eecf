// What every file that is made of a clip says of itself, as a user makes it.
#include <map>
#include <set>

#include "bake/analytic_field.h"
#include "cli/known_formats.h"
#include "cli/run_kinora.h"
#include "clip/clip_io.h"

namespace kinora::test {
namespace {

/// How a format is written, and which of the files that come of it say how they were made.
struct Export {
  std::string format;
  std::string command;
  std::string output;
  std::vector<std::string> options;
  std::vector<std::string> files;
  std::string units; ///< axes and lengths in the file's own words; empty where the format has one way alone, or none
  std::string lost;
};

const char* const kMeshes = "what is half transparent; how colours change while things turn (their mean is written)";
const char* const kViews = "what these cameras do not see";

const Export kExports[] = {
    {"glb", "convert", "a.glb", {"-O", "triangles=2000"}, {"a.glb"}, "", kMeshes},
    {"usd",
     "convert",
     "a.usda",
     {"-O", "triangles=2000"},
     {"a.usda"},
     "metersPerUnit = 1\n    upAxis = \"Y\"",
     kMeshes},
    {"usd",
     "convert",
     "b.usda",
     {"-O", "triangles=2000", "-O", "up=z", "-O", "units=cm"},
     {"b.usda"},
     "metersPerUnit = 0.01\n    upAxis = \"Z\"",
     kMeshes},
    {"ply",
     "convert",
     "a.ply",
     {"-O", "triangles=2000"},
     {"a_0001.ply", "a_0003.ply"},
     "metres, x right, y up, z backward",
     kMeshes},
    {"ply",
     "convert",
     "b.ply",
     {"-O", "content=splats", "-O", "triangles=2000"},
     {"b_0001.ply", "b_0003.ply"},
     "metres, x right, y down, z forward",
     kMeshes},
    {"obj",
     "convert",
     "a.obj",
     {"-O", "triangles=2000", "-O", "up=z", "-O", "units=mm"},
     {"a_0001.obj", "a_0003.obj"},
     "millimetres, x right, y forward, z up",
     kMeshes},
    {"openvdb",
     "convert",
     "a.vdb",
     {"-O", "voxel=0.05"},
     {"a_0001.vdb", "a_0003.vdb"},
     "metres, x right, y up, z backward",
     "what is finer than 0.05 m"},
    {"openvdb",
     "convert",
     "c.vdb",
     {"-O", "voxel=0.05", "-O", "index=true"},
     {"c.usda"},
     "metersPerUnit = 1\n    upAxis = \"Y\"",
     "what is finer than 0.05 m"},
    {"png",
     "render",
     "a.png",
     {},
     {"a.png"},
     "sRGB, straight alpha",
     "what these cameras do not see; depth; which layer is where; where the cameras are"},
    {"png",
     "render",
     "a",
     {"--passes", "rgb,depth"},
     {"a/000000.depth.png", "a/000002.depth.png"},
     "millimetres along the optical axis",
     "what these cameras do not see; which layer is where; where the cameras are; the times of the frames"},
    {"png",
     "render",
     "b",
     {"--passes", "rgb,normal"},
     {"b/000000.normal.png", "b/000002.normal.png"},
     "x right, y up, z to the camera",
     kViews},
    {"exr", "render", "a.exr", {}, {"a.exr"}, "metres, x right, y up, z backward", kViews},
    {"exr",
     "render",
     "c",
     {"-O", "format=exr", "-O", "views=parts", "--passes", "rgb,deep"},
     {"c/000000.exr", "c/000002.deep.exr"},
     "metres, x right, y up, z backward",
     kViews},
    {"mp4",
     "render",
     "a.mp4",
     {},
     {"a.mp4"},
     "",
     "what these cameras do not see; opacity (all is on black); depth; which layer is where; where the cameras are; "
     "colours finer than two pixels"},
    {"mp4", "render", "a.webm", {}, {"a.webm"}, "", "what these cameras do not see; opacity (all is on black)"},
    {"data-set",
     "render",
     "d",
     {"-O", "format=data-set"},
     {"d/transforms.json"},
     "metres; cameras: x right, y up, z backward; world: x right, y down, z forward",
     "what these cameras do not see; opacity (all is on black)"},
};

class ExportFacts : public testing::Test {
protected:
  ExportFacts() { clip::write_clip(bake::testing::sample_clip(kFrames), folder_.path() / kClip); }

  Said run(const Export& chosen, const std::string& into) const {
    fs::create_directories(folder_.path() / into);
    std::vector<std::string> words{chosen.command, (folder_.path() / kClip).string(),
                                   (folder_.path() / into / chosen.output).string()};
    if (chosen.command == "render") words.insert(words.end(), {"--size", "64x48"});
    words.insert(words.end(), chosen.options.begin(), chosen.options.end());
    return run_kinora(folder_, words);
  }
  std::string bytes_of(const std::string& file) const { return contents_of(folder_.path() / file); }

  static constexpr int kFrames = 3;
  static constexpr const char* kClip = "Tänzer 1.mkv";
  TemporaryFolder folder_;
};

TEST_F(ExportFacts, StandInTheFilesOfEveryFormat) {
  for (const Export& chosen : kExports) {
    const Said said = run(chosen, "out");
    ASSERT_EQ(said.code, 0) << chosen.output << ": " << said.err;
    EXPECT_NE(said.out.find("Not in it: " + chosen.lost), std::string::npos) << chosen.output << ": " << said.out;
    for (const std::string& file : chosen.files) {
      const std::string bytes = bytes_of("out/" + file);
      ASSERT_FALSE(bytes.empty()) << file;
      const bool one = chosen.output == "a.png" || chosen.output == "a.exr"; // a picture is of the first frame
      std::vector<std::string> facts{
          "Kinora",     kClip,      "background, object, person", one ? "0" : "0 to 2, 3 of them", "fps",
          chosen.units, chosen.lost};
      if (chosen.command == "render") facts.insert(facts.end(), {"cameras", "the capture's"});
      if (chosen.command == "convert") facts.insert(facts.end(), {"origin", "0, 0, 0"});
      if (chosen.lost == kMeshes) facts.insert(facts.end(), {"triangles", "at most 2000 per layer"});
      if (chosen.format == "openvdb") facts.insert(facts.end(), {"voxel", "0.05 m"});
      for (const std::string& fact : facts)
        EXPECT_NE(bytes.find(fact), std::string::npos) << file << " does not say \"" << fact << "\"";
    }
  }
}

/// A new format that writes meshes, volumes or pictures comes here too. Captures are their data: what a conversion of
/// one leaves out is told of while it is read.
TEST_F(ExportFacts, AreAskedOfEveryFormatThatIsMadeOfAClip) {
  std::set<std::string> tried;
  for (const Export& chosen : kExports) tried.insert(chosen.format);
  EXPECT_EQ(tried, export_formats(folder_));
}

TEST_F(ExportFacts, AreTheSameEachTime) {
  for (const Export& chosen : kExports) {
    const Said said = run(chosen, "first");
    ASSERT_EQ(said.code, 0) << chosen.output << said.err;
    ASSERT_EQ(run(chosen, "second").code, 0) << chosen.output;
  }
  const std::vector<std::string> names = names_in(folder_.path() / "first");
  EXPECT_EQ(names, names_in(folder_.path() / "second"));
  for (const std::string& name : names) EXPECT_TRUE(bytes_of("first/" + name) == bytes_of("second/" + name)) << name;
}

} // namespace
} // namespace kinora::test
