#include "human.h"

#include <algorithm>
#include <map>
#include <sstream>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "text_file.h"

namespace kinora::simulator {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kMetresPerUnit = 0.1;

/// The joint of the motion that turns a bone; empty: it follows its parent. The arms' and legs' rest is aligned along
/// the way to `child`.
struct Driven {
  const char* bone;
  const char* joint;
  const char* child;       ///< bone
  const char* child_joint; ///< of the motion
};
constexpr Driven kDriven[] = {
    {"Hips", "hip", "", ""},
    {"LowerBack", "lowerback", "", ""},
    {"Spine", "abdomen", "", ""},
    {"Spine1", "chest", "", ""},
    {"Neck", "neck", "", ""},
    {"Neck1", "neck1", "", ""},
    {"Head", "head", "", ""},
    {"LeftShoulder", "lcollar", "", ""},
    {"LeftArm", "lshoulder", "LeftForeArm", "lelbow"},
    {"LeftForeArm", "lelbow", "LeftHand", "lhand"},
    {"RightShoulder", "rcollar", "", ""},
    {"RightArm", "rshoulder", "RightForeArm", "relbow"},
    {"RightForeArm", "relbow", "RightHand", "rhand"},
    {"LeftUpLeg", "lhip", "LeftLeg", "lknee"},
    {"LeftLeg", "lknee", "LeftFoot", "lfoot"},
    {"LeftFoot", "lfoot", "", ""},
    {"RightUpLeg", "rhip", "RightLeg", "rknee"},
    {"RightLeg", "rknee", "RightFoot", "rfoot"},
    {"RightFoot", "rfoot", "", ""},
};

bool is_one_of(const std::string& word, std::initializer_list<const char*> list) {
  return std::any_of(list.begin(), list.end(), [&](const char* each) { return word == each; });
}

/// The mesh has hair to the hips and all about the face.
bool is_cut(const Vec& hair, const Vec& head, const HumanOptions& options) {
  const bool before_face = hair.z() > head.z() + 0.05 && hair.y() < head.y() + 0.095;
  return before_face || hair.y() < head.y() - options.hair_length;
}

} // namespace

Human::Human(const std::filesystem::path& data, const HumanOptions& options) {
  read_mesh(data / "base.obj.gz");
  shape(data / "targets", options);
  read_rig(data / "rigs");
  dress(options);
}

std::size_t Human::bone(const std::string& name) const {
  const auto found = std::find(bone_names_.begin(), bone_names_.end(), name);
  if (found == bone_names_.end()) throw Error(ErrorCode::kCorruptInput, "the body has no bone " + name);
  return static_cast<std::size_t>(found - bone_names_.begin());
}

void Human::read_mesh(const std::filesystem::path& path) {
  std::istringstream lines(read_text_file(path));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vec& vertex = rest_.emplace_back();
      words >> vertex.x() >> vertex.y() >> vertex.z();
      vertex *= kMetresPerUnit;
    } else if (kind == "g") {
      words >> groups_.emplace_back().name;
    } else if (kind == "f" && !groups_.empty()) {
      std::vector<int> corners;
      for (std::string word; words >> word;) corners.push_back(std::stoi(word) - 1);
      for (std::size_t i = 2; i < corners.size(); ++i)
        groups_.back().faces.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  if (rest_.empty() || groups_.empty()) throw Error(ErrorCode::kCorruptInput, path.string() + ": no mesh");
}

void Human::shape(const std::filesystem::path& folder, const HumanOptions& options) {
  for (const auto& [name, amount] : options.targets) {
    std::istringstream lines(read_text_file(folder / (name + ".target.gz")));
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::size_t vertex = 0;
      Vec offset;
      if (words >> vertex >> offset.x() >> offset.y() >> offset.z() && vertex < rest_.size())
        rest_[vertex] += amount * kMetresPerUnit * offset;
    }
  }
}

void Human::read_rig(const std::filesystem::path& folder) {
  const auto rig = nlohmann::json::parse(read_text_file(folder / "rig.cmu_mb.json"));
  const auto table = nlohmann::json::parse(read_text_file(folder / "weights.cmu_mb.json")).at("weights");
  while (bone_names_.size() < rig.size()) {
    const std::size_t before = bone_names_.size();
    for (const auto& [name, entry] : rig.items()) {
      const std::string parent = entry.at("parent");
      const auto found = std::find(bone_names_.begin(), bone_names_.end(), parent);
      if (std::find(bone_names_.begin(), bone_names_.end(), name) != bone_names_.end()) continue;
      if (!parent.empty() && found == bone_names_.end()) continue;
      bone_parents_.push_back(parent.empty() ? -1 : static_cast<int>(found - bone_names_.begin()));
      bone_names_.push_back(name);
      std::vector<int> vertices;
      const auto& head = entry.at("head");
      if (head.at("strategy") == "MEAN") {
        vertices = head.at("vertex_indices").get<std::vector<int>>();
      } else {
        for (const Group& group : groups_)
          if (group.name == head.at("cube_name"))
            for (const auto& face : group.faces) vertices.insert(vertices.end(), face.begin(), face.end());
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
      }
      Vec sum = Vec::Zero();
      for (const int vertex : vertices) sum += rest_.at(static_cast<std::size_t>(vertex));
      bone_heads_.emplace_back(sum / static_cast<double>(std::max<std::size_t>(vertices.size(), 1)));
    }
    if (bone_names_.size() == before) throw Error(ErrorCode::kCorruptInput, "the rig's bones form no tree");
  }
  weights_.resize(rest_.size());
  for (std::size_t b = 0; b < bone_names_.size(); ++b)
    for (const auto& entry : table.at(bone_names_[b]))
      weights_.at(entry[0].get<std::size_t>()).emplace_back(static_cast<int>(b), entry[1].get<double>());
}

