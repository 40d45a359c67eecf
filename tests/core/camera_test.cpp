#include "core/camera.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace kinora {
namespace {

constexpr Intrinsics kKinect{640, 480, 525.0, 520.0, 319.5, 239.5};

TEST(Camera, ProjectionUndoesUnprojection) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double u = 700 * random.uniform_double() - 30;
    const double v = 500 * random.uniform_double() - 10;
    const double depth = 0.1 + 1000 * random.uniform_double();
    const Eigen::Vector3d point = kKinect.unproject(u, v, depth);
    EXPECT_EQ(point.z(), depth);
    EXPECT_LT((kKinect.project(point) - Eigen::Vector2d(u, v)).norm(), 1e-9);
  }
}

TEST(Camera, LooksForwardWithXRightAndYDown) {
  EXPECT_EQ(kKinect.project({0, 0, 2}), Eigen::Vector2d(319.5, 239.5));
  EXPECT_GT(kKinect.project({0.1, 0, 2}).x(), 319.5);
  EXPECT_GT(kKinect.project({0, 0.1, 2}).y(), 239.5);
}

TEST(Camera, ResizingKeepsTheImageCornersInPlace) {
  const Intrinsics half = kKinect.resized(320, 240);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  // Corners lie half a pixel outside of the first and the last pixel's centre, in both sizes.
  const Eigen::Vector3d first = kKinect.unproject(-0.5, -0.5, 1.0);
  const Eigen::Vector3d last = kKinect.unproject(639.5, 479.5, 1.0);
  EXPECT_LT((half.project(first) - Eigen::Vector2d(-0.5, -0.5)).norm(), 1e-9);
  EXPECT_LT((half.project(last) - Eigen::Vector2d(319.5, 239.5)).norm(), 1e-9);
}

TEST(Camera, ResizingThereAndBackIsTheSameCamera) {
  const Intrinsics back = kKinect.resized(1234, 77).resized(640, 480);
  EXPECT_NEAR(back.fx, kKinect.fx, 1e-9);
  EXPECT_NEAR(back.fy, kKinect.fy, 1e-9);
  EXPECT_NEAR(back.cx, kKinect.cx, 1e-9);
  EXPECT_NEAR(back.cy, kKinect.cy, 1e-9);
}

TEST(IntrinsicsValidation, AcceptsRealCameras) {
  EXPECT_NO_THROW(kKinect.validate("intrinsics.json"));
  EXPECT_NO_THROW((Intrinsics{1, 1, 1.0, 1.0, 0.0, 0.0}).validate("intrinsics.json"));
  EXPECT_NO_THROW((Intrinsics{960, 540, 613.8, 613.9, 485.2, 271.1}).validate("intrinsics.json"));
}

void expect_rejected(const Intrinsics& intrinsics) {
  try {
    intrinsics.validate("intrinsics.json");
    ADD_FAILURE() << "accepted " << intrinsics.width << "x" << intrinsics.height << " fx " << intrinsics.fx << " cx "
                  << intrinsics.cx;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_NE(std::string(error.what()).find("intrinsics.json"), std::string::npos) << error.what();
  }
}

TEST(IntrinsicsValidation, RejectsWhatNoCameraHas) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double focal : {0.0, -525.0, 1e-6, 1e12, kNan, kInfinity}) {
    expect_rejected({640, 480, focal, 525, 319.5, 239.5});
    expect_rejected({640, 480, 525, focal, 319.5, 239.5});
  }
  for (const double centre : {kNan, -kInfinity, 1e9, -1e9}) {
    expect_rejected({640, 480, 525, 525, centre, 239.5});
    expect_rejected({640, 480, 525, 525, 319.5, centre});
  }
  for (const int side : {0, -1, 16385, std::numeric_limits<int>::max()}) {
    expect_rejected({side, 480, 525, 525, 319.5, 239.5});
    expect_rejected({640, side, 525, 525, 319.5, 239.5});
  }
}

} // namespace
} // namespace kinora
