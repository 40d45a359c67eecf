// A generated capture through the whole encoder: what comes out must look like what went in.
#include <algorithm>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "core/error.h"
#include "core/parallel.h"
#include "encode/pipeline.h"
#include "end_to_end/box_capture.h"
#include "evaluate/evaluate.h"
#include "host/plugin_table.h"
#include "tracking/scenes/bending_plate.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

/// Keeps the warnings and can be told to stop.
class Listener : public Progress {
public:
  void advance(std::size_t done, const std::string& /*detail*/) override { stopped = stopped || done >= stop_at; }
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  bool cancelled() const override { return stopped; }

  std::vector<std::string> warnings;
  std::size_t stop_at = 1'000'000'000;
  bool stopped = false;
};

/// Small budgets: a test has seconds.
encode::EncodeOptions quick_options() {
  auto options = encode::EncodeOptions::of(encode::Preset::kFast);
  options.settings.budget.decibels_per_second = 0;
  options.settings.budget.rays_per_pixel = 8;
  options.settings.budget.deforming_rays_per_pixel = 8;
  return options;
}

encode::PreparedCapture prepare_folder(const TemporaryFolder& folder, const ingest::CaptureOptions& options,
                                       Progress& progress, int holdout = 0) {
  static const auto kTable = host::PluginTable::builtin();
  encode::CaptureRequest request;
  request.open = [&](const ingest::CaptureOptions& how, Progress& to) {
    return ingest::Capture::open(kTable, folder.path(), how, to);
  };
  request.options = options;
  request.holdout = holdout;
  return encode::prepare_capture(request, progress);
}

encode::EncodeResult encode_folder(const TemporaryFolder& folder, const encode::EncodeOptions& options,
                                   Progress& progress) {
  return encode::encode_capture(prepare_folder(folder, {}, progress, options.holdout), options, progress);
}

Json layer_named(const Json& report, const std::string& name) {
  for (const Json& layer : report.at("layers")) {
    if (layer.at("name") == name) return layer;
  }
  return nullptr;
}

// A plate that swings like a cloth, labelled as an object.
void write_bending_capture(const TemporaryFolder& folder) {
  tracking::testing::SceneOptions scene;
  scene.width = 128;
  scene.height = 96;
  scene.focal = 120;
  scene.noise = 1;
  for (int i = 0; i < 20; ++i) {
    tracking::testing::Plate plate;
    plate.to_world = tracking::testing::pose_at({0.004 * i, 0, 1}, 10, 5);
    plate.curvature = 2 * std::sin(0.3 * i);
    const ingest::Frame frame = render_plate(plate, SE3::Identity(), i, scene);
    DepthImage16 depth(scene.width, scene.height);
    ColorImage labels(scene.width, scene.height, 1);
    for (std::size_t k = 0; k < depth.pixel_count(); ++k) {
      depth.values()[k] = static_cast<std::uint16_t>(std::lround(1000 * frame.depth.values()[k]));
      labels.values()[k] = frame.labels.values()[k];
    }
    folder.write("color/" + six_digits(i) + ".png", encode_png(frame.color));
    folder.write("depth/" + six_digits(i) + ".png", encode_png16(depth));
    folder.write("mask/" + six_digits(i) + ".png", encode_png(labels));
  }
  folder.write("intrinsics.json", R"({"width": 128, "height": 96, "fx": 120, "fy": 120, "cx": 63.5, "cy": 47.5,
                                      "depth_factor": 1000, "fps": 30})");
}

TEST(Encoder, ThingThatBendsBecomesALayerThatDeforms) {
  const TemporaryFolder folder;
  write_bending_capture(folder);
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  const encode::EncodeResult deforming = encode_folder(folder, options, listener);
  const Json object = layer_named(deforming.report, "object");
  EXPECT_EQ(object.at("motion").at("kind"), "deforming");
  EXPECT_LT(object.at("motion").at("bends").at("from_frame"), 15);
  EXPECT_GT(object.at("motion").at("bends").at("by_m"), 0.01);
  EXPECT_EQ(object.at("motion").at("frames").at("tracked"), 20) << "it is followed anew from its first frame on";
  EXPECT_FALSE(object.at("motion").contains("body"));
  EXPECT_NE(object.at("why").get<std::string>().find("it bends, from frame"), std::string::npos);

  folder.write("labels.json", R"({"2": {"kind": "rigid"}})");
  const encode::EncodeResult told = encode_folder(folder, options, listener);
  const Json kept = layer_named(told.report, "object");
  EXPECT_EQ(kept.at("motion").at("kind"), "rigid");
  EXPECT_TRUE(kept.at("motion").contains("bends"));
  EXPECT_NE(kept.at("why").get<std::string>().find("kept rigid"), std::string::npos);
}

