#include "cli/companions.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/picture_output.h"
#include "cli/unfinished.h"
#include "clip/clip_edit.h"
#include "container/reader.h"
#include "core/error.h"
#include "core/jpeg_writer.h"
#include "player/player.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

constexpr int kLongestSide = 640;         // of preview and poster, pixels
constexpr const char* kQuality = "30";    // crf of H.264's scale
constexpr const char* kJumpSeconds = "2"; // between pictures that players can jump to
constexpr int kPosterQuality = 85;
constexpr std::size_t kMostChapters = 10'000;

/// "83.5", "1:23.5" or "0:01:23.5".
std::optional<std::int64_t> parse_time(std::string_view text) {
  constexpr double kMinute = 60;
  double seconds = 0;
  for (int part = 0; part < 3; ++part) {
    const std::size_t colon = text.find(':');
    const std::string_view number = text.substr(0, colon);
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error != std::errc{} || end != number.data() + number.size() || !(value >= 0 && value < 1e9)) return {};
    seconds = kMinute * seconds + value;
    if (colon == std::string_view::npos) return std::llround(1e9 * seconds);
    text.remove_prefix(colon + 1);
  }
  return {};
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::vector<container::Chapter> read_chapters(const fs::path& path) {
  require_input(path);
  std::ifstream file(path);
  std::vector<container::Chapter> chapters;
  std::string text;
  for (int number = 1; std::getline(file, text); ++number) {
    const std::string_view line = trimmed(text);
    if (line.empty()) continue;
    const std::size_t space = std::min(line.find_first_of(" \t"), line.size());
    const std::optional<std::int64_t> time = parse_time(line.substr(0, space));
    const std::string_view title = trimmed(line.substr(space));
    const auto wrong = [&](std::string_view why) {
      throw Error(ErrorCode::kCorruptInput, fmt::format("{}: line {}: {}", path.string(), number, why));
    };
    if (!time || title.empty()) wrong("no chapter; give a time and a title, such as: 0:12.5 The chair");
    if (!chapters.empty() && *time <= chapters.back().time_ns) wrong("this chapter does not come after the one before");
    if (chapters.size() == kMostChapters) wrong("too many chapters");
    chapters.push_back({*time, std::string(title)});
  }
  if (chapters.empty()) throw Error(ErrorCode::kCorruptInput, fmt::format("{}: no chapter in it", path.string()));
  return chapters;
}

std::pair<std::string, std::string> parse_tag(const std::string& text) {
  const std::size_t equals = text.find('=');
  std::string name = text.substr(0, equals);
  std::ranges::transform(name, name.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  const bool plain = !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (equals == std::string::npos || !plain) {
    throw Error(ErrorCode::kUsage, fmt::format("--tag {}: give NAME=VALUE, such as TITLE=\"The chair\"", text));
  }
  if (name.starts_with("KINORA_"))
    throw Error(ErrorCode::kUsage, fmt::format("--tag {}: names that begin with KINORA_ are Kinora's own", text));
  return {std::move(name), text.substr(equals + 1)};
}

ColorImage over_black(const ColorImage& picture) {
  constexpr int kOpaque = 255;
  ColorImage flat(picture.width(), picture.height(), 3);
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const std::uint8_t* from = picture.data() + 4 * i;
    for (std::size_t c = 0; c < 3; ++c)
      flat.data()[3 * i + c] = static_cast<std::uint8_t>((from[c] * from[3] + kOpaque / 2) / kOpaque);
  }
  return flat;
}

