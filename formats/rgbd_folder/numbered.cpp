// color/NNNN.* beside depth/NNNN.png: DeepDeform, Open3D, depthkit exports and whatever people write themselves.
#include <set>

#include "common/files.h"
#include "common/numbering.h"
#include "core/error.h"
#include "rgbd_folder/listing.h"
#include "rgbd_folder/trajectory.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr const char* kColorFolders[] = {"color", "rgb", "colour", "image", "images"};
constexpr const char* kDepthFolder = "depth";

/// The colour folder, or an empty path.
fs::path find_color_folder(const fs::path& folder) {
  for (const char* name : kColorFolders)
    if (fs::is_directory(folder / name)) return folder / name;
  return {};
}

bool has_images(const fs::path& folder) {
  const std::vector<fs::path> files = list_files(folder);
  return std::any_of(files.begin(), files.end(), is_image_name);
}

/// Of Open3D: in its sample data beside the images, and where its reconstruction system writes it.
void add_poses(Listing& listing, const fs::path& folder) {
  for (const fs::path& path : {folder / "trajectory.log", folder / "scene" / "trajectory.log"}) {
    if (!fs::exists(path)) continue;
    const std::vector<SE3> poses = read_trajectory_log(path);
    listing.has_poses = poses.size() == listing.frames.size();
    if (!listing.has_poses)
      listing.warnings.push_back(path.string() + ": has " + std::to_string(poses.size()) + " poses for " +
                                 std::to_string(listing.frames.size()) + " frames; no pose is used");
    for (std::size_t i = 0; listing.has_poses && i < poses.size(); ++i) listing.frames[i].camera_to_world = poses[i];
    return;
  }
}

} // namespace

void probe_numbered(const char* path, KinoraProbe* answer) {
  const fs::path folder = path;
  if (!fs::is_directory(folder)) return answer_probe(answer, 0, "not a folder");
  const fs::path color = find_color_folder(folder);
  const bool depth = fs::is_directory(folder / kDepthFolder);
  if (color.empty() && !depth) return answer_probe(answer, 0, "no folder color/ or rgb/ and no folder depth/");
  if (color.empty()) return answer_probe(answer, 10, "depth/ without a folder color/ or rgb/");
  const std::string color_name = color.filename().string() + "/";
  if (!depth) return answer_probe(answer, 10, color_name + " without a folder depth/");
  if (!has_images(color) || !has_images(folder / kDepthFolder))
    return answer_probe(answer, 40, color_name + " and depth/, but one of them holds no images");
  answer_probe(answer, 80, color_name + " and depth/ with images");
}

Listing list_numbered(const fs::path& folder) {
  Listing listing;
  const fs::path color_folder = find_color_folder(folder);
  if (color_folder.empty() || !fs::is_directory(folder / kDepthFolder))
    throw Error(ErrorCode::kNotRecognised,
                folder.string() + ": not a folder of numbered images; it needs color/ (or rgb/) and depth/");
  const NumberedFiles colors = number_images(color_folder, listing.warnings);
  const NumberedFiles depths = number_images(folder / kDepthFolder, listing.warnings);
  if (colors.empty() || depths.empty())
    throw Error(ErrorCode::kCorruptInput, (colors.empty() ? color_folder : folder / kDepthFolder).string() +
                                              ": holds no images with a number in their name");
  listing.calibration = read_calibration({folder});
  if (!listing.calibration.depth_unit) listing.calibration.depth_unit = 0.001;
  listing.frames_per_second = listing.calibration.frames_per_second.value_or(30);

  const MaskIndex masks(folder);
  std::set<std::int64_t> numbers;
  for (const auto& [number, path] : colors) numbers.insert(number);
  for (const auto& [number, path] : depths) numbers.insert(number);
  for (const std::int64_t number : numbers) {
    FrameFiles frame;
    frame.time = static_cast<double>(number - *numbers.begin()) / listing.frames_per_second;
    const auto color = colors.find(number);
    const auto depth = depths.find(number);
    if (color != colors.end()) frame.color = color->second;
    if (depth != depths.end()) frame.depth = depth->second;
    if (color == colors.end())
      frame.problem = frame.depth.string() + ": has no colour image with the same number";
    else if (depth == depths.end())
      frame.problem = frame.color.string() + ": has no depth image with the same number";
    if (color != colors.end()) frame.masks = masks.masks_of(frame.color);
    listing.frames.push_back(std::move(frame));
  }
  add_poses(listing, folder);
  return listing;
}

} // namespace kinora::formats