/// The report says how large a layer's field is, why, and what that costs.
void expect_size(const Json& layer, const fields::Field& field) {
  const Json& size = layer.at("size");
  EXPECT_NE(size.at("why").get<std::string>().find("measured points"), std::string::npos) << size;
  EXPECT_LT(field.config.cell_size(), 1.02 * size.at("pixel_footprint_m").get<double>());
  EXPECT_GT(size.at("surface_cells").get<double>(), 0);
  const auto levels = fields::grid_levels(field.config);
  ASSERT_EQ(size.at("levels").size(), levels.size());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Json& level = size.at("levels")[l];
    EXPECT_EQ(level.at("cells_per_side"), levels[l].resolution);
    EXPECT_EQ(level.at("entries"), levels[l].size);
    EXPECT_EQ(level.at("hashed"), levels[l].hashed);
    EXPECT_GT(level.at("entries_stored"), 0);
    EXPECT_LE(level.at("entries_stored"), level.at("entries"));
  }
  // Of each parameter also its gradient and both moments.
  EXPECT_EQ(size.at("training_bytes"), 4 * sizeof(float) * field.parameter_count());
  EXPECT_TRUE(size.at("growth").is_array());
}

TEST(Encoder, MovingBoxAndWallLookAlikeInHeldOutFrames) {
  const TemporaryFolder folder;
  write_box_capture(folder, {});
  Listener listener;
  auto options = quick_options();
  options.holdout = 5;
  encode::EncodeResult result = encode_folder(folder, options, listener);

  ASSERT_EQ(result.clip.layers.size(), 3U);
  EXPECT_EQ(result.clip.layers[0].motion.kind(), motion::MotionKind::kStill);
  EXPECT_EQ(result.clip.layers[1].motion.kind(), motion::MotionKind::kDeforming);
  EXPECT_EQ(result.clip.layers[2].motion.kind(), motion::MotionKind::kRigid);
  EXPECT_FALSE(layer_named(result.report, "object").at("motion").contains("bends"));
  EXPECT_TRUE(result.report.at("not_modelled").empty());
  EXPECT_EQ(result.report.at("capture").at("frames_held_out"), 2);
  EXPECT_TRUE(listener.warnings.empty());
  for (std::size_t i = 0; i < result.clip.layers.size(); ++i) {
    SCOPED_TRACE(result.clip.layers[i].name);
    const Json& layer = result.report.at("layers")[i];
    expect_size(layer, result.clip.layers[i].field);
    EXPECT_EQ(layer.at("training").at("restarts"), 0);
    EXPECT_TRUE(layer.at("training").at("restarted_because").empty());
  }

  const player::Player player(std::move(result.clip));
  evaluate::EvaluateOptions how;
  how.ground_truth = true;
  const Json quality = evaluate::evaluate_against(folder.path(), host::PluginTable::builtin(), player, how, listener);
  const Json object = layer_named(quality, "object").at("held_out");
  const Json background = layer_named(quality, "background").at("held_out");
  EXPECT_GT(object.at("psnr_box").get<double>(), 18);
  EXPECT_GT(object.at("iou").get<double>(), 0.88);
  EXPECT_LT(object.at("depth_error_median").get<double>(), 0.01);
  EXPECT_GT(background.at("psnr").get<double>(), 32);
  EXPECT_LT(background.at("depth_error_median").get<double>(), 0.012);
  EXPECT_GT(background.at("depth_coverage").get<double>(), 0.97);
  const Json pose = quality.at("ground_truth").at("object_pose");
  EXPECT_LT(pose.at("error_m_mean").get<double>(), 0.006);
  EXPECT_LT(pose.at("error_degrees_mean").get<double>(), 2);
}

