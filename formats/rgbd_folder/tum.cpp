// The folders of the TUM RGB-D benchmark (Sturm et al., IROS 2012): lists of time stamps and file names.
#include <queue>

#include "common/files.h"
#include "common/numbering.h"
#include "core/error.h"
#include "rgbd_folder/listing.h"
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

/// One warning for all lines of a file that are left out, however many.
void warn_of_bad_lines(const fs::path& path, const std::vector<std::size_t>& numbers, const char* expected,
                       std::vector<std::string>& warnings) {
  if (numbers.empty()) return;
  std::string warning = path.string() + ", line " + std::to_string(numbers.front());
  if (numbers.size() > 1) warning += " and " + std::to_string(numbers.size() - 1) + " more";
  warnings.push_back(warning + ": left out, for it is not " + expected);
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
  std::vector<std::size_t> bad_lines;
  const std::string text = read_text(path);
  for (const Line& line : lines_of(text)) {
    if (std::optional<Stamped> entry = stamped_at(line, 0, path.parent_path()))
      list.push_back(std::move(*entry));
    else
      bad_lines.push_back(line.number);
  }
  warn_of_bad_lines(path, bad_lines, "\"time file\"", warnings);
  put_in_order(
      list, [](const Stamped& entry) { return entry.time; }, path, warnings);
  return list;
}

/// An image of either list in the order of time, and its neighbours that are not paired yet.
struct Neighbour {
  double time;
  bool is_color;
  std::size_t index; ///< in its list
  std::size_t before;
  std::size_t after;
};

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

std::vector<Neighbour> in_order_of_time(const std::vector<Stamped>& colors, const std::vector<Stamped>& depths) {
  std::vector<Neighbour> merged;
  merged.reserve(colors.size() + depths.size());
  for (std::size_t c = 0; c < colors.size(); ++c) merged.push_back({colors[c].time, true, c, 0, 0});
  for (std::size_t d = 0; d < depths.size(); ++d) merged.push_back({depths[d].time, false, d, 0, 0});
  std::stable_sort(merged.begin(), merged.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.time < b.time; });
  for (std::size_t i = 0; i < merged.size(); ++i) {
    merged[i].before = i == 0 ? kNone : i - 1;
    merged[i].after = i + 1 == merged.size() ? kNone : i + 1;
  }
  return merged;
}

/// Each colour image with the depth image nearest in time; each depth image once, the closest pairs first. The closest
/// pair are always neighbours among what is left, so that memory grows with the lists, whatever their times are.
std::vector<Pair> associate(const std::vector<Stamped>& colors, const std::vector<Stamped>& depths) {
  std::vector<Pair> pairs;
  pairs.reserve(colors.size());
  for (const Stamped& color : colors) pairs.push_back({color, std::nullopt});
  std::vector<Neighbour> images = in_order_of_time(colors, depths);
  struct Candidate {
    double difference;
    std::size_t first; ///< numbers in `images`
    std::size_t second;
    bool operator>(const Candidate& other) const {
      return std::tie(difference, first) > std::tie(other.difference, other.first);
    }
  };
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates;
  const auto consider = [&](std::size_t first, std::size_t second) {
    if (first == kNone || second == kNone || images[first].is_color == images[second].is_color) return;
    const double difference = images[second].time - images[first].time;
    if (difference <= kMaxTimeDifference) candidates.push({difference, first, second});
  };
  for (std::size_t i = 1; i < images.size(); ++i) consider(i - 1, i);
  std::vector<bool> used(images.size(), false);
  while (!candidates.empty()) {
    const auto [difference, first, second] = candidates.top();
    candidates.pop();
    if (used[first] || used[second]) continue;
    used[first] = used[second] = true;
    const std::size_t color = images[first].is_color ? first : second;
    pairs[images[color].index].depth = depths[images[color == first ? second : first].index];
    const std::size_t before = images[first].before;
    const std::size_t after = images[second].after;
    if (before != kNone) images[before].after = after;
    if (after != kNone) images[after].before = before;
    consider(before, after);
  }
  return pairs;
}

/// associations.txt has colour first or depth first: the folder or file name that says "depth" decides.
std::vector<Pair> read_associations(const fs::path& path, std::vector<std::string>& warnings) {
  std::vector<Pair> pairs;
  std::vector<std::size_t> bad_lines;
  const std::string text = read_text(path);
  for (const Line& line : lines_of(text)) {
    std::optional<Stamped> a = stamped_at(line, 0, path.parent_path());
    std::optional<Stamped> b = stamped_at(line, 2, path.parent_path());
    if (!a || !b) {
      bad_lines.push_back(line.number);
      continue;
    }
    if (line.words[1].find("depth") != std::string_view::npos) std::swap(a, b);
    pairs.push_back({std::move(*a), std::move(b)});
  }
  warn_of_bad_lines(path, bad_lines, "\"time colour-file time depth-file\"", warnings);
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
