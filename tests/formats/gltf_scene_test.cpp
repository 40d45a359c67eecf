// Animated scenes before a virtual camera: against what Blender renders of the same scene, and against arithmetic.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "formats/damage.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

fs::path sample(const char* name) { return fs::path(KINORA_BLENDER_SAMPLES) / name; }

double depth_at(const CopiedFrame& frame, std::size_t pixel) {
  return frame.depth_unit * reinterpret_cast<const std::uint16_t*>(frame.depth.data())[pixel];
}

const host::Options kSmall{{"width", "64"}, {"height", "48"}, {"fps", "10"}};

/// Nodes, a skin, a morph target and a camera that flies; Cycles's rays need not meet a pixel's centre exactly.
TEST(GltfScene, DepthIsWhatBlenderRendersOfTheSameScene) {
  const CopiedCapture ours = read_capture(sample("scene.glb"), "", kSmall);
  const CopiedCapture blender = read_capture(sample("render"));
  EXPECT_EQ(ours.format, "gltf-scene");
  EXPECT_EQ(blender.format, "exr-sequence");
  ASSERT_EQ(ours.frames.size(), 5U);
  ASSERT_EQ(blender.frames.size(), 3U);
  EXPECT_NEAR(ours.info.camera.fx, blender.info.camera.fx, 1e-4);
  for (std::size_t i = 0; i < blender.frames.size(); ++i) {
    std::size_t compared = 0, far = 0;
    for (std::size_t p = 0; p < 64 * 48; ++p) {
      const double a = depth_at(ours.frames[2 * i], p);
      const double b = depth_at(blender.frames[i], p);
      if (a == 0 && b == 0) continue;
      ++compared;
      far += std::abs(a - b) > 1e-3 ? 1 : 0;
    }
    EXPECT_GT(compared, 1500U);
    EXPECT_LE(far, 12U) << "of " << compared << " pixels at time " << i << "; contours may fall either way";
  }
}

TEST(GltfScene, TheCameraOfTheFileFliesAndThingsThatMoveAreLabelled) {
  const CopiedCapture capture = read_capture(sample("scene.glb"), "", kSmall);
  EXPECT_EQ(capture.info.has_poses, 1);
  EXPECT_EQ(capture.info.label_count, 3U) << "box, pyramid and tube; the floor keeps still";
  const std::array<double, 16>& first = capture.frames[0].pose; // Blender's (x, y, z) is glTF's (x, z, -y)
  EXPECT_NEAR(first[3], 0.2, 1e-5);
  EXPECT_NEAR(first[7], 1.4, 1e-5);
  EXPECT_NEAR(first[11], 3, 1e-5);
  EXPECT_NEAR(capture.frames[4].pose[3], 0.5, 1e-5);
  std::set<std::byte> labels(capture.frames[2].labels.begin(), capture.frames[2].labels.end());
  EXPECT_EQ(labels, (std::set{std::byte{0}, std::byte{1}, std::byte{2}, std::byte{3}}));
  EXPECT_EQ(read_capture(sample("scene.glb"), "", {{"masks", "false"}}).info.has_masks, 0);
}

TEST(GltfScene, AnAutomaticCameraSeesEverything) {
  const CopiedCapture capture =
      read_capture(sample("scene.glb"), "", {{"width", "80"}, {"height", "60"}, {"fps", "10"}, {"camera", "auto"}});
  EXPECT_EQ(capture.info.has_poses, 0) << "it keeps still";
  for (const CopiedFrame& frame : capture.frames)
    for (std::size_t p = 0; p < 80 * 60; ++p)
      if (p < 80 || p >= 80 * 59 || p % 80 == 0 || p % 80 == 79) {
        ASSERT_EQ(depth_at(frame, p), 0) << "the picture's border is empty";
      }
}

TEST(GltfScene, AnyFrameCanBeReadAtOnce) {
  const CopiedCapture capture = read_capture(sample("scene.glb"), "", kSmall);
  const host::PluginTable plugins = host::PluginTable::builtin();
  host::FrameReader reader(plugins.find("gltf-scene"), sample("scene.glb"), kSmall);
  for (const int index : {4, 0, 3}) {
    reader.seek(index);
    const auto frame = reader.next();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(pixels_of(frame->frame.depth), capture.frames[static_cast<std::size_t>(index)].depth) << index;
  }
}

// ---- files that are made here

