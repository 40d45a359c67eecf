#include "tracking/body/shape_from_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tracking/body/body_energy.h"
#include "tracking/body/limbs.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kLengthSigma = 0.02; // logarithm: what joints tell of bones
constexpr double kGirthSigma = 0.06;  // clothes and hair

// SMPL's joints that ours have in common.
enum : std::size_t {
  kMeshLeftHip = 1,
  kMeshRightHip = 2,
  kMeshLeftKnee = 4,
  kMeshRightKnee = 5,
  kMeshLeftAnkle = 7,
  kMeshRightAnkle = 8,
  kMeshLeftShoulder = 16,
  kMeshRightShoulder = 17,
  kMeshLeftElbow = 18,
  kMeshRightElbow = 19,
  kMeshLeftWrist = 20,
  kMeshRightWrist = 21
};

struct MeshLimb {
  Limb limb;
  std::size_t ball, hinge, end;
};
constexpr std::array<MeshLimb, kLimbs> kMeshLimbs = {{{kLeftArm, kMeshLeftShoulder, kMeshLeftElbow, kMeshLeftWrist},
                                                      {kRightArm, kMeshRightShoulder, kMeshRightElbow, kMeshRightWrist},
                                                      {kLeftLeg, kMeshLeftHip, kMeshLeftKnee, kMeshLeftAnkle},
                                                      {kRightLeg, kMeshRightHip, kMeshRightKnee, kMeshRightAnkle}}};

double distance(const ingest::BodyMesh& mesh, std::size_t a, std::size_t b) {
  return (mesh.joints.at(a) - mesh.joints.at(b)).norm();
}

double height_of(const ingest::BodyMesh& mesh) {
  double top = -1e300;
  double bottom = 1e300;
  for (const auto& face : mesh.faces) {
    for (const std::size_t vertex : face) {
      top = std::max(top, mesh.vertices[vertex].y());
      bottom = std::min(bottom, mesh.vertices[vertex].y());
    }
  }
  return top - bottom;
}

// Logarithm of a length against that of mean proportions; within reason, whatever the file says.
double measure(double length, double height, Joint joint) {
  const double mean = height * joints()[joint].offset.norm();
  return std::log(std::clamp(length / mean, 0.5, 2.0));
}

// The lengths of limbs; everything else is mean.
BodyPrior from_joints(const ingest::BodyMesh& mesh) {
  const double height = height_of(mesh);
  const auto both = [&mesh](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return 0.5 * (distance(mesh, a, b) + distance(mesh, c, d));
  };
  BodyPrior prior;
  Shape precision = Shape::Zero();
  const auto set = [&](Measure which, double value) {
    prior.state.shape[which] = value;
    precision[which] = 1 / (kLengthSigma * kLengthSigma);
  };
  set(kHeight, std::log(height / kMeanHeight));
  set(kUpperArmLength,
      measure(both(kMeshLeftShoulder, kMeshLeftElbow, kMeshRightShoulder, kMeshRightElbow), height, kLeftElbow));
  set(kForearmLength,
      measure(both(kMeshLeftElbow, kMeshLeftWrist, kMeshRightElbow, kMeshRightWrist), height, kLeftWrist));
  set(kThighLength, measure(both(kMeshLeftHip, kMeshLeftKnee, kMeshRightHip, kMeshRightKnee), height, kLeftKnee));
  set(kShankLength, measure(both(kMeshLeftKnee, kMeshLeftAnkle, kMeshRightKnee, kMeshRightAnkle), height, kLeftAnkle));
  prior.shape_precision = precision.asDiagonal();
  return prior;
}

// Hips on hips, and every limb to where the mesh has it.
void fit_pose(const ingest::BodyMesh& mesh, BodyState& state) {
  constexpr int kSwivels = 16;
  const auto middle = [&mesh](std::size_t a, std::size_t b) {
    return Vec(0.5 * (mesh.joints.at(a) + mesh.joints.at(b)));
  };
  const PosedBody upright = pose_body(state.pose, state.shape);
  const Vec hips = 0.5 * (upright.bones[kLeftHip].translation() + upright.bones[kRightHip].translation());
  state.pose.root.translation() = middle(kMeshLeftHip, kMeshRightHip) - hips;
  for (const MeshLimb& limb : kMeshLimbs) {
    const LimbChain& chain = chain_of(limb.limb);
    const PosedBody body = pose_body(state.pose, state.shape);
    const Vec target = body.bones[chain.ball].translation() + mesh.joints.at(limb.end) - mesh.joints.at(limb.ball);
    const Vec wanted = body.bones[chain.ball].translation() + mesh.joints.at(limb.hinge) - mesh.joints.at(limb.ball);
    double least = 1e300;
    Angles best = state.pose.angles;
    for (int i = 0; i < kSwivels; ++i) {
      BodyPose tried = state.pose;
      tried.angles =
          inverse_kinematics(limb.limb, state.pose.angles, body, target, 2 * std::numbers::pi * i / kSwivels, 0);
      const Vec hinge = forward_kinematics(tried, state.shape)[chain.hinge].translation();
      const double cost = angle_energy(tried.angles, {}) + (hinge - wanted).squaredNorm() / (0.02 * 0.02);
      if (cost >= least) continue;
      least = cost;
      best = tried.angles;
    }
    state.pose.angles = best;
  }
}

std::vector<MeasuredPoint> surface_of(const ingest::BodyMesh& mesh, const BodyEnergyConfig& config) {
  std::vector<MeasuredPoint> points;
  for (const auto& face : mesh.faces) {
    const Vec& a = mesh.vertices[face[0]];
    const Vec across = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
    const double twice_area = across.norm();
    if (twice_area < 1e-12) continue;
    points.push_back({(a + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3, across / twice_area,
                      0.5 * twice_area / (config.patch * config.patch)});
  }
  return points;
}

} // namespace

BodyPrior measure_body(const ingest::BodyMesh& mesh) {
  constexpr int kIterations = 40;
  const BodyEnergyConfig config;
  BodyPrior prior = from_joints(mesh);
  fit_pose(mesh, prior.state);
  const LayerView nothing; // hides nothing and contradicts nothing
  const BodyEvidence evidence{&nothing, surface_of(mesh, config)};
  BodyState state = prior.state;
  minimise(evidence, prior, config, kIterations, true, state);
  prior.state = state;
  Shape sigma = Shape::Constant(kLengthSigma);
  sigma.tail<kMeasures - kPelvisGirth>().setConstant(kGirthSigma);
  prior.shape_precision = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  return prior;
}

} // namespace kinora::tracking
