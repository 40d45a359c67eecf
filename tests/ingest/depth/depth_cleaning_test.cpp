#include "ingest/depth/depth_cleaning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "support/every_instruction_set.h"

namespace kinora::ingest {
namespace {

constexpr Intrinsics kCamera{64, 48, 60, 60, 31.5, 23.5};

/// A plane through (0, 0, z) whose normal is turned by `angle` about the vertical axis, with the sensor's noise.
DepthImage plane(double z, double angle, double sigmas = 0) {
  DepthImage depth(kCamera.width, kCamera.height);
  Random random(7);
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const double x = (u - kCamera.cx) / kCamera.fx;
      const double measured = z * std::cos(angle) / (std::cos(angle) + x * std::sin(angle));
      if (measured > 0.2 && measured < 15)
        depth.at(u, v) = static_cast<float>(measured + sigmas * kSensorNoise.sigma(measured) * random.normal());
    }
  }
  return depth;
}

int kept(const DepthImage& depth) {
  return static_cast<int>(std::count_if(depth.values().begin(), depth.values().end(), [](float z) { return z > 0; }));
}

TEST(DepthCleaning, KeepsAPlaneSeenFromTheFront) {
  const DepthImage depth = plane(2, 0);
  EXPECT_EQ(kept(clean_depth(depth, kCamera)), kCamera.width * kCamera.height);
}

TEST(DepthCleaning, KeepsNoisyPlanesAtEveryDistance) {
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const DepthImage depth = plane(z, 0.2, 1);
    EXPECT_GT(kept(clean_depth(depth, kCamera)), 0.97 * kCamera.width * kCamera.height) << z;
  }
}

TEST(DepthCleaning, NeverChangesWhatItKeeps) {
  const DepthImage depth = plane(2, 0.8, 1);
  const DepthImage clean = clean_depth(depth, kCamera);
  for (std::size_t i = 0; i < depth.pixel_count(); ++i)
    EXPECT_TRUE(clean.data()[i] == 0 || clean.data()[i] == depth.data()[i]);
}

TEST(DepthCleaning, DropsTwoPixelsOnBothSidesOfAnEdge) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < 30; ++u) depth.at(u, v) = 1.5F;
  const DepthImage clean = clean_depth(depth, kCamera);
  for (int u = 0; u < depth.width(); ++u) EXPECT_EQ(clean.at(u, 20) == 0, u >= 28 && u <= 31) << u;
}

TEST(DepthCleaning, DropsALonePixelAndNothingAroundIt) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  depth.at(20, 20) = 1.7F;
  const DepthImage clean = clean_depth(depth, kCamera);
  EXPECT_EQ(clean.at(20, 20), 0);
  EXPECT_EQ(kept(clean), kCamera.width * kCamera.height - 1);
}

TEST(DepthCleaning, LosesLittleMoreThanTheSaltItself) {
  DepthImage depth = plane(2, 0.3, 1);
  Random random(5);
  int salted = 0;
  for (float& z : depth.values()) {
    if (random.below(10) > 0) continue;
    z = 0.3F + 4 * random.uniform();
    ++salted;
  }
  EXPECT_GT(kept(clean_depth(depth, kCamera)), 0.8 * (kCamera.width * kCamera.height - salted));
}

TEST(DepthCleaning, DropsWhatFliesBetweenTwoSurfaces) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < 30; ++u) depth.at(u, v) = 1.5F;
    depth.at(30, v) = v % 2 == 0 ? 1.65F : 1.85F;
  }
  const DepthImage clean = clean_depth(depth, kCamera);
  for (int u = 0; u < depth.width(); ++u) EXPECT_EQ(clean.at(u, 20) == 0, u >= 28 && u <= 32) << u;
}