/// Fields, and motion in all frames but the held-out ones, as bits.
void expect_same_but_held_out(const clip::Clip& a, const clip::Clip& b) {
  ASSERT_EQ(a.layers.size(), b.layers.size());
  EXPECT_EQ(a.held_out, b.held_out);
  for (std::size_t i = 0; i < a.layers.size(); ++i) {
    SCOPED_TRACE(a.layers[i].name);
    EXPECT_TRUE(std::ranges::equal(a.layers[i].field.table, b.layers[i].field.table));
    EXPECT_TRUE(a.layers[i].field.density_net == b.layers[i].field.density_net);
    EXPECT_TRUE(a.layers[i].field.color_net == b.layers[i].field.color_net);
    ASSERT_EQ(a.layers[i].motion.poses().size(), b.layers[i].motion.poses().size());
    for (std::size_t f = 0; f < a.layers[i].motion.poses().size(); ++f) {
      if (a.held_out[f]) continue;
      EXPECT_TRUE(a.layers[i].motion.poses()[f].canonical_to_world.matrix() ==
                  b.layers[i].motion.poses()[f].canonical_to_world.matrix())
          << f;
    }
  }
}

TEST(Encoder, NothingOfHeldOutFramesIsLearntOfTheirColoursMasksOrDepth) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 8;
  write_box_capture(folder, scene);
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 1;
  options.holdout = 4;
  const encode::EncodeResult as_seen = encode_folder(folder, options, listener);
  EXPECT_EQ(as_seen.report.at("capture").at("held_out_frames_are"), "unseen");
  for (const int frame : {3, 7}) {
    const std::string name = six_digits(frame) + ".png";
    folder.write("color/" + name, encode_png(ColorImage(128, 96, 3, 200)));
    folder.write("mask/" + name, encode_png(ColorImage(128, 96, 1, 1)));
  }
  const encode::EncodeResult recoloured = encode_folder(folder, options, listener);
  expect_same_but_held_out(as_seen.clip, recoloured.clip);
  for (std::size_t i = 0; i < as_seen.clip.layers.size(); ++i) {
    const auto& a = as_seen.clip.layers[i].motion;
    const auto& b = recoloured.clip.layers[i].motion;
    if (a.kind() != motion::MotionKind::kRigid) continue;
    EXPECT_TRUE(a.poses()[3].canonical_to_world.matrix() == b.poses()[3].canonical_to_world.matrix())
        << "nor does its place tell of what it shows";
    EXPECT_EQ(a.poses()[3].health, motion::Health::kHeld) << "nobody saw it";
  }
  for (const int frame : {3, 7}) {
    folder.write("depth/" + six_digits(frame) + ".png", encode_png16(DepthImage16(128, 96, 1, 1500)));
  }
  expect_same_but_held_out(as_seen.clip, encode_folder(folder, options, listener).clip);

  options.holdout = 0;
  options.holdout_tracked = 4;
  EXPECT_EQ(encode_folder(folder, options, listener).report.at("capture").at("held_out_frames_are"), "tracked");
}

TEST(Encoder, MovingCameraWithPosesSeesOneStillLayer) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.poses = true;
  scene.frames = 10;
  write_box_capture(folder, scene);
  Listener listener;
  auto options = quick_options();
  options.holdout = 5;
  encode::EncodeResult result = encode_folder(folder, options, listener);
  ASSERT_EQ(result.clip.layers.size(), 1U);
  EXPECT_EQ(result.clip.layers[0].name, "background");
  ASSERT_EQ(result.clip.camera_to_world.size(), 10U);
  EXPECT_NEAR(result.clip.camera_to_world[9].translation().x(), 0.18, 1e-6);

  const player::Player player(std::move(result.clip));
  const Json quality = evaluate::evaluate_against(folder.path(), host::PluginTable::builtin(), player, {}, listener);
  const Json held_out = layer_named(quality, "background").at("held_out");
  EXPECT_GT(held_out.at("psnr").get<double>(), 22);
  EXPECT_LT(held_out.at("depth_error_median").get<double>(), 0.01);
}

TEST(Encoder, PosesThatAreToldWrongComeNearer) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.poses = true;
  scene.pose_error = 0.008;
  write_box_capture(folder, scene);
  const auto error_after = [&](int passes) { // from one frame to the next: what all poses share is the world's place
    Listener listener;
    auto options = quick_options();
    options.settings.fields.poses.passes = passes;
    const std::vector<SE3> path = encode_folder(folder, options, listener).clip.camera_to_world;
    double sum = 0;
    for (int i = 1; i < scene.frames; ++i) {
      const auto f = static_cast<std::size_t>(i);
      const SE3 told = path[f - 1].inverse() * path[f];
      sum += (told.translation() - Eigen::Vector3d(0.02, 0, 0)).norm();
    }
    return sum / (scene.frames - 1);
  };
  EXPECT_LT(error_after(1), 0.7 * error_after(0));
}

