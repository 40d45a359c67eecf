// kinora info: what an input is, what it holds, and where every byte went.
#include <algorithm>
#include <map>
#include <memory>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/capture_input.h"
#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/file_check.h"
#include "cli/text.h"
#include "clip/codec_ids.h"
#include "container/reader.h"
#include "core/error.h"
#include "ingest/capture/capture.h"
#include "recording/recording_file.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

Json intrinsics_json(const Intrinsics& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

Json away_json(const motion::Presence& presence) {
  Json spans = Json::array();
  for (const motion::FrameSpan& span : presence.away()) spans.push_back({span.begin, span.end});
  return spans;
}

/// For people: "object is away in frames 0 to 11 and 80 to 89".
std::string away_text(const Json& info) {
  std::string text;
  for (const Json& layer : info["layers"]) {
    if (!layer.contains("away")) continue;
    std::vector<std::string> spans;
    for (const Json& span : layer["away"])
      spans.push_back(fmt::format("{} to {}", span[0].get<std::size_t>(), span[1].get<std::size_t>() - 1));
    text += fmt::format("{} is away in frames {}\n", layer["name"].get<std::string>(), fmt::join(spans, ", "));
  }
  return text;
}

Json layer_json(const clip::Layer& layer, std::size_t frames) {
  std::map<std::string, int> health;
  for (std::size_t i = 0; i < frames; ++i) ++health[std::string(motion::name_of(layer.motion.health(i)))];
  Json out = {{"name", layer.name},
              {"label", layer.label},
              {"motion", motion::name_of(layer.motion.kind())},
              {"frames", health},
              {"parameters", layer.field.parameter_count()},
              {"box_side_m", layer.field.config.box.side}};
  if (layer.motion.graph()) out["nodes"] = layer.motion.graph()->nodes().size();
  const std::vector<std::uint32_t>& births = layer.births.frames();
  if (!births.empty())
    out["nodes_born_late"] = std::count_if(births.begin(), births.end(), [](std::uint32_t frame) { return frame > 0; });
  if (!layer.presence.is_always()) out["away"] = away_json(layer.presence);
  return out;
}

std::size_t per_frame(std::size_t bytes, std::size_t frames) { return frames > 0 ? (bytes + frames / 2) / frames : 0; }

struct Options {
  fs::path input;
  bool strict = false;
  CaptureReading reading;
};

Json clip_json(const fs::path& path, Context& context) {
  clip::ByteAccount account;
  std::vector<std::string> missing;
  const clip::Clip clip = open_clip(path, context.progress, &account, &missing);
  const container::Reader reader(path, container::Reading::kSalvage);
  Json out = {{"schema", "kinora.info/1"},
              {"path", path.string()},
              {"kind", "clip"},
              {"live", reader.tag(container::kKindTag) == clip::kLiveClipKind},
              {"bytes", account.total},
              {"frames", clip.times.size()},
              {"bytes_per_frame", per_frame(account.total, clip.times.size())},
              {"frames_per_second", frames_per_second(clip)},
              {"duration_s", clip.times.back() - clip.times.front()},
              {"camera", clip.camera_to_world.size() > 1 ? "moving" : "still"},
              {"intrinsics", intrinsics_json(clip.intrinsics)},
              {"layers", Json::array()},
              {"parts", Json::array()},
              {"chapters", Json::array()},
              {"tags", Json::object()},
              {"missing", missing},
              {"metadata", clip.metadata}};
  for (const container::Chapter& chapter : reader.chapters()) {
    constexpr double kNanoseconds = 1e9;
    out["chapters"].push_back(
        {{"time_s", static_cast<double>(chapter.time_ns) / kNanoseconds}, {"title", chapter.title}});
  }
  for (const auto& [name, value] : reader.tags()) {
    if (name != container::kKindTag && name != container::kVersionTag) out["tags"][name] = value;
  }
  for (const clip::Layer& layer : clip.layers) out["layers"].push_back(layer_json(layer, clip.times.size()));
  for (const auto& entry : account.entries) out["parts"].push_back({{"name", entry.name}, {"bytes", entry.bytes}});
  return out;
}

/// "frame-*.color.jpg": files that are numbered count as one part.
std::string without_numbers(const std::string& name) {
  std::string pattern;
  for (const char c : name) {
    if (c < '0' || c > '9')
      pattern += c;
    else if (pattern.empty() || pattern.back() != '*')
      pattern += '*';
  }
  return pattern;
}

// Bytes by folder of the capture; files directly inside it under their own names, or a pattern of several names.
Json parts_of_folder(const fs::path& path, std::size_t& total) {
  struct Part {
    std::string name;
    std::size_t files = 0;
    std::size_t bytes = 0;
  };
  std::map<std::string, Part> parts; // by folder, or pattern
  std::error_code error;
  if (fs::is_regular_file(path)) total = fs::file_size(path, error);
  for (fs::recursive_directory_iterator it(path, fs::directory_options::skip_permission_denied, error), end;
       !error && it != end; it.increment(error)) {
    if (!it->is_regular_file(error)) continue;
    const fs::path inside = it->path().lexically_relative(path);
    const bool in_folder = inside.has_parent_path();
    Part& part = parts[in_folder ? inside.begin()->string() + "/" : without_numbers(inside.string())];
    const std::uintmax_t size = it->file_size(error);
    if (error) continue;
    ++part.files;
    if (part.files == 1) part.name = inside.string();
    part.bytes += size;
    total += size;
  }
  Json out = Json::array();
  for (const auto& [pattern, part] : parts) {
    const bool is_file = part.files == 1 && !pattern.ends_with('/');
    out.push_back({{"name", is_file ? part.name : pattern}, {"files", part.files}, {"bytes", part.bytes}});
  }
  return out;
}

/// Bytes by track of a recording, and what is around them.
Json parts_of_recording(const fs::path& path) {
  const recording::RecordingFile file(path);
  Json out = Json::array();
  std::uint64_t left = file.file_bytes();
  for (const auto& [name, bytes] : file.bytes_by_track()) {
    out.push_back({{"name", name}, {"bytes", bytes}});
    left -= std::min(left, bytes);
  }
  out.push_back({{"name", "container"}, {"bytes", left}});
  return out;
}

Json capture_json(const fs::path& path, const CaptureReading& reading, Context& context) {
  ingest::CaptureOptions how;
  how.format = reading.format;
  how.format_options = host::parse_options(reading.options);
  const auto capture = ingest::Capture::open(context.plugins(), path, how, context.progress);
  const ingest::CaptureInfo& info = capture->info();
  std::size_t total = 0;
  Json parts = parts_of_folder(path, total);
  const bool is_recording = info.format == "kinora-recording";
  if (is_recording) parts = parts_of_recording(path);
  Json labels = Json::object();
  for (const auto& [label, what] : info.labels) {
    labels[std::to_string(label)] = {{"name", what.name}, {"kind", what.kind}};
  }
  Json unused = Json::array(); // what the format can bring and nothing here looks at
  const bool has_infrared = std::ranges::any_of(
      parts, [](const Json& part) { return part["name"] == recording::track_name(recording::Stream::kInfrared); });
  if (is_recording ? has_infrared : host::supports(context.plugins().find(info.format), KINORA_READS_INFRARED))
    unused.push_back("infrared");
  return {{"schema", "kinora.info/1"},
          {"path", path.string()},
          {"kind", is_recording ? "recording" : "capture"},
          {"format", info.format},
          {"bytes", total},
          {"frames", info.frame_count},
          {"frames_per_second", info.frames_per_second},
          {"has_poses", info.has_poses},
          {"has_masks", info.has_masks},
          {"has_depth_camera", info.has_depth_camera},
          {"intrinsics", intrinsics_json(info.intrinsics)},
          {"labels", labels},
          {"unused", unused},
          {"parts", std::move(parts)}};
}

std::string parts_text(const Json& info) {
  Table table({"part", "bytes", "per frame", "share"});
  const auto total = info["bytes"].get<double>();
  const auto frames = info["frames"].get<std::size_t>();
  for (const Json& part : info["parts"]) {
    const auto bytes = part["bytes"].get<std::size_t>();
    std::string name = part["name"];
    if (part.value("files", std::size_t{1}) != 1) name += fmt::format(" ({} files)", part["files"].get<std::size_t>());
    table.add({name, format_bytes(bytes), format_bytes(per_frame(bytes, frames)),
               fmt::format("{:.1f} %", total > 0 ? 100.0 * static_cast<double>(bytes) / total : 0)});
  }
  return "Where every byte went:\n" + table.str();
}

std::string size_text(const Json& info) {
  const Json& camera = info["intrinsics"];
  return fmt::format("{}x{} pixels", camera["width"].get<int>(), camera["height"].get<int>());
}

/// Tags and chapters, for people.
std::string beside_text(const Json& info) {
  std::string text;
  for (const auto& [name, value] : info["tags"].items())
    text += fmt::format("{}: {}\n", name, value.get<std::string>());
  for (const Json& chapter : info["chapters"]) {
    text +=
        fmt::format("Chapter at {:.2f} s: {}\n", chapter["time_s"].get<double>(), chapter["title"].get<std::string>());
  }
  return text;
}

std::string clip_text(const Json& info) {
  std::string text = fmt::format(
      "{}: a Kinora clip (volumetric video){}, {}, {} per frame\n{} frames, {:.2f} s at "
      "{:.4g} frames/s; taken by a {} camera of {}\n",
      info["path"].get<std::string>(), info["live"].get<bool>() ? ", live: as of its last update" : "",
      format_bytes(info["bytes"].get<std::size_t>()), format_bytes(info["bytes_per_frame"].get<std::size_t>()),
      info["frames"].get<int>(), info["duration_s"].get<double>(), info["frames_per_second"].get<double>(),
      info["camera"].get<std::string>(), size_text(info));
  Table table({"layer", "motion", "nodes", "tracked", "held", "lost", "parameters"});
  for (const Json& layer : info["layers"]) {
    const Json& health = layer["frames"];
    table.add({layer["name"], layer["motion"], std::to_string(layer.value("nodes", 0)),
               std::to_string(health.value("tracked", 0)), std::to_string(health.value("held", 0)),
               std::to_string(health.value("lost", 0)), layer["parameters"].dump()});
  }
  return text + table.str() + away_text(info) + beside_text(info) + parts_text(info);
}

/// Whether the camera moved shows only in its pictures; what is known is whether the capture has its poses.
std::string capture_text(const Json& info) {
  const auto with = [&](const char* key) { return info[key].get<bool>() ? "with" : "without"; };
  std::string text =
      fmt::format("{}: a {} (format {}), {}\n{} frames at {:.4g} frames/s of {}; {} camera poses, {} masks\n",
                  info["path"].get<std::string>(), info["kind"].get<std::string>(), info["format"].get<std::string>(),
                  format_bytes(info["bytes"].get<std::size_t>()), info["frames"].get<int>(),
                  info["frames_per_second"].get<double>(), size_text(info), with("has_poses"), with("has_masks"));
  if (info["has_depth_camera"].get<bool>())
    text += "Depth comes from a camera of its own, and is registered to colour.\n";
  if (!info["unused"].empty()) {
    text += info["kind"] == "recording" ? "Infrared images are kept, and not used.\n"
                                        : "Infrared images, which this format can bring, are not used.\n";
  }
  return text + parts_text(info);
}

// A clip is told by its content, unless a format is asked for; anything else may be a capture.
Json info_of(const fs::path& path, const CaptureReading& reading, Context& context) {
  require_capture(path, context);
  if (fs::is_regular_file(path) && reading.format.empty()) {
    try {
      return clip_json(path, context);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNotRecognised) throw;
      context.progress.detail(error.what());
    }
  }
  return capture_json(path, reading, context);
}

// A capture of others has no checksums that could be looked at.
void refuse_damage(const fs::path& input, Context& context) {
  try {
    if (fs::is_regular_file(input)) throw_if_damaged(check_file(input, context.progress), input);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotRecognised) throw;
  }
}

void run(const Options& options, Context& context) {
  if (options.strict) refuse_damage(options.input, context);
  const Json info = info_of(options.input, options.reading, context);
  if (context.shared.json) {
    context.print_json(info);
  } else {
    context.print(info["kind"] == "clip" ? clip_text(info) : capture_text(info));
  }
}

} // namespace

void add_info(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "info", "What an input is, what it holds, and where every byte went",
                                          "  kinora info clip.mkv\n  kinora info capture/ --json",
                                          [options, &context] { run(*options, context); });
  command.add_option("INPUT", options->input, "A clip or a capture")->required()->type_name("PATH");
  add_reading_options(command, options->reading);
  command.add_flag("--strict", options->strict,
                   "Refuse a file of Kinora that is damaged anywhere, as kinora validate does");
}

} // namespace kinora::cli
