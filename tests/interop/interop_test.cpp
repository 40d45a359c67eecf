// What foreign programs make of Kinora's files, compared with what kinora render draws.
#include <algorithm>
#include <cstring>
#include <stdexcept>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <png.h>

#include <gtest/gtest.h>

#include "cli/run_kinora.h"
#include "core/camera.h"
#include "core/metrics.h"
#include "support/source_folder.h"

namespace kinora::interop {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kClipFrames = 8;
constexpr std::array<int, 3> kFrames{0, 3, 7}; ///< of the clip
constexpr double kFramesPerSecond = 30;

bool runs(const std::string& command) { return std::system((command + " > /dev/null 2>&1").c_str()) == 0; }

fs::path script(const char* name) { return test::source_folder() / "tests/interop" / name; }

/// Of samples/carry_box.
Intrinsics intrinsics() { return Intrinsics{640, 480, 525, 525, 319.5, 239.5}.resized(kWidth, kHeight); }

/// A folder of this test's own, which stays there to be looked at.
class Interop : public testing::Test {
protected:
  Interop() : folder_(fs::path(KINORA_INTEROP_FOLDER) / testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }

  void kinora(std::vector<std::string> words) const {
    const test::Said said = test::Running(folder_, std::move(words)).finish();
    ASSERT_EQ(said.code, 0) << said.err;
  }
  fs::path path(const std::string& name) const { return folder_ / name; }
  static std::string clip() { return (fs::path(KINORA_INTEROP_FOLDER) / "clip.mkv").string(); }

  /// Pictures of the same from kinora render, as reference/00000N.png.
  void draw_reference() const {
    kinora({"render", clip(), path("reference").string(), "--layers", "person,object", "--size", "320x240"});
  }
  void run_script(const std::string& command, const Json& job) const {
    std::ofstream(path("job.json")) << job.dump(1);
    run_script(command, path("job.json"));
  }
  /// What it says is in log.txt.
  void run_script(const std::string& command, const fs::path& file) const {
    const std::string all = command + " '" + file.string() + "' > '" + path("log.txt").string() + "' 2>&1";
    ASSERT_EQ(std::system(all.c_str()), 0) << test::contents_of(path("log.txt"));
  }
  static Json camera() {
    const Intrinsics c = intrinsics();
    return {{"w", c.width}, {"h", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy}};
  }
  static Json times() {
    Json times = Json::array();
    for (const int frame : kFrames) times.push_back(frame / kFramesPerSecond);
    return times;
  }

  /// With straight alpha: kinora's own decoder drops it.
  static ColorImage read(const fs::path& file) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_file(&png, file.c_str()) == 0) throw std::runtime_error(file.string() + png.message);
    png.format = PNG_FORMAT_RGBA;
    ColorImage image(static_cast<int>(png.width), static_cast<int>(png.height), 4);
    if (png_image_finish_read(&png, nullptr, image.data(), 0, nullptr) == 0) throw std::runtime_error(png.message);
    return image;
  }
  /// A picture with transparency, as `out`_0.png and so on, against the reference.
  void expect_same(const std::string& out, std::size_t pictures, double min_psnr) const {
    for (std::size_t i = 0; i < pictures; ++i) {
      const ColorImage made = read(path(out + "_" + std::to_string(i) + ".png"));
      const ColorImage reference = read(path("reference/" + test::six_digits(kFrames[i]) + ".png"));
      ASSERT_EQ(made.channels(), 4);
      ASSERT_EQ(reference.channels(), 4);
      ColorImage truth(reference.width(), reference.height(), 3);
      LabelImage mask(reference.width(), reference.height());
      for (std::size_t k = 0; k < reference.pixel_count(); ++k) {
        std::copy_n(reference.data() + 4 * k, 3, truth.data() + 3 * k);
        mask.data()[k] = reference.data()[4 * k + 3] > 127 ? 1 : 0;
      }
      const ImageMetrics metrics = compare_images(made, truth, mask);
      std::printf("%s, frame %d: IoU %.3f, %.1f dB inside\n", out.c_str(), kFrames[i], metrics.iou,
                  metrics.psnr_inside);
      EXPECT_GE(metrics.iou, 0.9) << out << ", frame " << kFrames[i];
      EXPECT_GE(metrics.psnr_inside, min_psnr) << out << ", frame " << kFrames[i];
    }
  }

  fs::path folder_;
};

/// Around the vertices of a PLY file of Kinora.
std::pair<Eigen::Vector3f, Eigen::Vector3f> box_of(const fs::path& file) {
  const std::string bytes = test::contents_of(file);
  const std::string key = "element vertex ";
  const auto count = static_cast<std::size_t>(std::stoul(bytes.substr(bytes.find(key) + key.size())));
  const std::size_t body = bytes.find("end_header\n") + 11;
  constexpr std::size_t kVertexBytes = 27;
  Eigen::AlignedBox3f box;
  for (std::size_t v = 0; v < count; ++v) {
    Eigen::Vector3f position;
    std::memcpy(position.data(), bytes.data() + body + kVertexBytes * v, sizeof position);
    box.extend(position);
  }
  return {box.min(), box.max()};
}

