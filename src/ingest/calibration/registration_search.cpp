#include "ingest/calibration/registration_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "ingest/frame/reduced_view.h"
#include "ingest/opencv/opencv_functions.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kMaxFrames = 600;
constexpr std::size_t kMaxViews = 24;
constexpr std::size_t kNeighbours = 10; ///< later views that a view is compared with
constexpr double kNewViewAngle = 0.05;  ///< radians that the camera must have turned since the last view …
constexpr double kNewViewMove = 0.05;   ///< … or metres that it must have moved
constexpr double kPointsPerView = 3000; ///< that are looked up in other views
constexpr std::size_t kMinPoints = 200;
constexpr std::array<double, 4> kBlurs{80, 160, 320, 640}; ///< image widths per standard deviation, coarse to fine
constexpr double kMaxZoom = 0.25;                          ///< logarithm of the focal length's factor that is searched
constexpr double kZoomStep = 0.02;
constexpr int kMaxSteps = 20;            ///< of Gauss–Newton, at each blur
constexpr double kOutlier = 0.3;         ///< difference in brightness, of its standard deviation (Cauchy's estimator)
constexpr double kShiftPrior = 1.0 / 64; ///< of the image's width: standard deviation of the principal point's error
constexpr double kNoise = 0.2;           ///< difference in brightness, of its standard deviation
constexpr double kIndependent = 2;       ///< points of a pair that are worth something: they err together by its poses
constexpr double kMaxUnexplainedRatio = 0.7; ///< share of the unexplained that may be left
constexpr double kMaxUnexplained = 0.2;      ///< more unexplained: the poses are wrong too, or everything moves
constexpr std::size_t kValidationStride = 3; ///< every third pair judges and is not fitted to
constexpr double kMinContrast = 2;           ///< of 255: standard deviation of the brightness

/// Logarithm of the focal length's factor, and the shift of the principal point in pixels. (Where the colour camera
/// stands, a few centimetres away, a camera that mostly turns does not tell.)
using Parameters = Eigen::Vector3d;

double square(double x) { return x * x; }

struct View {
  std::array<Image<float>, kBlurs.size()> brightness;
  DepthImage depth;
  SE3 camera_to_world;
};

/// Points of one surface that two views see, in the depth camera of each.
struct Pair {
  std::size_t a, b;
  std::vector<Eigen::Vector3d> in_a, in_b;
};

View view_of(Frame&& frame) {
  View view;
  Image<float> luma(frame.color.width(), frame.color.height());
  for (int v = 0; v < luma.height(); ++v) {
    for (int u = 0; u < luma.width(); ++u) {
      const std::uint8_t* rgb = frame.color.pixel(u, v);
      luma.at(u, v) = 0.299F * rgb[0] + 0.587F * rgb[1] + 0.114F * rgb[2];
    }
  }
  for (std::size_t i = 0; i < kBlurs.size(); ++i) {
    view.brightness[i] = opencv_functions().gaussian_blur(luma, luma.width() / kBlurs[i]);
  }
  view.depth = std::move(frame.clean_depth);
  view.camera_to_world = frame.camera.camera_to_world;
  return view;
}

std::vector<View> views_of(Capture& capture, Progress& progress) {
  std::vector<View> views;
  for (std::size_t i = 0; i < kMaxFrames && views.size() < kMaxViews; ++i) {
    progress.check();
    auto frame = capture.next();
    if (!frame) break;
    if (!views.empty()) {
      const SE3 motion = views.back().camera_to_world.inverse() * frame->camera.camera_to_world;
      if (rotation_angle(motion) < kNewViewAngle && motion.translation().norm() < kNewViewMove) continue;
    }
    views.push_back(view_of(std::move(*frame)));
    progress.advance(i + 1, "");
  }
  return views;
}

Pair pair_of(const std::vector<View>& views, std::size_t a, std::size_t b, const Intrinsics& k) {
  Pair pair{a, b, {}, {}};
  const DepthImage& seen_by_a = views[a].depth;
  const DepthImage& seen_by_b = views[b].depth;
  const SE3 a_to_b = views[b].camera_to_world.inverse() * views[a].camera_to_world;
  const int stride = std::max(1, static_cast<int>(std::sqrt(k.width * k.height / kPointsPerView)));
  for (int v = stride / 2; v < k.height; v += stride) {
    for (int u = stride / 2; u < k.width; u += stride) {
      const float z = seen_by_a.at(u, v);
      if (!(z > 0)) continue;
      const Eigen::Vector3d in_a = k.unproject(u, v, z);
      const Eigen::Vector3d in_b = a_to_b * in_a;
      if (!(in_b.z() > 0)) continue;
      const Eigen::Vector2d pixel = k.project(in_b);
      if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) continue;
      const int x = static_cast<int>(std::lround(pixel.x()));
      const int y = static_cast<int>(std::lround(pixel.y()));
      if (!seen_by_b.contains(x, y) || !(seen_by_b.at(x, y) > 0)) continue;
      if (std::abs(seen_by_b.at(x, y) - in_b.z()) > same_surface_tolerance(in_b.z())) continue;
      pair.in_a.push_back(in_a);
      pair.in_b.push_back(in_b);
    }
  }
  return pair;
}