TEST(DepthCleaning, ErodesOnePixelAroundHolesButNotAtTheImagesEdge) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  depth.at(20, 20) = 0;
  const DepthImage clean = clean_depth(depth, kCamera);
  EXPECT_EQ(kept(clean), kCamera.width * kCamera.height - 5);
  EXPECT_EQ(clean.at(21, 20), 0);
  EXPECT_GT(clean.at(21, 21), 0);
  EXPECT_GT(clean.at(0, 0), 0);
}

TEST(DepthCleaning, DropsSurfacesSeenAtLessThanTenDegrees) {
  // The angle between the plane and the central ray is 90° − angle.
  const auto centre_kept = [](double degrees) {
    const DepthImage clean = clean_depth(plane(1, degrees * EIGEN_PI / 180), kCamera, {.max_jump = 0.5});
    return clean.at(32, 24) > 0;
  };
  EXPECT_TRUE(centre_kept(60));
  EXPECT_TRUE(centre_kept(77));
  EXPECT_FALSE(centre_kept(83));
}

TEST(DepthCleaning, SmallStepsWithinTheNoiseAreNoEdges) {
  const auto step_kept = [](float z, float step) {
    DepthImage depth(kCamera.width, kCamera.height, 1, z);
    for (int v = 0; v < depth.height(); ++v)
      for (int u = 30; u < depth.width(); ++u) depth.at(u, v) = z + step;
    return clean_depth(depth, kCamera).at(30, 20) > 0;
  };
  EXPECT_TRUE(step_kept(2, 0.05F));
  EXPECT_FALSE(step_kept(2, 0.07F));
  EXPECT_TRUE(step_kept(8, 0.40F)); // σ(8 m) = 11 cm
  EXPECT_FALSE(step_kept(8, 0.60F));
}

TEST(DepthCleaning, ImagesOfOneRowOrColumnOrOnlyHolesAreFine) {
  EXPECT_EQ(kept(clean_depth(DepthImage(5, 1, 1, 1.0F), {5, 1, 5, 5, 2, 0})), 5);
  EXPECT_EQ(kept(clean_depth(DepthImage(1, 5, 1, 1.0F), {1, 5, 5, 5, 0, 2})), 5);
  EXPECT_EQ(kept(clean_depth(DepthImage(5, 5), {5, 5, 5, 5, 2, 2})), 0);
}

/// The same pixel by pixel.
class PlainCleaner {
public:
  PlainCleaner(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits)
      : measured_(depth), depth_(depth), intrinsics_(intrinsics), limits_(limits), jump_(depth.width(), depth.height()),
        left_(depth.width(), depth.height()), right_(depth.width(), depth.height()),
        above_(depth.width(), depth.height()), below_(depth.width(), depth.height()) {}