/// Blender 3.4's importer needs NumPy, which Debian only recommends.
bool has_blender() { return runs("blender --version") && runs("/usr/bin/python3 -c 'import numpy'"); }

std::string blender() {
  return "blender -b --factory-startup --python-exit-code 1 --python '" + script("render_in_blender.py").string() +
         "' --";
}

TEST_F(Interop, BlenderDrawsAnimatedMeshesAsKinoraDoes) {
  if (!has_blender()) GTEST_SKIP() << "blender or python3-numpy is not installed";
  draw_reference();
  Json views = Json::array();
  for (const char* animation : {"skin", "morph", "sequence"}) {
    const std::string file = path(std::string(animation) + ".glb").string();
    kinora({"convert", clip(), file, "-O", "layers=person,object", "-O", std::string("animation=") + animation});
    views.push_back({{"file", file}, {"out", path(animation).string()}});
  }
  run_script(blender(),
             {{"camera", camera()}, {"fps", kFramesPerSecond}, {"frames", kFrames}, {"samples", 16}, {"views", views}});
  for (const char* animation : {"skin", "morph", "sequence"}) expect_same(animation, kFrames.size(), 22);
}

TEST_F(Interop, BlenderDrawsTheVolumesAsKinoraDoes) {
  if (!has_blender()) GTEST_SKIP() << "blender or python3-numpy is not installed";
  draw_reference();
  kinora({"convert", clip(), path("clip.vdb").string(), "-O", "layers=person,object", "-O", "vdb-names=blender", "-O",
          "up=z"});
  Json files = Json::array();
  for (int i = 1; i <= kClipFrames; ++i) files.push_back(path("clip_000" + std::to_string(i) + ".vdb").string());
  run_script(blender(), {{"camera", camera()},
                         {"fps", kFramesPerSecond},
                         {"frames", kFrames},
                         {"samples", 8},
                         {"views", {{{"files", files}, {"out", path("vdb").string()}}}}});
  expect_same("vdb", kFrames.size(), 22);
}

bool has_three() {
  return runs("chromium --version") && runs("node --version") && fs::exists(script("node_modules/three"));
}

std::string three() { return "node '" + script("view_in_three.mjs").string() + "'"; }

TEST_F(Interop, ThreeDrawsPlainMeshoptAndDracoFilesAsKinoraDoes) {
  if (!has_three()) GTEST_SKIP() << "chromium, node or three.js is not installed; run tests/interop/install";
  draw_reference();
  Json views = Json::array();
  for (const char* compression : {"none", "meshopt", "draco"}) {
    const std::string name = std::string(compression) + ".glb";
    kinora({"convert", clip(), path(name).string(), "-O", "layers=person,object", "-O",
            std::string("compression=") + compression});
    views.push_back({{"file", name}, {"out", compression}});
  }
  run_script(three(), {{"camera", camera()}, {"times", times()}, {"views", views}});
  for (const char* compression : {"none", "meshopt", "draco"}) expect_same(compression, kFrames.size(), 22);
}

/// Its loader takes each mesh at its first time sample: so each frame is a file.
TEST_F(Interop, ThreeDrawsUsdFilesAsKinoraDoes) {
  if (!has_three()) GTEST_SKIP() << "chromium, node or three.js is not installed; run tests/interop/install";
  draw_reference();
  for (std::size_t i = 0; i < kFrames.size(); ++i) {
    const std::string name = "usd " + std::to_string(i) + ".usda";
    kinora({"convert", clip(), path(name).string(), "-O", "layers=person,object", "--frames",
            std::to_string(kFrames[i]) + ":" + std::to_string(kFrames[i] + 1)});
    const std::string out = "usd" + std::to_string(i);
    run_script(three(), {{"camera", camera()}, {"times", {0}}, {"views", {{{"file", name}, {"out", out}}}}});
    fs::rename(path(out + "_0.png"), path("usd_" + std::to_string(i) + ".png"));
  }
  expect_same("usd", kFrames.size(), 22);
}

