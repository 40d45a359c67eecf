// The folders of the TUM RGB-D benchmark (Sturm et al., IROS 2012): lists of time stamps and file names.
#include "common/files.h"
#include "core/error.h"
#include "rgbd_folder/listing.h"
#include "rgbd_folder/numbering.h"
#include "rgbd_folder/trajectory.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr double kMaxTimeDifference = 0.02; ///< seconds; as the benchmark's associate.py
constexpr double kDefaultDepthUnit = 1.0 / 5000;
constexpr double kDefaultFramesPerSecond = 30;

struct Stamped {
  double time;
  fs::path file;
};

struct Pair {
  Stamped color;
  std::optional<Stamped> depth;
};

/// The words of every line that is not empty and no comment, with the line's number from 1.
struct Line {
  std::size_t number;
  std::vector<std::string_view> words;
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  std::size_t number = 0;
  for (const std::string_view line : split_lines(text)) {
    ++number;
    std::vector<std::string_view> words = split_words(line);
    if (!words.empty() && !words.front().starts_with('#')) lines.push_back({number, std::move(words)});
  }
  return lines;
}

std::optional<Stamped> stamped_at(const Line& line, std::size_t word, const fs::path& folder) {
  if (line.words.size() < word + 2) return std::nullopt;
  const std::optional<double> time = parse_number(line.words[word]);
  if (!time || !std::isfinite(*time)) return std::nullopt;
  return Stamped{*time, folder / line.words[word + 1]};
}

std::string bad_line(const fs::path& path, const Line& line, const char* expected) {
  return path.string() + ", line " + std::to_string(line.number) + ": left out, for it is not " + expected;
}

/// In order of time, with a warning if the file was not; a second image of the same time is left out.
template <class Item, class TimeOf>
void put_in_order(std::vector<Item>& items, const TimeOf& time_of, const fs::path& path,
                  std::vector<std::string>& warnings) {
  const auto earlier = [&](const Item& a, const Item& b) { return time_of(a) < time_of(b); };
  if (!std::is_sorted(items.begin(), items.end(), earlier)) {
    warnings.push_back(path.string() + ": the time stamps are out of order; frames are taken in order of time");
    std::stable_sort(items.begin(), items.end(), earlier);
  }
  const auto repeated =
      std::unique(items.begin(), items.end(), [&](const Item& a, const Item& b) { return time_of(a) == time_of(b); });
  if (repeated == items.end()) return;
  warnings.push_back(path.string() + ": " + std::to_string(items.end() - repeated) +
                     " images repeat the time stamp of another and are left out");
  items.erase(repeated, items.end());
}

std::vector<Stamped> read_list(const fs::path& path, std::vector<std::string>& warnings) {
  std::vector<Stamped> list;
  const std::string text = read_text(path);
  for (const Line& line : lines_of(text)) {
    if (std::optional<Stamped> entry = stamped_at(line, 0, path.parent_path()))
      list.push_back(std::move(*entry));
    else
      warnings.push_back(bad_line(path, line, "\"time file\""));
  }
  put_in_order(
      list, [](const Stamped& entry) { return entry.time; }, path, warnings);
  return list;
}

/// Each colour image with the depth image nearest in time; each depth image once, the closest pairs first.
std::vector<Pair> associate(const std::vector<Stamped>& colors, const std::vector<Stamped>& depths) {
  struct Candidate {
    double difference;
    std::size_t color;
    std::size_t depth;
  };
  std::vector<Candidate> candidates;
  std::size_t first = 0;
  for (std::size_t c = 0; c < colors.size(); ++c) {
    while (first < depths.size() && depths[first].time < colors[c].time - kMaxTimeDifference) ++first;
    for (std::size_t d = first; d < depths.size() && depths[d].time <= colors[c].time + kMaxTimeDifference; ++d)
      candidates.push_back({std::abs(depths[d].time - colors[c].time), c, d});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.difference < b.difference; });
  std::vector<Pair> pairs;
  pairs.reserve(colors.size());
  for (const Stamped& color : colors) pairs.push_back({color, std::nullopt});
  std::vector<bool> used(depths.size(), false);
  for (const Candidate& candidate : candidates) {
    if (pairs[candidate.color].depth || used[candidate.depth]) continue;
    pairs[candidate.color].depth = depths[candidate.depth];
    used[candidate.depth] = true;
  }
  return pairs;
}

