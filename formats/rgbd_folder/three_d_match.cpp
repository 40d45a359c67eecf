// frame-NNNNNN.{color,depth}.* with .pose.txt: 3DMatch (Zeng et al., CVPR 2017) and 7-Scenes.
#include <set>

#include "common/files.h"
#include "common/numbering.h"
#include "core/error.h"
#include "rgbd_folder/listing.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

struct FramesByNumber {
  NumberedFiles colors;
  NumberedFiles depths;
  NumberedFiles poses;
};

FramesByNumber sort_files(const fs::path& folder) {
  FramesByNumber frames;
  for (const fs::path& path : list_files(folder)) {
    const std::string name = path.filename().string();
    if (!name.starts_with("frame-")) continue;
    const std::string kind = path.stem().extension().string();
    const std::optional<std::int64_t> number = number_in_name(path.stem().stem().string());
    if (!number) continue;
    if (kind == ".color" && is_image_name(path))
      frames.colors.emplace(*number, path);
    else if (kind == ".depth" && path.extension() == ".png")
      frames.depths.emplace(*number, path);
    else if (name.ends_with(".pose.txt"))
      frames.poses.emplace(*number, path);
  }
  return frames;
}

bool has_frames(const fs::path& folder) {
  const std::vector<fs::path> files = list_files(folder);
  return std::any_of(files.begin(), files.end(), [](const fs::path& path) {
    return path.filename().string().starts_with("frame-") && path.stem().extension() == ".color" && is_image_name(path);
  });
}

/// The folder itself, or those directly below it, that hold frames; in the order of their names.
std::vector<fs::path> find_frame_folders(const fs::path& folder) {
  if (has_frames(folder)) return {folder};
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::error_code ignored; entry->is_directory(ignored) && has_frames(entry->path())) found.push_back(*entry);
  std::sort(found.begin(), found.end());
  return found;
}

} // namespace

void probe_3dmatch(const char* path, KinoraProbe* answer) {
  const fs::path folder = path;
  if (!fs::is_directory(folder)) return answer_probe(answer, 0, "not a folder");
  const std::vector<fs::path> found = find_frame_folders(folder);
  if (found.empty()) return answer_probe(answer, 0, "no images named frame-NNNNNN.color.*, here or one folder below");
  const FramesByNumber frames = sort_files(found.front());
  if (frames.depths.empty()) return answer_probe(answer, 40, "frame-NNNNNN.color.* without frame-NNNNNN.depth.png");
  answer_probe(answer, 90,
               "frame-NNNNNN.color.* and .depth.png" + std::string(frames.poses.empty() ? "" : " and .pose.txt"));
}

Listing list_3dmatch(const fs::path& folder) {
  const std::vector<fs::path> found = find_frame_folders(folder);
  if (found.empty())
    throw Error(ErrorCode::kNotRecognised,
                folder.string() + ": not a 3DMatch folder; it needs images named frame-NNNNNN.color.* and .depth.png");
  Listing listing;
  if (found.size() > 1)
    listing.warnings.push_back(folder.string() + ": holds " + std::to_string(found.size()) +
                               " sequences; only the first, " + found.front().filename().string() + ", is read");
  const FramesByNumber files = sort_files(found.front());
  if (files.depths.empty())
    throw Error(ErrorCode::kCorruptInput, found.front().string() + ": has no depth images frame-NNNNNN.depth.png");
  listing.calibration = read_calibration({found.front(), fs::absolute(found.front()).parent_path()});
  if (!listing.calibration.depth_unit) listing.calibration.depth_unit = 0.001;
  listing.frames_per_second = listing.calibration.frames_per_second.value_or(30);
  listing.has_poses = !files.poses.empty();

  const MaskIndex masks(found.front());
  std::set<std::int64_t> numbers;
  for (const auto& [number, path] : files.colors) numbers.insert(number);
  for (const auto& [number, path] : files.depths) numbers.insert(number);
  for (const std::int64_t number : numbers) {
    FrameFiles frame;
    frame.time = static_cast<double>(number - *numbers.begin()) / listing.frames_per_second;
    if (const auto color = files.colors.find(number); color != files.colors.end()) frame.color = color->second;
    if (const auto depth = files.depths.find(number); depth != files.depths.end()) frame.depth = depth->second;
    if (const auto pose = files.poses.find(number); pose != files.poses.end()) frame.pose_file = pose->second;
    if (frame.color.empty())
      frame.problem = frame.depth.string() + ": has no colour image with the same number";
    else if (frame.depth.empty())
      frame.problem = frame.color.string() + ": has no depth image with the same number";
    else if (listing.has_poses && frame.pose_file.empty())
      frame.problem = frame.color.string() + ": has no .pose.txt with the same number, though other frames have one";
    if (!frame.color.empty()) frame.masks = masks.masks_of(frame.color.parent_path() / frame.color.stem().stem());
    listing.frames.push_back(std::move(frame));
  }
  return listing;
}

} // namespace kinora::formats