// Draws all frames into a film, and takes its track out of it: a WebM file is a Matroska file.
void draw_preview(const fs::path& clip_file, clip::StoredClip& stored, Context& context) {
  const player::Player player(open_clip(clip_file, context.progress));
  const clip::Clip& clip = player.clip();
  const std::size_t frames = clip.times.size();
  const Unfinished folder(clip_file, Unfinished::Kind::kFolder);
  PictureRequest request{folder.path() / "preview.webm", {}, false, {}, {}};
  request.options = {{"fps", fmt::format("{}", frames_per_second(clip))}, {"crf", kQuality}, {"jump", kJumpSeconds}};
  const auto film = PictureOutput::open(request, {}, context.plugins());
  context.progress.stage("drawing the preview", frames);
  for (std::size_t i = 0; i < frames; ++i) {
    context.progress.check();
    const auto frame = static_cast<double>(i);
    Camera camera = clip.capture_camera(frame);
    const Intrinsics& k = camera.intrinsics;
    const double scale = std::min(1.0, static_cast<double>(kLongestSide) / std::max(k.width, k.height));
    camera.intrinsics = k.resized(std::max(1, static_cast<int>(std::lround(scale * k.width))),
                                  std::max(1, static_cast<int>(std::lround(scale * k.height))));
    DrawnPicture drawn{player.draw(camera, frame, player.all_layers()), "", clip.times[i], camera};
    if (i == frames / 2) {
      std::vector<std::byte> jpeg = encode_jpeg(over_black(drawn.picture.color), kPosterQuality);
      stored.poster = container::Attachment{clip::kPosterFile, "image/jpeg", "Poster", std::move(jpeg)};
    }
    film->add(drawn);
    context.progress.advance(i + 1, "");
  }
  film->finish();

  container::Reader reader(request.path);
  container::Preview preview{reader.tracks().at(0).track, {}};
  preview.track.id = container::kPreviewTrack;
  preview.track.name = container::kPreviewName;
  container::StoredBlock block;
  while (reader.next_block(block)) {
    const std::size_t i = std::min(preview.packets.size(), frames - 1); // one for each frame, in their order
    preview.packets.push_back(
        {container::kPreviewTrack, stored.description.times_ns[i], block.key, reader.read_block(block)});
  }
  stored.preview = std::move(preview);
}

void replace_tags(const container::Tags& tags, container::Tags& all) {
  for (const auto& replacement : tags) {
    std::erase_if(all, [&replacement](const auto& tag) { return tag.first == replacement.first; });
    if (!replacement.second.empty()) all.push_back(replacement);
  }
}

void replace_chapters(std::vector<container::Chapter> chapters, clip::StoredClip& stored, Context& context) {
  const std::int64_t end = stored.description.times_ns.back();
  const auto late = std::ranges::find_if(chapters, [end](const auto& chapter) { return chapter.time_ns > end; });
  if (late != chapters.end()) {
    context.progress.warn(fmt::format("chapter \"{}\" would begin behind the last frame, at {:.2f} s; it is left out, "
                                      "with those that follow",
                                      late->title, 1e-9 * static_cast<double>(end)));
  }
  chapters.erase(late, chapters.end());
  stored.chapters = std::move(chapters);
}

} // namespace

void add_companion_options(CLI::App& command, CompanionOptions& options) {
  command.add_flag("--flat-preview", options.preview,
                   "Add a flat film (VP9) of what the capture's camera saw, as the clip shows it, and a poster: "
                   "any player of Matroska files plays it");
  command
      .add_option("--chapters", options.chapters,
                  "Chapters: a file with a time and a title on each line, such as 0:12.5 The chair")
      ->type_name("FILE");
  command
      .add_option(
          "--tag", options.tags,
          "Write this about the clip into its file: TITLE, ARTIST, DATE_RECORDED, COPYRIGHT, COMMENT or another "
          "name; may be repeated, and an empty value removes one")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
}

Companions companions_of(const CompanionOptions& options) {
  Companions companions;
  companions.preview = options.preview;
  if (!options.chapters.empty()) companions.chapters = read_chapters(options.chapters);
  std::ranges::transform(options.tags, std::back_inserter(companions.tags), parse_tag);
  return companions;
}

void add_companions(const fs::path& clip_file, const Companions& companions, Context& context) {
  if (companions.empty()) return;
  clip::StoredClip stored = clip::load_stored_clip(clip_file);
  if (companions.preview) draw_preview(clip_file, stored, context);
  if (!companions.chapters.empty()) replace_chapters(companions.chapters, stored, context);
  replace_tags(companions.tags, stored.tags);
  Unfinished whole(clip_file, Unfinished::Kind::kFile);
  clip::write_stored_clip(stored, whole.path());
  fs::rename(whole.path(), clip_file);
}

} // namespace kinora::cli
