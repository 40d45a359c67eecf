// Sequences of M3T (Stoiber et al., "A Multi-body Tracking Framework", 2022): a colour and a depth camera, each
// described by an OpenCV .yaml file, with images numbered from `load_index` on. The cameras are not registered.
#include <cmath>
#include <map>

#include "common/files.h"
#include "common/numbering.h"
#include "core/error.h"
#include "rgbd_folder/listing.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxCalibrationBytes = 1U << 20;
constexpr double kMaxSide = 16384;

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// The scalars and number lists of an OpenCV .yaml file, "key" or "parent/key". A list may go over several lines.
std::map<std::string, std::string> read_entries(const fs::path& path) {
  std::map<std::string, std::string> entries;
  const std::string text = read_text(path);
  std::string parent;
  std::string* open_list = nullptr;
  for (const std::string_view line : split_lines(text)) {
    if (open_list != nullptr) {
      open_list->append(" ").append(trimmed(line));
      if (line.find(']') != std::string_view::npos) open_list = nullptr;
      continue;
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || line.starts_with('%')) continue;
    const bool nested = line.starts_with(' ') || line.starts_with('\t');
    const std::string key(trimmed(line.substr(0, colon)));
    std::string value(trimmed(line.substr(colon + 1)));
    if (!nested) parent = key;
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
    std::string& entry = entries[nested ? std::string(parent).append("/").append(key) : key];
    entry = std::move(value);
    if (entry.starts_with('[') && entry.find(']') == std::string::npos) open_list = &entry;
  }
  return entries;
}

/// One camera of the sequence.
struct CameraFile {
  fs::path path;
  std::map<std::string, std::string> entries;

  bool is_depth() const { return entries.contains("depth_scale"); }
  const std::string& text(const std::string& key) const {
    const auto found = entries.find(key);
    if (found == entries.end()) fail(path, "the key \"" + key + "\" is missing; add it");
    return found->second;
  }
  double number(const std::string& key) const {
    const std::optional<double> value = parse_number(text(key));
    if (!value || !std::isfinite(*value)) fail(path, "\"" + key + "\" must be a number");
    return *value;
  }
  double positive(const std::string& key, double limit) const {
    const double value = number(key);
    if (!(value > 0 && value <= limit)) fail(path, "\"" + key + "\" is absurd; correct it");
    return value;
  }
  Intrinsics intrinsics() const;
  SE3 camera_to_world() const;
  NumberedFiles images() const;
};

Intrinsics CameraFile::intrinsics() const {
  Intrinsics intrinsics{static_cast<int>(positive("intrinsics/width", kMaxSide)),
                        static_cast<int>(positive("intrinsics/height", kMaxSide)),
                        positive("intrinsics/f_u", 1e6),
                        positive("intrinsics/f_v", 1e6),
                        number("intrinsics/pp_x"),
                        number("intrinsics/pp_y")};
  intrinsics.validate(path.string());
  return intrinsics;
}

SE3 CameraFile::camera_to_world() const {
  const std::string& list = text("camera2world_pose/data");
  if (!list.starts_with('[') || !list.ends_with(']')) fail(path, "\"camera2world_pose\" has no list [ … ] of numbers");
  const std::string_view inside = std::string_view(list).substr(1, list.size() - 2);
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix;
  const std::vector<std::string_view> words = split_words(inside);
  if (words.size() != 16) fail(path, "\"camera2world_pose\" must hold 16 numbers");
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::optional<double> value = parse_number(words[i]);
    if (!value) fail(path, "\"camera2world_pose\" must hold 16 numbers");
    matrix.data()[i] = *value;
  }
  return rigid_from_matrix(matrix, (path.string() + ": \"camera2world_pose\"").c_str());
}