std::vector<Pair> pairs_of(const std::vector<View>& views, const Intrinsics& intrinsics) {
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < views.size(); ++a) {
    for (std::size_t b = a + 1; b < std::min(a + 1 + kNeighbours, views.size()); ++b) {
      Pair pair = pair_of(views, a, b, intrinsics);
      if (pair.in_a.size() >= kMinPoints) pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

Intrinsics color_camera(const Intrinsics& claimed, const Parameters& x) {
  Intrinsics color = claimed;
  color.fx *= std::exp(x[0]);
  color.fy *= std::exp(x[0]);
  color.cx += x[1];
  color.cy += x[2];
  return color;
}

/// Brightness of the view where a point falls, and its change with the parameters.
struct BrightnessSample {
  double brightness;
  Parameters gradient;
};

std::optional<BrightnessSample> sample_brightness(const Image<float>& image, const Eigen::Vector3d& point,
                                                  const Intrinsics& k) {
  const Eigen::Vector2d pixel = k.project(point);
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < image.width() - 1 && pixel.y() < image.height() - 1)) {
    return std::nullopt;
  }
  const int u = static_cast<int>(pixel.x());
  const int v = static_cast<int>(pixel.y());
  const double x = pixel.x() - u;
  const double y = pixel.y() - v;
  const float* above = image.pixel(u, v);
  const float* below = image.pixel(u, v + 1);
  const double along_u = (1 - y) * (above[1] - above[0]) + y * (below[1] - below[0]);
  const double along_v = (1 - x) * (below[0] - above[0]) + x * (below[1] - above[1]);
  BrightnessSample seen;
  seen.brightness = (1 - y) * ((1 - x) * above[0] + x * above[1]) + y * ((1 - x) * below[0] + x * below[1]);
  seen.gradient = {along_u * (pixel.x() - k.cx) + along_v * (pixel.y() - k.cy), along_u, along_v};
  return seen;
}

/// What a pair says of a colour camera.
struct Evidence {
  double unexplained = 0; ///< 1 − correlation
  double cost = 0;        ///< robust mean square, to which information and gradient belong
  double weight = 0;      ///< 0: it says nothing
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Parameters gradient = Parameters::Zero();
};

// To mean 0 and variance 1; false if there is nothing to see. Exposure then does not matter.
bool normalise(std::vector<BrightnessSample>& samples) {
  const auto count = static_cast<double>(samples.size());
  BrightnessSample mean{0, Parameters::Zero()};
  for (const BrightnessSample& seen : samples)
    mean = {mean.brightness + seen.brightness, mean.gradient + seen.gradient};
  mean = {mean.brightness / count, mean.gradient / count};
  double variance = 0;
  for (const BrightnessSample& seen : samples) variance += square(seen.brightness - mean.brightness) / count;
  const double deviation = std::sqrt(variance);
  if (deviation < kMinContrast) return false;
  Parameters growth = Parameters::Zero(); // of the deviation, relative to it
  for (BrightnessSample& seen : samples) {
    seen = {(seen.brightness - mean.brightness) / deviation, (seen.gradient - mean.gradient) / deviation};
    growth += seen.brightness * seen.gradient / count;
  }
  for (BrightnessSample& seen : samples) seen.gradient -= seen.brightness * growth;
  return true;
}

Evidence evidence_of(const Pair& pair, const std::vector<View>& views, std::size_t blur, const Intrinsics& color) {
  std::vector<BrightnessSample> from_a, from_b;
  for (std::size_t i = 0; i < pair.in_a.size(); ++i) {
    const auto a = sample_brightness(views[pair.a].brightness[blur], pair.in_a[i], color);
    const auto b = sample_brightness(views[pair.b].brightness[blur], pair.in_b[i], color);
    if (!a || !b) continue;
    from_a.push_back(*a);
    from_b.push_back(*b);
  }
  Evidence evidence;
  if (from_a.size() < kMinPoints || !normalise(from_a) || !normalise(from_b)) return evidence;
  evidence.weight = 1;
  for (std::size_t i = 0; i < from_a.size(); ++i) {
    const double difference = from_a[i].brightness - from_b[i].brightness;
    const Parameters gradient_difference = from_a[i].gradient - from_b[i].gradient;
    const double outlying = square(difference / kOutlier);
    const double sample_weight = 1 / ((1 + outlying) * static_cast<double>(from_a.size()));
    evidence.information += sample_weight * gradient_difference * gradient_difference.transpose();
    evidence.gradient += sample_weight * difference * gradient_difference;
    evidence.cost += square(kOutlier) * std::log1p(outlying) / static_cast<double>(from_a.size());
    evidence.unexplained += 0.5 * square(difference) / static_cast<double>(from_a.size());
  }
  return evidence;
}

