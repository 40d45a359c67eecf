#include <fmt/format.h>

#include "bake/born_parts.h"
#include "bake/skinning.h"
#include "cli/conversion.h"
#include "cli/export_facts.h"
#include "cli/output_with_files.h"
#include "clip/shown_frames.h"
#include "core/error.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

/// A layer, or a part of it that is there from another frame on.
struct BakedMesh {
  motion::Presence shown;
  host::Mesh mesh;
  bake::Skinning skinning;
};

/// What is hidden at times has poses, also if it is still.
motion::Motion posed_motion(const clip::Layer& layer, const Conversion& conversion) {
  const bool is_hidden = !layer.presence.is_always() && host::supports(*conversion.format, KINORA_WRITES_HIDDEN);
  if (!is_hidden || layer.motion.kind() != motion::MotionKind::kStill) return layer.motion;
  return motion::Motion::rigid(std::vector<motion::Motion::Pose>(conversion.clip->times.size()));
}

/// A few frames over the whole, to compare the two ways of blending at.
std::vector<int> some_of(const std::vector<int>& frames) {
  constexpr std::size_t kMax = 8;
  std::vector<int> chosen;
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / kMax);
  for (std::size_t i = 0; i < frames.size(); i += stride) chosen.push_back(frames[i]);
  return chosen;
}

void report_losses(const Conversion& conversion, const clip::Layer& layer, const bake::Skinning& skinning,
                   const host::Mesh& mesh, Json& description, Context& context) {
  constexpr double kNoticeable = 0.01; // metres
  const std::string& name = layer.name;
  if (layer.motion.kind() == motion::MotionKind::kDeforming) {
    const auto difference = skinning.blending_difference(mesh, some_of(conversion.frames));
    description["blending_difference"] = {{"mean_m", difference.mean}, {"largest_m", difference.largest}};
    if (difference.largest > kNoticeable) {
      report_loss(conversion,
                  fmt::format("{}: meshes blend the motion of joints linearly, which puts its surface up to {:.0f} mm "
                              "(mean {:.1f} mm) from where the clip has it",
                              name, 1000 * difference.largest, 1000 * difference.mean),
                  context);
    }
  }
  report_lost_frames(conversion, layer, context);
}

/// The mesh of a layer, which `skinning` moves, as far as the format can hide what is not there.
void add_parts(const Conversion& conversion, const clip::Layer& layer, const bake::Skinning& skinning,
               const motion::Motion& motion, host::Mesh mesh, std::vector<BakedMesh>& baked) {
  constexpr std::size_t kMaxParts = 6; // each has joints and a texture of its own
  if (!host::supports(*conversion.format, KINORA_WRITES_HIDDEN)) {
    baked.push_back({{}, std::move(mesh), skinning});
    return;
  }
  const std::size_t frames = conversion.clip->times.size();
  std::vector<bake::BornPart> parts = bake::born_parts(std::move(mesh), layer, kMaxParts);
  for (bake::BornPart& part : parts) {
    motion::Presence shown = clip::shown_frames(layer, frames, part.birth);
    bake::Skinning own = parts.size() == 1 ? skinning : bake::Skinning(motion, part.mesh);
    baked.push_back({std::move(shown), std::move(part.mesh), std::move(own)});
  }
}

std::vector<BakedMesh> bake_layers(const Conversion& conversion, Json& descriptions, Context& context) {
  std::vector<BakedMesh> baked;
  context.progress.stage("surfaces", conversion.layers.size());
  for (std::size_t i = 0; i < conversion.layers.size(); ++i) {
    const clip::Layer& layer = conversion.clip->layers[conversion.layers[i]];
    auto mesh = bake::extract_mesh(layer, conversion.surface, context.progress);
    context.progress.advance(i + 1, layer.name);
    if (!mesh) {
      report_no_surface(conversion, layer, context);
      continue;
    }
    const motion::Motion motion = posed_motion(layer, conversion);
    const bake::Skinning skinning(motion, *mesh);
    const host::Mesh& made = *mesh;
    Json description = {{"name", layer.name},
                        {"motion", motion::name_of(layer.motion.kind())},
                        {"vertices", made.positions.size()},
                        {"triangles", made.faces.size()},
                        {"joints", made.skin.inverse_bind.size()}};
    report_losses(conversion, layer, skinning, made, description, context);
    descriptions.push_back(std::move(description));
    add_parts(conversion, layer, skinning, motion, *std::move(mesh), baked);
  }
  if (baked.empty()) {
    throw Error(ErrorCode::kFailure, fmt::format("{}: no layer has a surface", conversion.input.string()));
  }
  return baked;
}

} // namespace

host::Mesh shifted(host::Mesh mesh, const Eigen::Vector3d& by) {
  for (Eigen::Vector3f& p : mesh.positions) p += by.cast<float>();
  return mesh;
}

void report_lost_frames(const Conversion& conversion, const clip::Layer& layer, Context& context) {
  const motion::Presence shown = clip::shown_frames(layer, conversion.clip->times.size());
  std::size_t lost = 0;
  std::size_t away = 0;
  for (const int frame : conversion.frames) {
    const bool is_lost = layer.motion.health(static_cast<std::size_t>(frame)) == motion::Health::kLost;
    if (!shown.at(frame))
      ++away;
    else if (is_lost)
      ++lost;
  }
  if (away > 0 && is_one_file(*conversion.format) && !host::supports(*conversion.format, KINORA_WRITES_HIDDEN)) {
    report_loss(conversion, fmt::format("{}: not there in {} frames, and shown all the same", layer.name, away),
                context);
  }
  if (lost > 0) {
    report_loss(conversion,
                fmt::format("{}: lost in {} frames, where it is shown at its last known place", layer.name, lost),
                context);
  }
}

void report_no_surface(const Conversion& conversion, const clip::Layer& layer, Context& context) {
  report_loss(conversion, layer.name + ": it has no surface and is left out", context);
}

Json convert_to_meshes(const Conversion& conversion, Context& context) {
  OutputWithFiles out(conversion.output, *conversion.format, context.shared.overwrite, {conversion.input});
  host::MeshWriter writer(*conversion.format, out.writing_path(), conversion.format_options, facts_of(conversion));
  Json descriptions = Json::array();
  const std::vector<BakedMesh> baked = bake_layers(conversion, descriptions, context);
  for (const BakedMesh& one : baked)
    writer.add(one.skinning.moves() ? one.mesh : shifted(one.mesh, -conversion.origin));
  context.progress.stage("writing", conversion.frames.size());
  const std::vector<double>& times = conversion.clip->times;
  const double start = times[static_cast<std::size_t>(conversion.frames.front())];
  for (std::size_t i = 0; i < conversion.frames.size(); ++i) {
    context.progress.check();
    const int frame = conversion.frames[i];
    for (std::size_t m = 0; m < baked.size(); ++m) {
      if (!baked[m].skinning.moves()) continue;
      std::vector<SE3> joints = baked[m].skinning.joints_at(frame);
      for (SE3& joint : joints) joint.translation() -= conversion.origin;
      writer.pose(m, times[static_cast<std::size_t>(frame)] - start, joints, !baked[m].shown.at(frame));
    }
    context.progress.advance(i + 1, "");
  }
  writer.finish();
  const std::uintmax_t bytes = out.commit();
  return {{"layers", std::move(descriptions)}, {"files", 1}, {"bytes", bytes}};
}

} // namespace kinora::cli