/// What is worn stands out from the body a little, with folds.
void Human::dress(const HumanOptions& options) {
  std::vector<Part> of_vertex(rest_.size(), Part::kSkin);
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    const auto most = std::max_element(weights_[v].begin(), weights_[v].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most == weights_[v].end()) continue;
    const std::string& name = bone_names_[static_cast<std::size_t>(most->first)];
    if (is_one_of(name, {"LeftUpLeg", "RightUpLeg", "LeftLeg", "RightLeg", "LHipJoint", "RHipJoint", "Hips"}))
      of_vertex[v] = options.skirt && name != "Hips" ? Part::kSkin : Part::kTrousers;
    else if (is_one_of(name,
                       {"LowerBack", "Spine", "Spine1", "LeftShoulder", "RightShoulder", "LeftArm", "RightArm"}) ||
             (options.long_sleeves && is_one_of(name, {"LeftForeArm", "RightForeArm"})))
      of_vertex[v] = Part::kShirt;
    else if (is_one_of(name, {"LeftFoot", "RightFoot", "LeftToeBase", "RightToeBase"}))
      of_vertex[v] = Part::kShoes;
  }
  std::vector<Vec> normals(rest_.size(), Vec::Zero());
  for (const Group& group : groups_) {
    const bool worn = group.name == "helper-hair" || (options.skirt && group.name == "helper-skirt");
    const bool eye = group.name == "helper-l-eye" || group.name == "helper-r-eye";
    if (group.name != "body" && !worn && !eye) continue;
    for (const auto& face : group.faces) {
      const auto corner = [&](int i) { return static_cast<std::size_t>(face[static_cast<std::size_t>(i)]); };
      if (group.name == "helper-hair" && is_cut(rest_[corner(0)], bone_heads_[bone("Head")], options)) continue;
      const Vec normal = (rest_[corner(1)] - rest_[corner(0)]).cross(rest_[corner(2)] - rest_[corner(0)]);
      for (int i = 0; i < 3; ++i) normals[corner(i)] += normal;
      faces_.push_back(face);
      parts_.push_back(eye                            ? Part::kEye
                       : group.name == "helper-hair"  ? Part::kHair
                       : group.name == "helper-skirt" ? Part::kSkirt
                                                      : of_vertex[corner(0)]);
    }
  }
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    if (of_vertex[v] != Part::kShirt && of_vertex[v] != Part::kTrousers && of_vertex[v] != Part::kShoes) continue;
    const Vec& p = rest_[v];
    const double fold = std::sin(38 * p.y() + 9 * std::sin(14 * p.x()) + 20 * p.z());
    if (normals[v].norm() > 0) rest_[v] += (0.008 + 0.004 * fold) * normals[v].normalized();
  }
}

HumanPose Human::pose(const MotionCapture& motion, double seconds) const {
  const auto position_of = [this](const char* name) { return bone_heads_[bone(name)]; };
  std::map<std::string, Eigen::Quaterniond> rotations;
  for (const Driven& driven : kDriven) {
    if (!motion.has(driven.joint)) continue;
    Eigen::Quaterniond rotation = motion.rotation(driven.joint, seconds);
    if (*driven.child != 0) {
      const Vec ours = position_of(driven.child) - position_of(driven.bone);
      const Vec theirs = motion.rest_position(driven.child_joint) - motion.rest_position(driven.joint);
      rotation = rotation * Eigen::Quaterniond::FromTwoVectors(ours, theirs);
    }
    rotations[driven.bone] = rotation;
  }
  const double ratio = (position_of("LeftUpLeg") - position_of("LeftFoot")).norm() /
                       (motion.rest_position("lhip") - motion.rest_position("lfoot")).norm();
  HumanPose pose;
  for (std::size_t b = 0; b < bone_names_.size(); ++b) {
    const int parent = bone_parents_[b];
    const SE3* above = parent < 0 ? nullptr : &pose.bones[static_cast<std::size_t>(parent)];
    const Vec head = above == nullptr ? Vec(ratio * motion.position(seconds)) : Vec(*above * bone_heads_[b]);
    const auto found = rotations.find(bone_names_[b]);
    SE3 bone = SE3::Identity();
    bone.linear() = found != rotations.end() ? found->second.toRotationMatrix()
                    : above != nullptr       ? Eigen::Matrix3d(above->linear())
                                             : Eigen::Matrix3d::Identity();
    bone.translation() = head - bone.linear() * bone_heads_[b];
    pose.bones.push_back(bone);
    pose.joints.push_back(head);
  }
  pose.vertices.reserve(rest_.size());
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    Vec sum = Vec::Zero();
    double total = 0;
    for (const auto& [bone, weight] : weights_[v]) {
      sum += weight * (pose.bones[static_cast<std::size_t>(bone)] * rest_[v]);
      total += weight;
    }
    pose.vertices.push_back(total > 0 ? Vec(sum / total) : Vec(pose.bones[0] * rest_[v]));
  }
  return pose;
}

} // namespace kinora::simulator