  DepthImage run() {
    const DepthImage valid = without_isolated();
    bridge_isolated(valid);
    mark_steps();
    DepthImage kept(depth_.width(), depth_.height());
    for (int v = 0; v < depth_.height(); ++v)
      for (int u = 0; u < depth_.width(); ++u)
        if (depth_.at(u, v) > 0 && jump_.at(u, v) == 0 && !grazing(u, v)) kept.at(u, v) = depth_.at(u, v);
    DepthImage result = eroded(kept);
    for (std::size_t i = 0; i < valid.values().size(); ++i)
      if (valid.values()[i] <= 0) result.values()[i] = 0;
    return result;
  }

private:
  static constexpr std::array<std::array<int, 2>, 4> kAround{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

  bool near_enough(float a, float b) const {
    const double z = std::min(a, b);
    return std::abs(a - b) <= std::max(limits_.max_jump * z, limits_.max_jump_sigmas * kSensorNoise.sigma(z));
  }

  static float or_none(const DepthImage& depth, int u, int v) { return depth.contains(u, v) ? depth.at(u, v) : 0; }

  /// Without pixels that jump to all of their neighbours, at least one.
  DepthImage without_isolated() const {
    DepthImage valid = measured_;
    for (int v = 0; v < valid.height(); ++v) {
      for (int u = 0; u < valid.width(); ++u) {
        int neighbours = 0;
        bool is_joined = false;
        for (const auto& [x, y] : kAround) {
          const float other = or_none(measured_, u + x, v + y);
          if (other <= 0) continue;
          ++neighbours;
          is_joined = is_joined || near_enough(measured_.at(u, v), other);
        }
        if (neighbours > 0 && !is_joined) valid.at(u, v) = 0;
      }
    }
    return valid;
  }

  void bridge_isolated(const DepthImage& valid) {
    for (int v = 0; v < valid.height(); ++v) {
      for (int u = 0; u < valid.width(); ++u) {
        if (measured_.at(u, v) <= 0 || valid.at(u, v) > 0) continue;
        float sum = 0;
        float count = 0;
        for (const auto& [x, y] : {kAround[1], kAround[3]}) {
          const float before = or_none(valid, u - x, v - y);
          const float after = or_none(valid, u + x, v + y);
          if (before <= 0 || after <= 0) continue;
          sum += before + after;
          count += 2;
        }
        if (count == 0) continue;
        const bool continues = std::all_of(kAround.begin(), kAround.end(), [&](const auto& step) {
          const float other = or_none(valid, u + step[0], v + step[1]);
          return other <= 0 || near_enough(other, sum / count);
        });
        if (continues) depth_.at(u, v) = sum / count;
      }
    }
  }

  /// True if a surface goes on from (u, v) to its neighbour; marks both if there is a jump between them.
  bool joined(int u, int v, int next_u, int next_v) {
    const float a = depth_.at(u, v);
    const float b = depth_.at(next_u, next_v);
    if (a <= 0 || b <= 0) return false;
    if (near_enough(a, b)) return true;
    jump_.at(u, v) = jump_.at(next_u, next_v) = 1;
    return false;
  }

  /// Fills in the jumps, and how many joined steps lead from each pixel in each direction.
  void mark_steps() {
    const int width = depth_.width();
    const int height = depth_.height();
    const auto longer = [this](std::uint8_t reach) {
      return static_cast<std::uint8_t>(std::min<int>(reach + 1, limits_.gradient_radius));
    };
    for (int v = 0; v < height; ++v) {
      for (int u = 1; u < width; ++u)
        if (joined(u - 1, v, u, v)) left_.at(u, v) = longer(left_.at(u - 1, v));
      for (int u = width - 1; u > 0; --u)
        if (left_.at(u, v) > 0) right_.at(u - 1, v) = longer(right_.at(u, v));
    }
    for (int v = 1; v < height; ++v)
      for (int u = 0; u < width; ++u)
        if (joined(u, v - 1, u, v)) above_.at(u, v) = longer(above_.at(u, v - 1));
    for (int v = height - 1; v > 0; --v)
      for (int u = 0; u < width; ++u)
        if (above_.at(u, v) > 0) below_.at(u, v - 1) = longer(below_.at(u, v));
  }

  /// Least-squares slope of depth per pixel at `z[0]`, over `behind` and `ahead` neighbours along `stride`.
  static float gradient(const float* z, std::ptrdiff_t stride, int behind, int ahead) {
    if (behind == ahead) { // the usual case: the mean of x vanishes
      float sum_xz = 0, sum_xx = 0;
      for (int x = 1; x <= ahead; ++x) {
        const auto fx = static_cast<float>(x);
        sum_xz += fx * (z[x * stride] - z[-x * stride]);
        sum_xx += 2 * fx * fx;
      }
      return ahead > 0 ? sum_xz / sum_xx : 0;
    }
    const float count = static_cast<float>(behind + ahead + 1);
    float sum_x = 0, sum_z = 0, sum_xx = 0, sum_xz = 0;
    for (int x = -behind; x <= ahead; ++x) {
      const auto fx = static_cast<float>(x);
      sum_x += fx;
      sum_z += z[x * stride];
      sum_xx += fx * fx;
      sum_xz += fx * z[x * stride];
    }
    return (count * sum_xz - sum_x * sum_z) / (count * sum_xx - sum_x * sum_x);
  }

  /// With z(u, v) the depth at a pixel, the normal is (fx·z_u, fy·z_v, −z − (u−cx)·z_u − (v−cy)·z_v) up to length, and
  /// its product with the ray ((u−cx)/fx, (v−cy)/fy, 1) is −z.
  bool grazing(int u, int v) const {
    const float* at = depth_.pixel(u, v);
    const double z = *at;
    const double z_u = gradient(at, 1, left_.at(u, v), right_.at(u, v));
    const double z_v = gradient(at, depth_.width(), above_.at(u, v), below_.at(u, v));
    const double x = u - intrinsics_.cx;
    const double y = v - intrinsics_.cy;
    const Eigen::Vector3d normal(intrinsics_.fx * z_u, intrinsics_.fy * z_v, -z - x * z_u - y * z_v);
    const Eigen::Vector3d ray(x / intrinsics_.fx, y / intrinsics_.fy, 1);
    return z * z < square_of_min_sine_ * normal.squaredNorm() * ray.squaredNorm();
  }

  static DepthImage eroded(const DepthImage& kept) {
    DepthImage result = kept;
    for (int v = 0; v < kept.height(); ++v) {
      for (int u = 0; u < kept.width(); ++u) {
        const bool border = (u > 0 && kept.at(u - 1, v) <= 0) || (u + 1 < kept.width() && kept.at(u + 1, v) <= 0) ||
                            (v > 0 && kept.at(u, v - 1) <= 0) || (v + 1 < kept.height() && kept.at(u, v + 1) <= 0);
        if (border) result.at(u, v) = 0;
      }
    }
    return result;
  }

  const DepthImage& measured_;
  DepthImage depth_; ///< lone pixels have the depth of the surface that they stand in
  const Intrinsics& intrinsics_;
  const DepthCleaning& limits_;
  const double square_of_min_sine_ = std::sin(limits_.min_incidence) * std::sin(limits_.min_incidence);
  Image<std::uint8_t> jump_; ///< 1 on both sides of a jump
  /// Number of joined steps in each direction, at most `gradient_radius`.
  Image<std::uint8_t> left_, right_, above_, below_;
};

class DepthCleaningOnEveryInstructionSet : public OnEveryInstructionSet {};

TEST_P(DepthCleaningOnEveryInstructionSet, KeepsWhatAPlainLoopKeeps) {
  Random random(3);
  int kept_pixels = 0;
  int different = 0; // where rounding decides
  for (const int width : {1, 5, 16, 50, 67}) {
    const Intrinsics camera{width, 41, 60, 62, 0.4 * width, 19};
    DepthImage depth(camera.width, camera.height);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const bool is_near = std::hypot(u - 20, v - 20) < 12;
        const double z = is_near ? 0.9 + 0.002 * (u - 20) * (u - 20) : 1.6 + 0.03 * v;
        const std::uint64_t fate = random.below(40);
        if (fate == 0) continue;
        depth.at(u, v) = static_cast<float>(z + (fate < 3 ? 0.3 : 0) + kSensorNoise.sigma(z) * random.normal());
      }
    }
    const DepthCleaning limits;
    const DepthImage found = clean_depth(depth, camera, limits);
    const DepthImage expected = PlainCleaner(depth, camera, limits).run();
    ASSERT_TRUE(found.same_size(expected));
    for (std::size_t i = 0; i < found.values().size(); ++i) {
      if (expected.values()[i] > 0) ++kept_pixels;
      if (found.values()[i] != expected.values()[i]) ++different;
    }
  }
  EXPECT_GT(kept_pixels, 1000);
  EXPECT_LE(different, 5);
}

INSTANTIATE_TEST_SUITE_P(Sets, DepthCleaningOnEveryInstructionSet, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::ingest