/// TinyUSDZ takes time samples at the first one, too; its parser is another than that of three.js.
TEST_F(Interop, TinyUsdzFindsTheMeshesWhereTheyAre) {
  if (!runs("node --version") || !fs::exists(script("node_modules/tinyusdz")))
    GTEST_SKIP() << "node or TinyUSDZ is not installed; run tests/interop/install";
  const test::Said said =
      test::Running(folder_, {"convert", clip(), path("clip.usda").string(), "-O", "layers=person,object", "--json"})
          .finish();
  ASSERT_EQ(said.code, 0) << said.err;
  run_script("node '" + script("read_usd.mjs").string() + "'", path("clip.usda"));
  const Json found = Json::parse(test::contents_of(path("log.txt")))["meshes"];
  const Json layers = Json::parse(said.out)["layers"];
  ASSERT_EQ(found.size(), layers.size());
  for (const Json& layer : layers) {
    const std::string name = layer["name"];
    SCOPED_TRACE(name);
    const auto mesh = std::ranges::find(found, layer["name"], [](const Json& one) { return one["name"]; });
    ASSERT_NE(mesh, found.end());
    EXPECT_EQ((*mesh)["triangles"], layer["triangles"]);
    EXPECT_EQ((*mesh)["texture"], "clip_" + name + ".jpg");
    // The box of the same layer as points, which are not simplified.
    kinora({"convert", clip(), path(name + ".ply").string(), "-O", "layers=" + name, "--frames", "0:1"});
    const auto [low, high] = box_of(path(name + "_0001.ply"));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR((*mesh)["low"][k].get<double>(), low[static_cast<Eigen::Index>(k)], 0.01);
      EXPECT_NEAR((*mesh)["high"][k].get<double>(), high[static_cast<Eigen::Index>(k)], 0.01);
    }
  }
}

/// Views as parts, and deep pixels.
TEST_F(Interop, OpenExrsOwnProgramsReadViewsAndDeepPictures) {
  if (std::system("exrheader -v > /dev/null 2>&1") == 127 * 256) GTEST_SKIP() << "exrheader is not installed";
  std::ofstream(path("cameras.json")) << R"({"w": 320, "h": 240, "fl_x": 262.5, "frames": [
    {"file_path": "left", "frame": 0, "transform_matrix": [[1,0,0,-0.1],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]},
    {"file_path": "right", "frame": 0, "transform_matrix": [[1,0,0,0.1],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]}]})";
  kinora({"render", clip(), path("views").string(), "--cameras", path("cameras.json").string(), "-O", "format=exr",
          "-O", "views=parts", "--passes", "rgb,normal,confidence,deep"});
  const auto header_of = [this](const std::string& name) {
    const std::string log = path(name + ".txt").string();
    EXPECT_TRUE(std::system(("exrheader '" + path("views/" + name).string() + "' > '" + log + "' 2>&1").c_str()) == 0);
    return test::contents_of(log);
  };
  const std::string views = header_of("000000.exr");
  for (const char* line : {"name (type string): \"left\"", "view (type string): \"right\"",
                           "type (type string): \"scanlineimage\"", "N.X, 16-bit floating-point",
                           "Z, 32-bit floating-point", "software (type string): \"Kinora\"", "lost (type string): \""})
    EXPECT_NE(views.find(line), std::string::npos) << line << " is not in:\n" << views;
  for (const std::string name : {"left.deep.exr", "right.deep.exr"}) {
    const std::string deep = header_of(name);
    for (const char* line : {"type (type string): \"deepscanline\"", "Z, 32-bit floating-point",
                             "id, 32-bit unsigned integer", "layers (type string): \""})
      EXPECT_NE(deep.find(line), std::string::npos) << line << " is not in:\n" << deep;
  }
}

TEST_F(Interop, ASplatViewerDrawsSplatsAsKinoraDoes) {
  if (!has_three() || !fs::exists(script("node_modules/@mkkellogg/gaussian-splats-3d")))
    GTEST_SKIP() << "chromium, node or the splat viewer is not installed; run tests/interop/install";
  draw_reference();
  kinora({"convert", clip(), path("splats.ply").string(), "-O", "layers=person,object", "-O", "content=splats"});
  for (std::size_t i = 0; i < kFrames.size(); ++i) {
    const Json view = {{"file", "splats_000" + std::to_string(kFrames[i] + 1) + ".ply"}, {"out", "drawn"}};
    run_script(three(), {{"camera", camera()}, {"times", {0}}, {"views", {view}}});
    fs::rename(path("drawn_0.png"), path("splats_" + std::to_string(i) + ".png"));
  }
  expect_same("splats", kFrames.size(), 21); // 21.3: splats are as wide as triangles, and fields hold finer colours
}

/// Each `compression` of each way to bend.
TEST_F(Interop, ThreeDrawsMorphTargetsAndSequencesAsKinoraDoes) {
  if (!has_three()) GTEST_SKIP() << "chromium, node or three.js is not installed; run tests/interop/install";
  draw_reference();
  const std::pair<const char*, const char*> kinds[] = {
      {"morph", "none"}, {"morph", "meshopt"}, {"sequence", "none"}, {"sequence", "meshopt"}, {"sequence", "draco"}};
  Json views = Json::array();
  std::vector<std::string> names;
  for (const auto& [animation, compression] : kinds) {
    names.push_back(std::string(animation) + "-" + compression);
    kinora({"convert", clip(), path(names.back() + ".glb").string(), "-O", "layers=person,object", "-O",
            std::string("compression=") + compression, "-O", std::string("animation=") + animation});
    views.push_back({{"file", names.back() + ".glb"}, {"out", names.back()}});
  }
  run_script(three(), {{"camera", camera()}, {"times", times()}, {"views", views}});
  for (const std::string& name : names) expect_same(name, kFrames.size(), 22);
}

} // namespace
} // namespace kinora::interop