TEST(Encoder, CarriedCameraIsFoundAndWhatMovesStaysWhereItIsInTheWorld) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.moving_camera = true;
  write_box_capture(folder, scene);
  Listener listener;
  auto options = quick_options();
  options.holdout = 5;
  encode::EncodeResult result = encode_folder(folder, options, listener);
  EXPECT_EQ(result.report.at("camera").at("path"), "moving");
  EXPECT_EQ(result.report.at("capture").at("has_poses"), false);
  ASSERT_EQ(result.clip.camera_to_world.size(), 14U);
  for (int i = 0; i < 14; ++i) {
    const SE3& found = result.clip.camera_to_world[static_cast<std::size_t>(i)];
    EXPECT_LT((found.translation() - scene.camera_to_world(i).translation()).norm(), 0.008) << i;
  }

  const player::Player player(std::move(result.clip));
  evaluate::EvaluateOptions how;
  how.ground_truth = true;
  const Json quality = evaluate::evaluate_against(folder.path(), host::PluginTable::builtin(), player, how, listener);
  EXPECT_GT(layer_named(quality, "object").at("held_out").at("psnr_box").get<double>(), 17);
  EXPECT_GT(layer_named(quality, "background").at("held_out").at("psnr").get<double>(), 27);
  EXPECT_LT(layer_named(quality, "background").at("held_out").at("depth_error_median").get<double>(), 0.012);
  EXPECT_LT(quality.at("ground_truth").at("object_pose").at("error_m_mean").get<double>(), 0.008);
}

TEST(Encoder, ColourOfACarriedCameraIsRegisteredToItsDepth) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.poses = true;
  scene.frames = 16;
  scene.color_zoom = 0.9;
  write_box_capture(folder, scene);
  for (int i = 0; i < scene.frames; ++i) {
    std::filesystem::remove(folder.path() / ("frame-" + six_digits(i) + ".pose.txt"));
  }
  Listener listener;
  const encode::PreparedCapture prepared = prepare_folder(folder, {}, listener);
  ASSERT_TRUE(prepared.registration.geometry);
  EXPECT_NEAR(prepared.registration.geometry->color.fx, scene.color_intrinsics().fx, 3);
  EXPECT_TRUE(prepared.capture->info().has_poses);
  ASSERT_EQ(prepared.camera->camera_to_world.size(), 16U);
  for (const auto& [i, found] : prepared.camera->camera_to_world) {
    EXPECT_LT((found.translation() - scene.camera_to_world(i).translation()).norm(), 0.01) << i;
  }
}

TEST(Encoder, StillCameraWithoutPosesIsStoredOnce) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 6;
  write_box_capture(folder, scene);
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  const encode::EncodeResult result = encode_folder(folder, options, listener);
  EXPECT_EQ(result.report.at("camera").at("path"), "still");
  ASSERT_EQ(result.clip.camera_to_world.size(), 1U);
  EXPECT_EQ(result.clip.camera_to_world[0].matrix(), SE3::Identity().matrix());
}

TEST(Encoder, RemembersTheCamerasThatRegisteredTheCapture) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.poses = true;
  scene.frames = 10;
  scene.color_zoom = 0.7;
  write_box_capture(folder, scene);
  Listener listener;
  const auto table = host::PluginTable::builtin();
  ingest::CaptureOptions how;
  how.registration = {scene.intrinsics(), scene.color_intrinsics(), SE3::Identity()};
  clip::Clip clip = encode::encode_capture(prepare_folder(folder, how, listener), quick_options(), listener).clip;
  EXPECT_EQ(clip.intrinsics, scene.color_intrinsics());

  const auto quality = [&](clip::Clip evaluated) {
    const player::Player player(std::move(evaluated));
    return layer_named(evaluate::evaluate_against(folder.path(), table, player, {}, listener), "background")
        .at("trained");
  };
  const Json registered = quality(clip);
  EXPECT_GT(registered.at("depth_coverage").get<double>(), 0.97);
  // As the capture has it, depth fills the picture; the colour camera sees it in the middle.
  clip.metadata.erase("registration");
  EXPECT_GT(quality(clip).at("depth_error_median").get<double>(),
            5 * registered.at("depth_error_median").get<double>());
}

