#include "gltf_scene/gltf_file.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gltf_scene/gltf_accessor.h"
#include "gltf_scene/gltf_model.h"

namespace kinora::formats {
namespace {

using tinygltf::Model;

/// A scene out of a parsed file; every index is checked.
class SceneBuilder {
public:
  SceneBuilder(const Model& model, std::string source, std::vector<std::string>& warnings)
      : model_(model), source_(std::move(source)), warnings_(warnings), node_of_(model.nodes.size(), -1) {}

  Scene build() {
    add_images();
    add_nodes();
    for (const tinygltf::Mesh& mesh : model_.meshes) add_mesh(mesh);
    for (const tinygltf::Skin& skin : model_.skins) add_skin(skin);
    for (std::size_t i = 0; i < model_.nodes.size(); ++i)
      if (node_of_[i] >= 0) add_thing(model_.nodes[i], node_of_[i]);
    for (const tinygltf::Animation& animation : model_.animations) add_animation(animation);
    if (scene_.things.empty()) fail("has no mesh in its scene");
    return std::move(scene_);
  }

private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw Error(ErrorCode::kCorruptInput, source_ + ": " + problem);
  }
  void warn(const std::string& sentence) {
    const std::string warning = source_ + ": " + sentence;
    if (std::ranges::find(warnings_, warning) == warnings_.end()) warnings_.push_back(warning);
  }
  template <class T> const T& at(const std::vector<T>& list, int index, const char* what) const {
    if (index < 0 || static_cast<std::size_t>(index) >= list.size()) fail(std::string(what).append(" is not there"));
    return list[static_cast<std::size_t>(index)];
  }

  void add_images() {
    for (const tinygltf::Image& image : model_.images) {
      ColorImage color(image.width, image.height, 3);
      if (color.values().size() != image.image.size()) fail("a picture cannot be read");
      std::ranges::copy(image.image, color.data());
      scene_.images.push_back(std::move(color));
    }
  }

  // ---- nodes, parents first

  void add_nodes() {
    std::vector<int> roots;
    if (!model_.scenes.empty()) {
      roots = at(model_.scenes, std::max(model_.defaultScene, 0), "the scene").nodes;
    } else {
      std::vector<bool> is_child(model_.nodes.size(), false);
      for (const tinygltf::Node& node : model_.nodes)
        for (const int child : node.children)
          if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
            is_child[static_cast<std::size_t>(child)] = true;
      for (std::size_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    std::vector<std::pair<int, int>> waiting; // a node, and where its parent is
    waiting.reserve(roots.size());
    for (const int root : roots) waiting.emplace_back(root, -1);
    for (std::size_t next = 0; next < waiting.size(); ++next) {
      const auto [index, parent] = waiting[next];
      const tinygltf::Node& node = at(model_.nodes, index, "a node");
      int& place = node_of_[static_cast<std::size_t>(index)];
      if (place >= 0) fail("a node stands twice in the scene");
      place = static_cast<int>(scene_.nodes.size());
      scene_.nodes.push_back(node_of(node, parent));
      for (const int child : node.children) waiting.emplace_back(child, place);
    }
  }

  SceneNode node_of(const tinygltf::Node& node, int parent) const {
    SceneNode made;
    made.name = node.name;
    made.parent = parent;
    const auto numbers = [&](const std::vector<double>& list, std::size_t count) {
      if (list.empty()) return false;
      if (list.size() != count || !std::ranges::all_of(list, [](double v) { return std::isfinite(v); }))
        fail("the place of the node \"" + node.name + "\" makes no sense");
      return true;
    };
    if (numbers(node.matrix, 16)) made.matrix.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
    if (numbers(node.translation, 3)) made.translation = Eigen::Map<const Eigen::Vector3d>(node.translation.data());
    if (numbers(node.scale, 3)) made.scale = Eigen::Map<const Eigen::Vector3d>(node.scale.data());
    if (numbers(node.rotation, 4)) {
      made.rotation = {node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]};
      if (!(made.rotation.norm() > 1e-9)) fail("the rotation of the node \"" + node.name + "\" is none");
      made.rotation.normalize();
    }
    made.weights = node.weights;
    if (made.weights.empty() && node.mesh >= 0) made.weights = at(model_.meshes, node.mesh, "a mesh").weights;
    return made;
  }

  void add_thing(const tinygltf::Node& node, int place) {
    if (node.camera >= 0) {
      const tinygltf::Camera& camera = at(model_.cameras, node.camera, "a camera");
      if (camera.type == "perspective" && camera.perspective.yfov > 0.01 && camera.perspective.yfov < 3.1)
        scene_.cameras.push_back({node.name.empty() ? camera.name : node.name, place, camera.perspective.yfov});
    }
    if (node.mesh < 0) return;
    const tinygltf::Mesh& mesh = at(model_.meshes, node.mesh, "a mesh");
    if (scene_.meshes[static_cast<std::size_t>(node.mesh)].empty()) return;
    SceneThing thing;
    thing.name = !node.name.empty() ? node.name : mesh.name;
    if (thing.name.empty()) thing.name = "mesh " + std::to_string(scene_.things.size() + 1);
    thing.node = place;
    thing.mesh = node.mesh;
    thing.skin = node.skin;
    if (node.skin >= 0) check_joints(node);
    scene_.things.push_back(std::move(thing));
  }

  void check_joints(const tinygltf::Node& node) const {
    (void)at(model_.skins, node.skin, "a skin");
    const std::size_t count = scene_.skins[static_cast<std::size_t>(node.skin)].joints.size();
    for (const ScenePrimitive& primitive : scene_.meshes[static_cast<std::size_t>(node.mesh)])
      for (const auto& joints : primitive.joints)
        for (const std::uint32_t joint : joints)
          if (joint >= count) fail("a vertex hangs on a joint that its skin has not");
  }

  // ---- meshes

  /// A list of an attribute, or an empty one; `widths`: how many numbers its elements may have.
  GltfNumbers attribute(const std::map<std::string, int>& attributes, const std::string& name, std::size_t count,
                        std::initializer_list<std::size_t> widths) const {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return {};
    GltfNumbers numbers = read_accessor(model_, found->second, source_);
    if (std::ranges::find(widths, numbers.width) == widths.end() || (count > 0 && numbers.count != count))
      fail(name + " has not the size that it must have");
    return numbers;
  }

  static std::vector<Eigen::Vector3f> vectors_of(const GltfNumbers& numbers) {
    std::vector<Eigen::Vector3f> vectors(numbers.count);
    for (std::size_t i = 0; i < numbers.count; ++i)
      vectors[i] = Eigen::Map<const Eigen::Vector3d>(numbers.values.data() + i * numbers.width).cast<float>();
    return vectors;
  }

  void add_mesh(const tinygltf::Mesh& mesh) {
    std::vector<ScenePrimitive> primitives;
    for (const tinygltf::Primitive& given : mesh.primitives) {
      const int mode = given.mode < 0 ? TINYGLTF_MODE_TRIANGLES : given.mode;
      if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
          mode != TINYGLTF_MODE_TRIANGLE_FAN) {
        warn("points and lines are passed over");
        continue;
      }
      primitives.push_back(primitive_of(given, mode));
    }
    scene_.meshes.push_back(std::move(primitives));
  }

