// Model size by need: box, resolution and tables follow from what was seen of the layer.
#include <gtest/gtest.h>

#include "fields/training/trainer.h"

namespace kinora::fields {
namespace {

constexpr int kBoard = 1;

/// A flat board, `width` by `height` metres, that faces the camera `depth` metres before it, `right` of its axis;
/// behind it is a wall.
struct Board {
  double depth = 1;
  double width = 0.7;
  double height = 0.7;
  double right = 0;

  ingest::Frame frame() const {
    ingest::Frame frame;
    frame.camera.intrinsics = {320, 240, 300, 300, 159.5, 119.5};
    frame.color = ColorImage(320, 240, 3);
    frame.depth = DepthImage(320, 240);
    frame.labels = LabelImage(320, 240);
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u) {
        const Eigen::Vector3d p = frame.camera.intrinsics.unproject(u, v, depth);
        const bool board = std::abs(p.x() - right) < width / 2 && std::abs(p.y()) < height / 2;
        frame.depth.at(u, v) = static_cast<float>(board ? depth : 6.0);
        frame.labels.at(u, v) = board ? kBoard : 0;
      }
    }
    frame.clean_depth = frame.depth;
    return frame;
  }
};

struct Chosen {
  FieldConfig config;
  FieldRequirements requirements;
};

Chosen choose(const std::vector<ingest::Frame>& frames, const motion::Motion& motion = motion::Motion::still()) {
  PixelStore store(1'000'000, frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) store.add(frames[i], static_cast<int>(i));
  Chosen chosen;
  chosen.config = choose_field_config({store, kBoard, motion}, &chosen.requirements);
  return chosen;
}

TEST(FieldSize, HalvesItsCellsPerSideForASurfaceSeenFromTwiceAsFar) {
  const Chosen near = choose({Board{.depth = 1}.frame()});
  const Chosen far = choose({Board{.depth = 2}.frame()});
  EXPECT_NEAR(near.requirements.footprint, 1 / 300.0, 1e-6);
  EXPECT_NEAR(near.config.cell_size(), near.requirements.footprint, 0.01 * near.requirements.footprint);
  EXPECT_NEAR(static_cast<double>(far.config.finest_resolution) / near.config.finest_resolution, 0.5, 0.02);
}

TEST(FieldSize, IsThatOfTheNearestLooks) {
  const Chosen both = choose({Board{.depth = 2}.frame(), Board{.depth = 1}.frame()});
  EXPECT_NEAR(both.requirements.footprint, 1 / 300.0, 1e-6);
}

TEST(FieldSize, HoldsTheLayerAndLittleElse) {
  ingest::Frame frame = Board{}.frame();
  for (int k = 0; k < 10; ++k) frame.clean_depth.at(150 + k, 120) = 5; // stray measurements
  const FieldBox box = choose({frame}).config.box;
  for (const double corner : {-0.35, 0.35}) {
    const Eigen::Vector3d in_box = (Eigen::Vector3d(corner, corner, 1) - box.origin) / box.side;
    EXPECT_GT(in_box.minCoeff(), 0);
    EXPECT_LT(in_box.maxCoeff(), 1);
  }
  EXPECT_LT(box.side, 0.7 + 2 * 0.03);
}

TEST(FieldSize, IsThatOfTheLayerAndNotOfItsWay) {
  std::vector<ingest::Frame> frames;
  std::vector<motion::Motion::Pose> poses;
  for (const double right : {0.0, 0.1, 0.2}) {
    frames.push_back(Board{.width = 0.5, .height = 0.5, .right = right}.frame());
    motion::Motion::Pose pose;
    pose.canonical_to_world.translation().x() = right;
    poses.push_back(pose);
  }
  EXPECT_NEAR(choose(frames).config.box.side, choose({frames[0]}).config.box.side + 0.2, 0.005);
  EXPECT_NEAR(choose(frames, motion::Motion::rigid(poses)).config.box.side, choose({frames[0]}).config.box.side, 0.005);
}

TEST(FieldSize, GivesMoreSurfaceLargerTables) {
  const Chosen strip = choose({Board{.height = 0.07}.frame()});
  const Chosen board = choose({Board{}.frame()});
  EXPECT_EQ(strip.config.finest_resolution, board.config.finest_resolution);
  EXPECT_NEAR(board.requirements.surface_cells, std::pow(0.7 * 300, 2), 0.1 * std::pow(0.7 * 300, 2));
  EXPECT_NEAR(strip.requirements.surface_cells / board.requirements.surface_cells, 0.1, 0.03);
  EXPECT_EQ(strip.config.log2_table_size, 13);
  EXPECT_EQ(board.config.log2_table_size, 15);
}

} // namespace
} // namespace kinora::fields