TEST(Encoder, ObjectThatNeverMovesIsStoredWithoutMotion) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 5;
  write_box_capture(folder, scene);
  for (int i = 1; i < scene.frames; ++i) {
    for (const char* part : {"color/", "depth/", "mask/"}) {
      std::filesystem::copy_file(folder.path() / (part + six_digits(0) + ".png"),
                                 folder.path() / (part + six_digits(i) + ".png"),
                                 std::filesystem::copy_options::overwrite_existing);
    }
  }
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  const encode::EncodeResult result = encode_folder(folder, options, listener);
  const Json object = layer_named(result.report, "object");
  EXPECT_EQ(object.at("motion").at("kind"), "still");
  EXPECT_NE(object.at("why").get<std::string>().find("never moves"), std::string::npos);
}

TEST(Encoder, LabelsFileRenamesAndStillsAnObject) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 4;
  write_box_capture(folder, scene);
  folder.write("labels.json", R"({"1": {"name": "ball", "kind": "rigid"}, "2": {"name": "crate", "kind": "still"}})");
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  const encode::EncodeResult result = encode_folder(folder, options, listener);
  ASSERT_EQ(result.clip.layers.size(), 3U);
  EXPECT_EQ(result.clip.layers[1].name, "ball");
  EXPECT_EQ(result.clip.layers[2].name, "crate");
  EXPECT_EQ(result.clip.layers[2].motion.kind(), motion::MotionKind::kStill);
}

TEST(Encoder, WithoutLabelsEverythingIsBackground) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 3;
  write_box_capture(folder, scene);
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  ingest::CaptureOptions how;
  how.use_masks = false;
  const auto table = host::PluginTable::builtin();
  encode::PreparedCapture unlabelled;
  unlabelled.capture = ingest::Capture::open(table, folder.path(), how, listener);
  const encode::EncodeResult result = encode::encode_capture(std::move(unlabelled), options, listener);
  ASSERT_EQ(result.clip.layers.size(), 1U);
  EXPECT_EQ(result.clip.layers[0].name, "background");
  EXPECT_TRUE(listener.warnings.empty());
}

TEST(Encoder, TriesBothGeometriesForEachLayerAndSaysWhichDrewItBetter) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 8;
  write_box_capture(folder, scene);
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  options.settings.budget.try_geometries = true;
  const encode::EncodeResult result = encode_folder(folder, options, listener);
  ASSERT_FALSE(result.clip.layers.empty());
  for (std::size_t i = 0; i < result.clip.layers.size(); ++i) {
    const Json& geometry = result.report.at("layers")[i].at("geometry");
    EXPECT_EQ(geometry.at("chosen"), fields::name_of(result.clip.layers[i].field.config.geometry));
    EXPECT_EQ(geometry.at("frames"), 3);
    for (const char* name : {"density", "signed_distance"}) {
      EXPECT_GT(geometry.at(name).at("color_rms"), 0) << name;
      EXPECT_GT(geometry.at(name).at("depth_median_m"), 0) << name;
    }
  }
}

TEST(Encoder, DamagedFrameIsSkippedAndCounted) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 5;
  write_box_capture(folder, scene);
  std::filesystem::resize_file(folder.path() / "depth/000002.png", 100);
  Listener listener;
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  const encode::EncodeResult result = encode_folder(folder, options, listener);
  EXPECT_EQ(result.clip.capture_frames, (std::vector<int>{0, 1, 3, 4}));
  const Json& skipped = result.report.at("capture").at("skipped");
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_EQ(skipped[0].at("frame"), 2);
  EXPECT_NE(skipped[0].at("reason").get<std::string>().find("000002.png"), std::string::npos);
}

TEST(Encoder, SameBytesForOneThreadAndTwo) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 5;
  write_box_capture(folder, scene);
  auto options = quick_options();
  options.settings.budget.rays_per_pixel = 0.8;
  std::vector<std::string> files;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    Listener listener;
    const encode::EncodeResult result = encode_folder(folder, options, listener);
    const std::filesystem::path path = folder.path() / "clip.mkv";
    clip::write_clip(result.clip, path);
    std::ifstream file(path, std::ios::binary);
    files.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  set_thread_count(0);
  EXPECT_FALSE(files[0].empty());
  EXPECT_TRUE(files[0] == files[1]); // they are too long to be printed
}

TEST(Encoder, StopsWhenCancelledWhileReadingAndWhileTraining) {
  const TemporaryFolder folder;
  BoxScene scene;
  scene.frames = 4;
  write_box_capture(folder, scene);
  for (const std::size_t stop_at : {std::size_t{2}, std::size_t{5}}) {
    Listener listener;
    listener.stop_at = stop_at;
    try {
      encode_folder(folder, quick_options(), listener);
      FAIL() << "it went on";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
    }
  }
}

} // namespace
} // namespace kinora::test