/// The pairs together; the colour camera is fitted to some and judged by the others.
class Pairs {
public:
  Pairs(const std::vector<View>& views, std::vector<Pair> pairs, const Intrinsics& claimed)
      : views_(views), pairs_(std::move(pairs)), claimed_(claimed) {}

  /// `unexplained` is the mean over the pairs; `weight` counts them.
  Evidence evidence(const Parameters& x, std::size_t blur, bool validating) const {
    const Intrinsics color = color_camera(claimed_, x);
    std::vector<Evidence> parts(pairs_.size());
    parallel_for(pairs_.size(), 1, [&](const Chunk& chunk) {
      if ((chunk.index % kValidationStride == kValidationStride - 1) != validating) return;
      parts[chunk.index] = evidence_of(pairs_[chunk.index], views_, blur, color);
    });
    Evidence all;
    for (const Evidence& part : parts) {
      all.weight += part.weight;
      all.unexplained += part.unexplained;
      all.cost += part.cost;
      all.information += part.information;
      all.gradient += part.gradient;
    }
    if (all.weight > 0) all.unexplained /= all.weight;
    return all;
  }

  Parameters fit() const {
    Parameters best = coarse_zoom();
    for (std::size_t blur = 0; blur < kBlurs.size(); ++blur) {
      Evidence evidence_at_best = evidence(best, blur, false);
      for (int i = 0; i < kMaxSteps; ++i) {
        const Parameters next = best + step(best, evidence_at_best);
        const Evidence evidence_at_next = evidence(next, blur, false);
        if (!(evidence_at_next.weight >= evidence_at_best.weight &&
              cost(next, evidence_at_next) < cost(best, evidence_at_best)))
          break;
        best = next;
        evidence_at_best = evidence_at_next;
      }
    }
    return best;
  }

private:
  Parameters coarse_zoom() const {
    Parameters best = Parameters::Zero();
    double min_unexplained = evidence(best, 0, false).unexplained;
    const int steps = static_cast<int>(kMaxZoom / kZoomStep);
    for (int i = -steps; i <= steps; ++i) {
      Parameters x = Parameters::Zero();
      x[0] = i * kZoomStep;
      const Evidence evidence_here = evidence(x, 0, false);
      if (evidence_here.weight == 0 || evidence_here.unexplained >= min_unexplained) continue;
      min_unexplained = evidence_here.unexplained;
      best = x;
    }
    return best;
  }

  // What no view tells stays as claimed: two cameras in one housing are near each other.
  Parameters prior() const {
    const double shift = kShiftPrior * claimed_.width;
    return {1 / (kMaxZoom * kMaxZoom), 1 / (shift * shift), 1 / (shift * shift)};
  }

  double cost(const Parameters& x, const Evidence& evidence) const {
    return kPairWeight * evidence.cost + prior().dot(x.cwiseAbs2());
  }

  Parameters step(const Parameters& x, const Evidence& evidence) const {
    const Eigen::Matrix3d information = kPairWeight * evidence.information + Eigen::Matrix3d(prior().asDiagonal());
    return information.ldlt().solve(-kPairWeight * evidence.gradient - prior().cwiseProduct(x));
  }

  static constexpr double kPairWeight = kIndependent / (kNoise * kNoise); // of a pair's mean squared difference

  const std::vector<View>& views_;
  std::vector<Pair> pairs_;
  Intrinsics claimed_;
};

} // namespace

FoundRegistration search_registration(Capture& capture, Progress& progress) {
  FoundRegistration found;
  const CaptureInfo& info = capture.info();
  if (!info.has_poses || info.has_depth_camera) return found;
  progress.stage("comparing colour with depth", kMaxViews);
  const std::vector<View> views = views_of(capture, progress);
  std::vector<Pair> points = pairs_of(views, info.intrinsics);
  found.pairs = points.size();
  const Pairs pairs(views, std::move(points), info.intrinsics);
  constexpr std::size_t kFinest = kBlurs.size() - 1;
  const Evidence as_given = pairs.evidence(Parameters::Zero(), kFinest, true);
  if (as_given.weight == 0) return {};
  const Parameters best = pairs.fit();
  const Evidence evidence_with_best = pairs.evidence(best, kFinest, true);
  found.unexplained_as_given = as_given.unexplained;
  found.unexplained = evidence_with_best.unexplained;
  const bool clearly = evidence_with_best.weight >= as_given.weight &&
                       evidence_with_best.unexplained < kMaxUnexplainedRatio * as_given.unexplained &&
                       evidence_with_best.unexplained < kMaxUnexplained;
  if (clearly) {
    found.geometry = RegistrationGeometry{info.intrinsics, color_camera(info.intrinsics, best), SE3::Identity()};
  }
  return found;
}

} // namespace kinora::ingest