/// associations.txt has colour first or depth first: the folder or file name that says "depth" decides.
std::vector<Pair> read_associations(const fs::path& path, std::vector<std::string>& warnings) {
  std::vector<Pair> pairs;
  const std::string text = read_text(path);
  for (const Line& line : lines_of(text)) {
    std::optional<Stamped> a = stamped_at(line, 0, path.parent_path());
    std::optional<Stamped> b = stamped_at(line, 2, path.parent_path());
    if (!a || !b) {
      warnings.push_back(bad_line(path, line, "\"time colour-file time depth-file\""));
      continue;
    }
    if (line.words[1].find("depth") != std::string_view::npos) std::swap(a, b);
    pairs.push_back({std::move(*a), std::move(b)});
  }
  put_in_order(
      pairs, [](const Pair& pair) { return pair.color.time; }, path, warnings);
  return pairs;
}

std::vector<Pair> read_pairs(const fs::path& folder, std::vector<std::string>& warnings) {
  if (const fs::path path = folder / "associations.txt"; fs::exists(path)) {
    std::vector<Pair> pairs = read_associations(path, warnings);
    if (!pairs.empty()) return pairs;
    warnings.push_back(path.string() + ": holds no pairs; rgb.txt and depth.txt are used instead");
  }
  const std::vector<Stamped> colors = read_list(folder / "rgb.txt", warnings);
  const std::vector<Stamped> depths = read_list(folder / "depth.txt", warnings);
  if (colors.empty() || depths.empty())
    throw Error(ErrorCode::kCorruptInput, (folder / (colors.empty() ? "rgb.txt" : "depth.txt")).string() +
                                              ": lists no images; write one \"time file\" per line");
  return associate(colors, depths);
}

/// Frames per second from the median step of time.
double median_rate(const std::vector<Pair>& pairs) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < pairs.size(); ++i) steps.push_back(pairs[i].color.time - pairs[i - 1].color.time);
  if (steps.empty()) return kDefaultFramesPerSecond;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle > 0 ? 1.0 / *middle : kDefaultFramesPerSecond;
}

void add_poses(Listing& listing, const fs::path& path) {
  const Trajectory trajectory = Trajectory::read(path, listing.warnings);
  std::size_t with_pose = 0;
  for (FrameFiles& frame : listing.frames) {
    frame.camera_to_world = trajectory.at(frame.time, kMaxTimeDifference);
    if (frame.camera_to_world) ++with_pose;
  }
  if (with_pose * 2 < listing.frames.size()) {
    listing.warnings.push_back(path.string() + ": has poses for only " + std::to_string(with_pose) + " of " +
                               std::to_string(listing.frames.size()) + " frames; no pose is used");
    for (FrameFiles& frame : listing.frames) frame.camera_to_world.reset();
    return;
  }
  listing.has_poses = true;
  for (FrameFiles& frame : listing.frames)
    if (!frame.camera_to_world && frame.problem.empty())
      frame.problem = frame.color.string() + ": has no pose within 20 ms in " + path.filename().string();
}

} // namespace

void probe_tum(const char* path, KinoraProbe* answer) {
  const fs::path folder = path;
  if (!fs::is_directory(folder)) return answer_probe(answer, 0, "not a folder");
  const bool pairs = fs::is_regular_file(folder / "associations.txt");
  const bool colors = fs::is_regular_file(folder / "rgb.txt");
  const bool depths = fs::is_regular_file(folder / "depth.txt");
  if (pairs) return answer_probe(answer, 95, "associations.txt");
  if (colors && depths) return answer_probe(answer, 95, "rgb.txt and depth.txt");
  if (colors || depths)
    return answer_probe(answer, 20, colors ? "rgb.txt without depth.txt" : "depth.txt without rgb.txt");
  answer_probe(answer, 0, "no associations.txt and no rgb.txt with depth.txt");
}

Listing list_tum(const fs::path& folder) {
  if (!fs::exists(folder / "associations.txt") && !(fs::exists(folder / "rgb.txt") && fs::exists(folder / "depth.txt")))
    throw Error(ErrorCode::kNotRecognised,
                folder.string() + ": not a TUM RGB-D folder; it needs associations.txt, or rgb.txt and depth.txt");
  Listing listing;
  const std::vector<Pair> pairs = read_pairs(folder, listing.warnings);
  listing.calibration = read_calibration({folder});
  if (!listing.calibration.depth_unit) listing.calibration.depth_unit = kDefaultDepthUnit;
  listing.frames_per_second = listing.calibration.frames_per_second.value_or(median_rate(pairs));

  const MaskIndex masks(folder);
  for (const Pair& pair : pairs) {
    FrameFiles frame;
    frame.time = pair.color.time;
    frame.color = pair.color.file;
    if (pair.depth)
      frame.depth = pair.depth->file;
    else
      frame.problem = frame.color.string() + ": has no depth image within 20 ms";
    frame.masks = masks.masks_of(frame.color);
    listing.frames.push_back(std::move(frame));
  }
  if (const fs::path path = folder / "groundtruth.txt"; fs::exists(path)) add_poses(listing, path);
  return listing;
}

} // namespace kinora::formats