  ScenePrimitive primitive_of(const tinygltf::Primitive& given, int mode) {
    ScenePrimitive made;
    made.positions = vectors_of(attribute(given.attributes, "POSITION", 0, {3}));
    const std::size_t count = made.positions.size();
    if (count == 0) fail("a mesh has no POSITION");
    made.material = material_of(given.material);
    const std::string set = std::string("TEXCOORD_").append(std::to_string(made.material.texture_coordinates));
    const GltfNumbers places = attribute(given.attributes, set, count, {2});
    for (std::size_t i = 0; i < places.count; ++i)
      made.texture_coordinates.push_back(Eigen::Map<const Eigen::Vector2d>(places.values.data() + 2 * i).cast<float>());
    made.colors = vectors_of(attribute(given.attributes, "COLOR_0", count, {3, 4}));
    add_skinning(given, count, made);
    for (const auto& target : given.targets) {
      std::vector<Eigen::Vector3f> moved = vectors_of(attribute(target, "POSITION", count, {3}));
      if (moved.empty()) moved.assign(count, Eigen::Vector3f::Zero());
      made.morph_targets.push_back(std::move(moved));
    }
    made.indices = triangles_of(given, mode, count);
    return made;
  }

  void add_skinning(const tinygltf::Primitive& given, std::size_t count, ScenePrimitive& made) {
    const GltfNumbers joints = attribute(given.attributes, "JOINTS_0", count, {4});
    const GltfNumbers weights = attribute(given.attributes, "WEIGHTS_0", count, {4});
    if (joints.count == 0 || weights.count == 0) return;
    if (given.attributes.contains("JOINTS_1")) warn("of vertices with more than four joints, four are taken");
    for (std::size_t i = 0; i < count; ++i) {
      std::array<std::uint32_t, 4> chosen{};
      Eigen::Vector4f shares;
      for (std::size_t k = 0; k < 4; ++k) {
        const double joint = joints.values[4 * i + k];
        if (!(joint >= 0 && joint < 1e6)) fail("a vertex hangs on a joint that its skin has not");
        chosen[k] = static_cast<std::uint32_t>(joint);
        shares[static_cast<int>(k)] = static_cast<float>(weights.values[4 * i + k]);
      }
      made.joints.push_back(chosen);
      made.joint_weights.push_back(shares);
    }
  }

  std::vector<std::uint32_t> triangles_of(const tinygltf::Primitive& given, int mode, std::size_t count) const {
    std::vector<std::uint32_t> corners;
    if (given.indices >= 0) {
      const GltfNumbers indices = read_accessor(model_, given.indices, source_);
      if (indices.width != 1) fail("the corners of triangles are no plain numbers");
      for (const double index : indices.values) {
        if (!(index >= 0 && index < static_cast<double>(count))) fail("a triangle has a corner that is not there");
        corners.push_back(static_cast<std::uint32_t>(index));
      }
    } else {
      for (std::size_t i = 0; i < count; ++i) corners.push_back(static_cast<std::uint32_t>(i));
    }
    if (mode == TINYGLTF_MODE_TRIANGLES) return corners;
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 2; i < corners.size(); ++i)
      triangles.insert(triangles.end(),
                       {corners[mode == TINYGLTF_MODE_TRIANGLE_FAN ? 0 : i - 2], corners[i - 1], corners[i]});
    return triangles;
  }

