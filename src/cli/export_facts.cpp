// What an export says of itself: in its files, and on the last line of kinora convert.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/clip_input.h"
#include "cli/conversion.h"

namespace kinora::cli {
namespace {

std::string frames_text(const std::vector<int>& frames) {
  return frames.size() == 1 ? fmt::format("{}", frames.front())
                            : fmt::format("{} to {}, {} of them", frames.front(), frames.back(), frames.size());
}

std::string layers_text(const Conversion& conversion) {
  std::vector<std::string> names;
  for (const std::size_t i : conversion.layers) names.push_back(conversion.clip->layers[i].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

} // namespace

host::Facts facts_of(const Conversion& conversion) {
  const bool meshes = host::supports(*conversion.format, KINORA_WRITES_MESHES);
  const Eigen::Vector3d& o = conversion.origin;
  host::Facts facts = {
      {"source", conversion.input.filename().string()},
      {"frames", frames_text(conversion.frames)},
      {"fps", fmt::format("{:g}", conversion.fps > 0 ? conversion.fps : frames_per_second(*conversion.clip))},
      {"layers", layers_text(conversion)},
      {"origin", fmt::format("{:g}, {:g}, {:g}", o.x() + 0.0, 0.0 - o.y(), 0.0 - o.z())}};
  if (meshes) facts.emplace_back("triangles", fmt::format("at most {} per layer", conversion.surface.triangles));
  if (meshes)
    facts.emplace_back("error", fmt::format("{:g} m, of what is still {:g} m, of floors {:g} m",
                                            conversion.surface.simplification, conversion.surface.still_simplification,
                                            conversion.surface.flat_simplification));
  if (!meshes) facts.emplace_back("voxel", fmt::format("{:g} m", conversion.volume.voxel));
  facts.emplace_back("lost", fmt::format("{}", fmt::join(losses_of(conversion), "; ")));
  return facts;
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
  const bool has_joints = std::ranges::any_of(
      conversion.layers, [&](std::size_t i) { return conversion.clip->layers[i].joints.has_value(); });
  if (has_joints) losses.emplace_back("the skeleton (kinora motion writes it)");
  return losses;
}

} // namespace kinora::cli