/// A quadrangle of 2x2 m; `parts` are put into the JSON after the buffers.
class HandmadeScene : public testing::Test {
protected:
  static constexpr const char* kParts =
      R"("scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "sheet"}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}])";

  HandmadeScene() {
    const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, -2, -1, 1, -2}; // it leans back
    const std::uint16_t indices[] = {0, 1, 2, 0, 2, 3};
    const float times[] = {0, 0.5F, 1};
    const float places[] = {0, 0, -3, 0, 0, -4, 0, 0, -4};
    std::string bytes;
    const auto add = [&bytes](const auto& list) { bytes.append(reinterpret_cast<const char*>(list), sizeof list); };
    add(positions);
    add(indices);
    add(times);
    add(places);
    folder_.write("a.bin", bytes);
  }
  fs::path write(const std::string& parts, const std::string& uri = "a.bin") const {
    folder_.write("a.gltf", fmt::format(R"({{"asset": {{"version": "2.0"}},
      "buffers": [{{"uri": "{}", "byteLength": 108}}],
      "bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 12}},
        {{"buffer": 0, "byteOffset": 60, "byteLength": 12}}, {{"buffer": 0, "byteOffset": 72, "byteLength": 36}}],
      "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
        {{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}},
        {{"bufferView": 2, "componentType": 5126, "count": 3, "type": "SCALAR"}},
        {{"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC3"}},
        {{"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"}}], {}}})",
                                        uri, parts));
    return folder_.path() / "a.gltf";
  }
  std::string problem(const std::string& parts, const std::string& uri = "a.bin",
                      const host::Options& options = {}) const {
    try {
      (void)read_capture(write(parts, uri), "gltf-scene", options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

TEST_F(HandmadeScene, DepthOfALeaningSheetIsExactAtEveryPixel) {
  const std::string parts = R"("scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0, "translation": [0, 0, -3]}, {"camera": 0, "name": "eye"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}])";
  const CopiedCapture capture = read_capture(write(parts), "", {{"width", "64"}, {"height", "48"}});
  const double focal = 24 / std::tan(0.5);
  ASSERT_NEAR(capture.info.camera.fx, focal, 1e-9);
  std::size_t seen = 0;
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      const double z =
          depth_at(capture.frames.at(0), std::size_t{64} * static_cast<std::size_t>(v) + static_cast<std::size_t>(u));
      if (z == 0) continue;
      ++seen;
      // On the sheet z_camera = 4 + y with y up: from 3 m at its lower edge to 5 m at its upper one.
      const double slope = (23.5 - v) / focal;
      ASSERT_NEAR(z, 4 / (1 - slope), 0.5 * capture.frames[0].depth_unit + 1e-6) << u << " " << v;
    }
  EXPECT_GT(seen, 500U);
  EXPECT_EQ(capture.warnings.size(), 1U) << "it has no animation";
}

TEST_F(HandmadeScene, MotionIsInterpolatedAsTheFileSays) {
  for (const auto& [interpolation, quarter] : {std::pair{"LINEAR", 3.5}, {"STEP", 3.0}}) {
    const std::string parts = fmt::format(R"("scenes": [{{"nodes": [0, 1]}}],
      "nodes": [{{"mesh": 0}}, {{"camera": 0}}], "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
      "cameras": [{{"type": "perspective", "perspective": {{"yfov": 1.0, "znear": 0.1}}}}],
      "animations": [{{"name": "back", "samplers": [{{"input": 2, "output": 3, "interpolation": "{}"}}],
        "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}]}}])",
                                          interpolation);
    const CopiedCapture capture = read_capture(write(parts), "", {{"width", "9"}, {"height", "9"}, {"fps", "4"}});
    ASSERT_EQ(capture.frames.size(), 5U);
    // Along the axis, on the edge between two triangles, the sheet is a metre behind its node.
    const double centre[] = {4, quarter + 1, 5, 5, 5};
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(depth_at(capture.frames[i], 4 * 9 + 4), centre[i], 2e-4) << i;
  }
}

TEST_F(HandmadeScene, ContradictionsAreRefusedInOneSentence) {
  const auto mesh = [](const std::string& attributes, const std::string& more = "") {
    return R"("nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {)" + attributes + "}" + more + "}]}]";
  };
  const std::pair<std::string, const char*> cases[] = {
      {mesh(R"("POSITION": 4)"), "beyond its buffer"},
      {mesh(R"("POSITION": 9)"), "is not there"},
      {mesh(R"("POSITION": 1)"), "has not the size"},
      {mesh(R"("POSITION": 0, "COLOR_0": 3)"), "has not the size"},
      {mesh(R"("POSITION": 0)", R"(, "material": 3)"), "a material is not there"},
      {mesh(R"("POSITION": 3)", R"(, "indices": 1)"), "a corner that is not there"},
      {R"("nodes": [{"children": [1], "mesh": 0}, {"children": [0]}], "scenes": [{"nodes": [0]}],
          "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}])",
       "stands twice"},
      {R"("nodes": [{"children": [7]}])", "a node is not there"},
      {R"("nodes": [{}])", "no mesh"},
      {std::string(kParts) + R"(, "extensionsRequired": ["KHR_draco_mesh_compression"])", "KHR_draco_mesh_compression"},
      {std::string(kParts) + R"(, "animations": [{"samplers": [{"input": 3, "output": 3}],
          "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}])",
       "do not increase"}};
  for (const auto& [parts, word] : cases) {
    const std::string said = problem(parts);
    EXPECT_NE(said.find(word), std::string::npos) << word << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST_F(HandmadeScene, NothingOutsideOfItsFolderIsRead) {
  EXPECT_EQ(problem(kParts), "");
  EXPECT_NE(problem(kParts, "../a.bin"), "");
  EXPECT_NE(problem(kParts, (folder_.path().parent_path() / "a.bin").string()), "");
  EXPECT_NE(problem(kParts, "missing.bin"), "");
}

TEST_F(HandmadeScene, OptionsThatCannotBeAreNamed) {
  EXPECT_NE(problem(kParts, "a.bin", {{"camera", "nobody"}}).find("camera=nobody"), std::string::npos);
  EXPECT_NE(problem(kParts, "a.bin", {{"animation", "2"}}).find("animation=2"), std::string::npos);
  EXPECT_NE(problem(kParts, "a.bin", {{"width", "0"}}).find("width"), std::string::npos);
  EXPECT_NE(problem(kParts, "a.bin", {{"fps", "-1"}}).find("fps"), std::string::npos);
}

TEST_F(HandmadeScene, DamagedFilesAreRefusedAtEveryLength) {
  fs::copy_file(sample("scene.glb"), folder_.path() / "b.glb");
  expect_bears_truncation(folder_.path() / "b.glb", folder_.path() / "b.glb", "gltf-scene", 1000);
  const fs::path text = write(kParts);
  expect_bears_truncation(text, text, "gltf-scene", 1);
  expect_bears_truncation(folder_.path() / "a.bin", text, "gltf-scene", 1);
}

} // namespace
} // namespace kinora::formats
