#include "gltf_scene/scene.h"

#include <algorithm>

namespace kinora::formats {
namespace {

Eigen::Affine3d local_of(const SceneNode& node) {
  return node.matrix * Eigen::Translation3d(node.translation) * node.rotation * Eigen::Scaling(node.scale);
}

/// The cubic of glTF's appendix C between two keys, `step` seconds apart.
double cubic(double fraction, double step, double from, double out_tangent, double to, double in_tangent) {
  const double t2 = fraction * fraction;
  const double t3 = t2 * fraction;
  return (2 * t3 - 3 * t2 + 1) * from + step * (t3 - 2 * t2 + fraction) * out_tangent + (-2 * t3 + 3 * t2) * to +
         step * (t3 - t2) * in_tangent;
}

Eigen::Quaterniond quaternion_of(const double* xyzw) {
  const Eigen::Quaterniond rotation(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  return rotation.norm() > 1e-9 ? rotation.normalized() : Eigen::Quaterniond::Identity();
}

void apply(const SceneTrack& track, double time, SceneNode& node) {
  const std::vector<double> value = track.at(time);
  switch (track.path) {
  case ScenePath::kTranslation:
    node.translation = Eigen::Map<const Eigen::Vector3d>(value.data());
    break;
  case ScenePath::kRotation:
    node.rotation = quaternion_of(value.data());
    break;
  case ScenePath::kScale:
    node.scale = Eigen::Map<const Eigen::Vector3d>(value.data());
    break;
  case ScenePath::kWeights:
    node.weights = value;
    break;
  }
}

} // namespace

std::vector<double> SceneTrack::at(double time) const {
  const bool has_tangents = interpolation == SceneInterpolation::kCubic;
  const std::size_t stride = has_tangents ? 3 * width : width;
  const auto value_at = [&](std::size_t key) { return values.data() + key * stride + (has_tangents ? width : 0); };
  const auto after = static_cast<std::size_t>(std::ranges::upper_bound(times, time) - times.begin());
  if (after == 0 || after == times.size() || interpolation == SceneInterpolation::kStep) {
    const double* value = value_at(after == 0 ? 0 : after - 1);
    return {value, value + width};
  }
  const double step = times[after] - times[after - 1];
  const double fraction = (time - times[after - 1]) / step;
  const double* from = value_at(after - 1);
  const double* to = value_at(after);
  std::vector<double> out(width);
  if (has_tangents) {
    for (std::size_t i = 0; i < width; ++i)
      out[i] = cubic(fraction, step, from[i], from[width + i], to[i], *(to - width + i));
  } else if (path == ScenePath::kRotation) {
    const Eigen::Quaterniond between = quaternion_of(from).slerp(fraction, quaternion_of(to));
    out = {between.x(), between.y(), between.z(), between.w()};
  } else {
    for (std::size_t i = 0; i < width; ++i) out[i] = from[i] + fraction * (to[i] - from[i]);
  }
  return out;
}

ScenePose::ScenePose(const Scene& scene, const SceneAnimation* animation, double time)
    : scene_(&scene), nodes_(scene.nodes), to_world_(scene.nodes.size()) {
  if (animation != nullptr)
    for (const SceneTrack& track : animation->tracks) apply(track, time, nodes_[static_cast<std::size_t>(track.node)]);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const int parent = nodes_[i].parent;
    to_world_[i] = parent < 0 ? local_of(nodes_[i]) : to_world_[static_cast<std::size_t>(parent)] * local_of(nodes_[i]);
  }
}

std::vector<Eigen::Vector3f> ScenePose::vertices(const SceneThing& thing, const ScenePrimitive& primitive) const {
  std::vector<Eigen::Vector3f> points = primitive.positions;
  const std::vector<double>& weights = nodes_[static_cast<std::size_t>(thing.node)].weights;
  for (std::size_t t = 0; t < std::min(weights.size(), primitive.morph_targets.size()); ++t)
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] += static_cast<float>(weights[t]) * primitive.morph_targets[t][i];
  if (thing.skin < 0 || primitive.joints.empty()) {
    const Eigen::Affine3f to_world = node_to_world(thing.node).cast<float>();
    for (Eigen::Vector3f& point : points) point = to_world * point;
    return points;
  }
  const SceneSkin& skin = scene_->skins[static_cast<std::size_t>(thing.skin)];
  std::vector<Eigen::Matrix4f> joints; // the mesh's own node has no say
  for (std::size_t j = 0; j < skin.joints.size(); ++j)
    joints.emplace_back((node_to_world(skin.joints[j]).matrix() * skin.inverse_bind[j]).cast<float>());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector4f sum = Eigen::Vector4f::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
      const float weight = primitive.joint_weights[i][static_cast<int>(k)];
      if (weight > 0) sum += weight * (joints[primitive.joints[i][k]] * points[i].homogeneous());
    }
    if (sum.w() > 1e-6F) points[i] = sum.head<3>() / sum.w();
  }
  return points;
}

void find_motion(Scene& scene, const SceneAnimation* animation) {
  std::vector<bool> moves(scene.nodes.size(), false);
  std::vector<bool> morphs(scene.nodes.size(), false);
  if (animation == nullptr) return;
  for (const SceneTrack& track : animation->tracks) {
    const auto node = static_cast<std::size_t>(track.node);
    const std::size_t stride = track.values.size() / track.times.size();
    bool changes = false;
    for (std::size_t i = stride; i < track.values.size(); ++i)
      changes = changes || track.values[i] != track.values[i - stride];
    (track.path == ScenePath::kWeights ? morphs : moves)[node] = changes || moves[node];
  }
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const int parent = scene.nodes[i].parent;
    if (parent >= 0 && moves[static_cast<std::size_t>(parent)]) moves[i] = true;
  }
  for (SceneThing& thing : scene.things) {
    thing.moves = moves[static_cast<std::size_t>(thing.node)];
    thing.deforms = morphs[static_cast<std::size_t>(thing.node)];
    if (thing.skin < 0) continue;
    const std::vector<int>& joints = scene.skins[static_cast<std::size_t>(thing.skin)].joints;
    const bool any = std::ranges::any_of(joints, [&](int joint) { return moves[static_cast<std::size_t>(joint)]; });
    thing.moves = any;
    thing.deforms = thing.deforms || (any && joints.size() > 1);
  }
}

} // namespace kinora::formats