  SceneMaterial material_of(int index) {
    SceneMaterial made;
    if (index < 0) return made;
    const tinygltf::Material& given = at(model_.materials, index, "a material");
    const tinygltf::PbrMetallicRoughness& pbr = given.pbrMetallicRoughness;
    if (given.alphaMode != "OPAQUE" && !given.alphaMode.empty()) warn("what is transparent is drawn opaque");
    for (std::size_t c = 0; c < 3 && pbr.baseColorFactor.size() >= 3; ++c)
      made.base[static_cast<int>(c)] = static_cast<float>(std::clamp(pbr.baseColorFactor[c], 0.0, 1.0));
    if (pbr.baseColorTexture.index < 0) return made;
    made.image = at(model_.textures, pbr.baseColorTexture.index, "a texture").source;
    (void)at(scene_.images, made.image, "a texture's picture");
    made.texture_coordinates = static_cast<std::size_t>(std::clamp(pbr.baseColorTexture.texCoord, 0, 16));
    return made;
  }

  // ---- what moves

  void add_skin(const tinygltf::Skin& given) {
    SceneSkin skin;
    for (const int joint : given.joints) {
      (void)at(model_.nodes, joint, "a joint");
      skin.joints.push_back(node_of_[static_cast<std::size_t>(joint)]);
      if (skin.joints.back() < 0) fail("a joint is not in the scene");
    }
    skin.inverse_bind.assign(skin.joints.size(), Eigen::Matrix4d::Identity());
    if (given.inverseBindMatrices >= 0) {
      const GltfNumbers matrices = read_accessor(model_, given.inverseBindMatrices, source_);
      if (matrices.width != 16 || matrices.count < skin.joints.size()) fail("a skin has fewer matrices than joints");
      for (std::size_t j = 0; j < skin.joints.size(); ++j)
        skin.inverse_bind[j] = Eigen::Map<const Eigen::Matrix4d>(matrices.values.data() + 16 * j);
    }
    scene_.skins.push_back(std::move(skin));
  }

  void add_animation(const tinygltf::Animation& given) {
    SceneAnimation animation;
    animation.name = given.name;
    for (const tinygltf::AnimationChannel& channel : given.channels) {
      if (channel.target_node < 0) continue;
      (void)at(model_.nodes, channel.target_node, "an animated node");
      const int node = node_of_[static_cast<std::size_t>(channel.target_node)];
      if (node < 0) continue;
      animation.tracks.push_back(track_of(at(given.samplers, channel.sampler, "a sampler"), channel.target_path, node));
      animation.duration = std::max(animation.duration, animation.tracks.back().times.back());
    }
    if (!animation.tracks.empty()) scene_.animations.push_back(std::move(animation));
  }

  SceneTrack track_of(const tinygltf::AnimationSampler& sampler, const std::string& path, int node) const {
    SceneTrack track;
    track.node = node;
    if (path == "translation")
      track.path = ScenePath::kTranslation;
    else if (path == "rotation")
      track.path = ScenePath::kRotation;
    else if (path == "scale")
      track.path = ScenePath::kScale;
    else if (path == "weights")
      track.path = ScenePath::kWeights;
    else
      fail("an animation is of \"" + path + "\", which is nothing that moves");
    if (sampler.interpolation == "STEP") track.interpolation = SceneInterpolation::kStep;
    if (sampler.interpolation == "CUBICSPLINE") track.interpolation = SceneInterpolation::kCubic;
    track.times = read_accessor(model_, sampler.input, source_).values;
    track.values = read_accessor(model_, sampler.output, source_).values;
    const bool rises = std::ranges::adjacent_find(track.times, std::greater_equal<>()) == track.times.end();
    if (!rises || track.times.front() < 0 || track.times.back() > 1e6)
      fail("the times of an animation do not increase");
    const std::size_t keys = track.times.size() * (track.interpolation == SceneInterpolation::kCubic ? 3 : 1);
    track.width = track.values.size() / keys;
    const std::size_t wanted = track.path == ScenePath::kRotation  ? 4
                               : track.path == ScenePath::kWeights ? track.width
                                                                   : 3;
    if (track.width == 0 || track.width != wanted || track.width * keys != track.values.size())
      fail("an animation has not as many values as times");
    return track;
  }

  const Model& model_;
  std::string source_;
  std::vector<std::string>& warnings_;
  std::vector<int> node_of_; ///< where a node of the file is in the scene; −1: not
  Scene scene_;
};

} // namespace

Scene read_gltf(const std::filesystem::path& path, std::vector<std::string>& warnings) {
  const Model model = load_gltf_model(path);
  return SceneBuilder(model, path.string(), warnings).build();
}

} // namespace kinora::formats