/// Images of this camera by their place in the sequence, from 0.
NumberedFiles CameraFile::images() const {
  const std::string& before = text("image_name_pre");
  const auto after = entries.find("image_name_post");
  const std::string ending = (after == entries.end() ? std::string() : after->second) + "." + text("load_image_type");
  constexpr double kMaxIndex = 1e9;
  const double index = number("load_index");
  if (!(std::abs(index) <= kMaxIndex)) fail(path, "\"load_index\" is absurd");
  const std::int64_t first = std::llround(index);
  NumberedFiles images;
  for (const fs::path& file : list_files((path.parent_path() / text("load_directory")).lexically_normal())) {
    const std::string name = file.filename().string();
    if (name.size() <= before.size() + ending.size() || !name.starts_with(before) || !name.ends_with(ending)) continue;
    const std::string digits = name.substr(before.size(), name.size() - before.size() - ending.size());
    if (!std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c) != 0; })) continue;
    const std::optional<std::int64_t> number_of_file = number_in_name(digits);
    if (number_of_file && *number_of_file >= first) images[*number_of_file - first] = file;
  }
  if (images.empty()) fail(path, "has no images \"" + before + "<number>" + ending + "\" in its load_directory");
  return images;
}

struct CameraPair {
  CameraFile color;
  CameraFile depth;
};

/// The .yaml files of a folder that describe cameras: exactly one of each kind, or nothing.
std::optional<CameraPair> find_pair(const fs::path& folder) {
  std::vector<CameraFile> colors, depths;
  for (const fs::path& path : list_files(folder)) {
    if (path.extension() != ".yaml" || fs::file_size(path) > kMaxCalibrationBytes) continue;
    CameraFile camera{path, read_entries(path)};
    if (!camera.entries.contains("intrinsics/f_u") || !camera.entries.contains("image_name_pre")) continue;
    (camera.is_depth() ? depths : colors).push_back(std::move(camera));
  }
  if (colors.size() != 1 || depths.size() != 1) return std::nullopt;
  return CameraPair{std::move(colors.front()), std::move(depths.front())};
}

/// In the folder itself, or in the first of its folders that has one: M3T keeps bodies and sequences side by side.
std::optional<CameraPair> search_pair(const fs::path& folder) {
  if (!fs::is_directory(folder)) return std::nullopt;
  if (auto pair = find_pair(folder)) return pair;
  std::vector<fs::path> inner;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) inner.push_back(entry.path());
  std::sort(inner.begin(), inner.end());
  for (const fs::path& path : inner)
    if (auto pair = find_pair(path)) return pair;
  return std::nullopt;
}

} // namespace

void probe_m3t(const char* path, KinoraProbe* answer) {
  const std::optional<CameraPair> pair = search_pair(path);
  if (!pair) return answer_probe(answer, 0, "no .yaml files of one colour and one depth camera");
  answer_probe(answer, 90,
               pair->color.path.filename().string() + " and " + pair->depth.path.filename().string() +
                   " describe a colour and a depth camera");
}

Listing list_m3t(const fs::path& folder) {
  const std::optional<CameraPair> pair = search_pair(folder);
  if (!pair)
    throw Error(ErrorCode::kNotRecognised,
                folder.string() + ": not an M3T sequence; it needs a .yaml file of a colour and one of a depth camera");
  Listing listing;
  listing.calibration.intrinsics = pair->color.intrinsics();
  listing.calibration.source = pair->color.path;
  listing.calibration.depth_unit = pair->depth.positive("depth_scale", 1);
  listing.depth_camera = DepthCamera{
      pair->depth.intrinsics(), {}, pair->color.camera_to_world().inverse() * pair->depth.camera_to_world()};
  NumberedFiles colors = pair->color.images();
  NumberedFiles depths = pair->depth.images();
  std::map<std::int64_t, FrameFiles> frames;
  for (const auto& [number, file] : colors) frames[number].color = file;
  for (const auto& [number, file] : depths) frames[number].depth = file;
  for (auto& [number, frame] : frames) {
    frame.time = static_cast<double>(number - frames.begin()->first) / listing.frames_per_second;
    if (frame.color.empty()) frame.problem = frame.depth.string() + ": has no colour image with the same number";
    if (frame.depth.empty()) frame.problem = frame.color.string() + ": has no depth image with the same number";
    listing.frames.push_back(std::move(frame));
  }
  return listing;
}

} // namespace kinora::formats
