#include "cli/export_facts.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/clip_input.h"

namespace kinora::cli {
namespace {

template <class Number> std::string frames_text(Number first, Number last, std::size_t count) {
  return count == 1 ? fmt::format("{}", first) : fmt::format("{} to {}, {} of them", first, last, count);
}

std::string layers_text(const clip::Clip& clip, const clip::LayerChoice& layers) {
  std::vector<std::string> names;
  for (const std::size_t i : layers) names.push_back(clip.layers[i].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// What no export of a clip has a place for.
void add_common_losses(const clip::Clip& clip, const clip::LayerChoice& layers, std::vector<std::string>& losses) {
  const bool has_joints = std::ranges::any_of(layers, [&](std::size_t i) { return clip.layers[i].joints.has_value(); });
  if (has_joints) losses.emplace_back("the skeleton (kinora motion writes it)");
  if (clip.sound) losses.emplace_back("the sound");
}

std::string joined(const std::vector<std::string>& losses) { return fmt::format("{}", fmt::join(losses, "; ")); }

} // namespace

host::Facts facts_of(const Conversion& conversion) {
  const bool meshes = host::supports(*conversion.format, KINORA_WRITES_MESHES);
  const std::vector<int>& frames = conversion.frames;
  const Eigen::Vector3d& o = conversion.origin;
  host::Facts facts = {
      {"source", conversion.input.filename().string()},
      {"frames", frames_text(frames.front(), frames.back(), frames.size())},
      {"fps", fmt::format("{:g}", conversion.fps > 0 ? conversion.fps : frames_per_second(*conversion.clip))},
      {"layers", layers_text(*conversion.clip, conversion.layers)},
      {"origin", fmt::format("{:g}, {:g}, {:g}", o.x() + 0.0, 0.0 - o.y(), 0.0 - o.z())}};
  if (meshes) facts.emplace_back("triangles", fmt::format("at most {} per layer", conversion.surface.triangles));
  if (meshes)
    facts.emplace_back("error", fmt::format("{:g} m, of what is still {:g} m, of floors {:g} m",
                                            conversion.surface.simplification, conversion.surface.still_simplification,
                                            conversion.surface.flat_simplification));
  if (!meshes) facts.emplace_back("voxel", fmt::format("{:g} m", conversion.volume.voxel));
  facts.emplace_back("lost", joined(losses_of(conversion)));
  return facts;
}

host::Facts facts_of(const PictureExport& pictures) {
  const std::vector<player::View>& views = pictures.views;
  const auto [first, last] = std::ranges::minmax(views, {}, &player::View::frame);
  return {{"source", pictures.input.filename().string()},
          {"frames", frames_text(first.frame, last.frame, views.size())},
          {"fps", fmt::format("{:g}", frames_per_second(pictures.clip))},
          {"layers", layers_text(pictures.clip, pictures.layers)},
          {"cameras", pictures.cameras},
          {"lost", joined(losses_of(pictures))}};
}

std::vector<std::string> losses_of(const Conversion& conversion) {
  std::vector<std::string> losses;
  const bool meshes = host::supports(*conversion.format, KINORA_WRITES_MESHES);
  if (meshes) losses.emplace_back("what is half transparent");
  if (meshes) losses.emplace_back("how colours change while things turn (their mean is written)");
  if (meshes && !host::supports(*conversion.format, KINORA_WRITES_TEXTURES))
    losses.emplace_back("colours finer than the triangles");
  if (!meshes) losses.push_back(fmt::format("what is finer than {:g} m", conversion.volume.voxel));
  if (is_one_file(*conversion.format)) {
    if (conversion.clip->camera_to_world.size() > 1) losses.emplace_back("the camera's path");
  } else if (conversion.frames.size() > 1) {
    losses.emplace_back("the times of the frames");
  }
  if (conversion.fps > 0) losses.push_back(fmt::format("frames between those of {:g} per second", conversion.fps));
  add_common_losses(*conversion.clip, conversion.layers, losses);
  return losses;
}

std::vector<std::string> losses_of(const PictureExport& pictures) {
  const auto has = [&](std::uint64_t capability) { return host::supports(pictures.format, capability); };
  const bool has_depth =
      has(KINORA_WRITES_METRIC_DEPTH) || std::ranges::find(pictures.passes, "depth") != pictures.passes.end();
  std::vector<std::string> losses = {"what these cameras do not see"};
  if (!has(KINORA_WRITES_ALPHA)) losses.emplace_back("opacity (all is on black)");
  if (!has_depth) losses.emplace_back("depth");
  if (!has(KINORA_WRITES_LABELS)) losses.emplace_back("which layer is where");
  if (!has(KINORA_WRITES_CAMERAS)) losses.emplace_back("where the cameras are");
  if (!has(KINORA_WRITES_CAMERAS) && !has(KINORA_WRITES_FILM) && pictures.views.size() > 1)
    losses.emplace_back("the times of the frames");
  if (has(KINORA_WRITES_FILM)) losses.emplace_back("colours finer than two pixels");
  add_common_losses(pictures.clip, pictures.layers, losses);
  return losses;
}

std::string losses_text(const std::vector<std::string>& losses) { return "Not in it: " + joined(losses) + ".\n"; }

} // namespace kinora::cli
