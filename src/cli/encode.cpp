// kinora encode: a capture becomes a clip.
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "cli/archive.h"
#include "cli/asked_view.h"
#include "cli/clip_input.h"
#include "cli/clip_window.h"
#include "cli/commands.h"
#include "cli/companions.h"
#include "cli/growing_clip.h"
#include "cli/interrupt.h"
#include "cli/live_device.h"
#include "cli/output_file.h"
#include "cli/quality_text.h"
#include "cli/rate_choice.h"
#include "cli/sound_input.h"
#include "cli/text.h"
#include "core/error.h"
#include "encode/live/live_encoder.h"
#include "evaluate/evaluate.h"
#include "ingest/files/body_mesh.h"
#include "sound/sound_codec.h"
#include "tracking/body/shape_from_mesh.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

/// Trained frames that the report compares: enough for a mean, few enough to be quick. Held-out ones all are.
constexpr int kComparedFrames = 10;

/// Of frames that a camera keeps for us in live mode: older ones are not worth following.
constexpr double kQueueSeconds = 0.05;

struct Options {
  std::filesystem::path capture;
  std::filesystem::path clip;
  std::string preset = "balanced";
  std::string frames;
  CaptureReading reading;
  std::filesystem::path audio;
  bool no_masks = false;
  std::filesystem::path segmenter;
  std::filesystem::path detector;
  std::filesystem::path body;
  int holdout = 0;
  int holdout_tracked = 0;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> changes; ///< of settings: "path=value"
  std::filesystem::path report;
  double kb_per_frame = 0; ///< 0: what the usual rounding takes
  CompanionOptions companions;
  bool archive = false;
  LiveOptions live;
  std::filesystem::path preview;
  double preview_every = 2;
  bool view = false;
};

class Stopwatch {
public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double rounded(double value) { return std::round(value * 1000) / 1000; }

ingest::CaptureOptions capture_options(const Options& options) {
  ingest::CaptureOptions out;
  out.format = options.reading.format;
  out.format_options = host::parse_options(options.reading.options);
  if (!options.frames.empty()) out.frames = FrameRange::parse(options.frames);
  out.use_masks = !options.no_masks;
  return out;
}

encode::PreparedCapture prepare(const Options& options, const encode::Settings& settings, Context& context) {
  encode::CaptureRequest request;
  request.open = [&](const ingest::CaptureOptions& how, Progress& progress) {
    return ingest::Capture::open(context.plugins(), options.capture, how, progress);
  };
  request.options = capture_options(options);
  request.options.max_depth = settings.ingest.max_depth;
  request.options.cleaning = settings.ingest.cleaning;
  request.options.masks_on_edges = settings.ingest.masks_on_edges;
  request.camera = settings.tracking.camera;
  request.network = options.segmenter;
  request.detector = options.detector;
  request.holdout = options.holdout;
  return encode::prepare_capture(request, context.progress);
}

encode::EncodeOptions encode_options(const Options& options) {
  auto out = encode::EncodeOptions::of(encode::parse_preset(options.preset));
  if (options.holdout == 1) {
    throw Error(ErrorCode::kUsage, "--holdout 1 would leave no frame to train on; use 2 or more, such as 10");
  }
  if (options.holdout_tracked == 1) {
    throw Error(ErrorCode::kUsage, "--holdout-tracked 1 would leave no frame to train on; use 2 or more, such as 10");
  }
  out.holdout = options.holdout;
  out.holdout_tracked = options.holdout_tracked;
  if (options.seed) out.settings.fields.trainer.seed = *options.seed;
  // Which steps a size leaves is known at the end alone; and it may leave finer ones than usual.
  if (options.kb_per_frame > 0) out.settings.fields.trainer.quantisation = {};
  for (const std::string& change : options.changes) encode::list_settings(out.settings).change(change);
  encode::check(out.settings);
  out.frames = capture_options(options).frames;
  return out;
}

Json file_json(const std::filesystem::path& path, const clip::ByteAccount& account) {
  Json parts = Json::array();
  for (const auto& entry : account.entries) parts.push_back({{"name", entry.name}, {"bytes", entry.bytes}});
  return {{"path", path.string()}, {"bytes", account.total}, {"parts", std::move(parts)}};
}

std::size_t bytes_of_layer(const std::string& name, const clip::ByteAccount& account) {
  std::size_t bytes = 0;
  for (const auto& entry : account.entries) {
    if (entry.name == "field " + name || entry.name == "motion " + name) bytes += entry.bytes;
  }
  return bytes;
}

void add_quality(Json& report, Json evaluation) {
  for (Json& layer : report["layers"]) {
    for (const Json& evaluated : evaluation["layers"]) {
      if (evaluated["name"] != layer["name"]) continue;
      layer["quality"] = evaluated;
      layer["quality"].erase("name");
    }
  }
  report["evaluation"] = std::move(evaluation);
}

std::string settings_help() {
  encode::Settings settings = encode::EncodeOptions::of(encode::Preset::kBalanced).settings;
  return "What --set PATH=VALUE changes, with the values of the balanced preset:\n" +
         encode::list_settings(settings).text();
}

/// What is heard while the clip's frames are seen, small enough for a clip; nothing if there is no sound.
std::optional<container::Sound> sound_of(const Options& options, const clip::Clip& clip, Context& context) {
  if (context.plugins().is_device(options.capture)) return std::nullopt;
  host::FrameReader reader = open_frames(options.capture, options.reading, context);
  const std::unique_ptr<sound::SoundSource> sound = open_sound_of(reader, options.audio);
  if (!sound) return std::nullopt;
  reader.seek(clip.capture_frames.front());
  const std::optional<host::ReadFrame> first = reader.next();
  if (!first || !first->problem.empty()) return std::nullopt;
  const std::int64_t begin = nanoseconds_of(first->frame.time, reader.info());
  const double length = clip.times.back() - clip.times.front() + 1 / reader.info().frames_per_second;
  const std::int64_t end = std::llround(length * 1e9);
  container::Sound small = sound::compact(sound::excerpt(*sound, begin, begin + end));
  std::erase_if(small.packets, [end](const container::Payload& packet) { return packet.time_ns > end; });
  return small;
}

/// `published` is called whenever the clip has grown, on another thread. `window`: of who looks at it in a window.
encode::EncodeResult encode_live(const Options& options, const encode::EncodeOptions& how, OutputFile& out,
                                 const std::function<void()>& published, const AskedView& window, Context& context) {
  ingest::CaptureOptions capture_how = capture_options(options);
  capture_how.max_depth = how.settings.ingest.max_depth;
  capture_how.cleaning = how.settings.ingest.cleaning;
  capture_how.masks_on_edges = how.settings.ingest.masks_on_edges;
  capture_how.device = make_device(options.live, kQueueSeconds);
  const auto capture = ingest::Capture::open(context.plugins(), options.capture, capture_how, context.progress);
  GrowingClipFile file(out);
  std::optional<LivePreview> preview;
  if (!options.preview.empty())
    preview.emplace(options.preview, options.preview_every, context.shared.overwrite, context.plugins());
  encode::LiveRequest request;
  if (preview) request.interval = std::min(request.interval, options.preview_every);
  request.publish = [&](const clip::Clip& clip) {
    file.write(clip);
    published();
    if (preview) preview->show(clip);
  };
  request.asked_view = [&] {
    const std::optional<SE3> asked = window.get();
    return asked || !preview ? asked : preview->seen_from();
  };
  encode::EncodeResult result = encode::encode_live(*capture, request, how, context.progress);
  result.clip.sound = sound_of(options, result.clip, context);
  file.finish(result.clip);
  result.report["live"]["disconnected"] = capture_how.device->was_disconnected();
  return result;
}

/// On a thread of its own, while this one shows the growing clip in a window. The window may be closed before; it stays
/// when the clip has ended.
encode::EncodeResult encode_live_in_view(const Options& options, const encode::EncodeOptions& how, OutputFile& out,
                                         Context& context) {
  std::atomic<bool> begun = false;
  AskedView asked;
  auto encoding = std::async(std::launch::async, [&] {
    return encode_live(
        options, how, out, [&begun] { begun = true; }, asked, context);
  });
  while (!begun && encoding.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
  }
  std::string message;
  try {
    if (begun && !interrupted())
      show_in_window(options.clip.string(), context, [&](const SE3& pose) { asked.set(pose); });
  } catch (const Error& error) {
    message = error.what();
  }
  asked.set(std::nullopt);
  encode::EncodeResult result = encoding.get();
  if (!message.empty()) context.progress.warn(message);
  return result;
}

encode::EncodeResult encode_live(const Options& options, const encode::EncodeOptions& how, OutputFile& out,
                                 Context& context) {
  if (options.view) return encode_live_in_view(options, how, out, context);
  return encode_live(
      options, how, out, [] {}, {}, context);
}

/// Of as many bytes as the options say.
void write_clip(const Options& options, const std::filesystem::path& path, encode::EncodeResult& result,
                Context& context) {
  clip::write_clip(result.clip, path);
  if (options.kb_per_frame == 0) return;
  std::error_code is_device;
  const std::uintmax_t usual = std::filesystem::file_size(path, is_device);
  if (is_device) return;
  const encode::RateChoice choice =
      choose_rate(result.clip, static_cast<std::size_t>(usual), options.kb_per_frame, context, result.report["rate"]);
  clip::write_clip(result.clip, path, {choice.fields});
}

/// Of the whole capture; the clip is written, and its name committed.
encode::EncodeResult encode_file(const Options& options, const encode::EncodeOptions& how, const Companions& companions,
                                 OutputFile& out, Context& context) {
  encode::EncodeResult result = encode::encode_capture(prepare(options, how.settings, context), how, context.progress);
  context.progress.stage("writing", 0);
  result.clip.sound = sound_of(options, result.clip, context);
  if (options.archive) {
    const Unfinished clip(options.clip, Unfinished::Kind::kFile);
    write_clip(options, clip.path(), result, context);
    add_companions(clip.path(), companions, context);
    write_archive(clip.path(), options.capture, options.reading, options.audio, out.writing_path(), context);
  } else {
    write_clip(options, out.writing_path(), result, context);
    if (out.can_be_read_back()) add_companions(out.writing_path(), companions, context);
  }
  out.commit();
  return result;
}

/// The clip is written; what else there is to say ends the command.
void tell_of_early_end(const Json& live, const Options& options, Context& context) {
  context.flush();
  if (live["disconnected"].get<bool>()) {
    throw Error(ErrorCode::kFailure, fmt::format("{}: the camera was disconnected; {} is complete up to there",
                                                 options.capture.string(), options.clip.string()));
  }
  if (live["stopped"].get<bool>())
    throw Error(ErrorCode::kInterrupted, fmt::format("stopped; {} is complete up to there", options.clip.string()));
}

std::string live_text(const Json& live) {
  const Json& latency = live["capture_to_motion_ms"];
  return fmt::format(
      "live: {} frames followed, {} lost, {:.1f} frames/s; capture to motion {:.0f} ms (median), {:.0f} ms "
      "(95 %)\n",
      live["frames_followed"].get<std::size_t>(), live["frames_lost"].get<std::size_t>(),
      live["frames_per_second"].get<double>(), latency["median"].get<double>(), latency["p95"].get<double>());
}

/// What half as much training again would have brought, where its length was chosen.
std::string next_step(const Json& training) {
  const auto length = training.find("length");
  if (length == training.end() || !length->contains("next")) return "";
  const Json& next = length->at("next");
  return fmt::format("{:+.2f} dB for {:.1f} s", next["gain_db"].get<double>(), next["processor_s"].get<double>());
}

std::string summary(const Json& report) {
  const Json& capture = report["capture"];
  const Json& file = report["file"];
  const auto frames = capture["frames_used"].get<std::size_t>();
  std::string text =
      fmt::format("{}: {}, {} frames ({} held out, {} skipped), {:.2f} s per frame\n", file["path"].get<std::string>(),
                  format_bytes(file["bytes"].get<std::size_t>()), frames, capture["frames_held_out"].get<int>(),
                  capture["skipped"].size(), report["timing"]["total_s"].get<double>() / static_cast<double>(frames));
  if (report.contains("live")) text += live_text(report["live"]);
  Table table({"layer", "motion", "bytes", "rays", "more would gain", "why"});
  for (const Json& layer : report["layers"]) {
    table.add({layer["name"], layer["motion"]["kind"], format_bytes(layer["bytes"].get<std::size_t>()),
               fmt::format("{:.1f} M", 1e-6 * layer["training"]["rays"].get<double>()), next_step(layer["training"]),
               layer["why"]});
  }
  for (const Json& left_out : report["not_modelled"]) {
    table.add({left_out["name"], "none", "", "", "", left_out["why"]});
  }
  text += table.str();
  if (report.contains("evaluation")) text += quality_table(report["evaluation"]);
  return text;
}

void run(const Options& options, Context& context) {
  encode::EncodeOptions how = encode_options(options);
  require_capture(options.capture, context);
  if (!options.segmenter.empty()) require_input(options.segmenter);
  if (!options.detector.empty()) require_input(options.detector);
  if (!options.audio.empty()) {
    require_input(options.audio);
    sound::open_sound(options.audio); // before hours of work
  }
  if (!options.body.empty()) {
    require_input(options.body);
    how.body = tracking::measure_body(ingest::read_body_mesh(options.body));
    how.body_from = options.body.filename().string();
  }
  if (options.view) require_window(); // before the capture begins
  const Companions companions = companions_of(options.companions);
  const std::vector inputs{options.capture, options.segmenter, options.detector,
                           options.body,    options.audio,     options.companions.chapters};
  OutputFile out(options.clip, context.shared.overwrite, inputs);
  std::optional<OutputFile> report_file;
  if (!options.report.empty()) report_file.emplace(options.report, context.shared.overwrite, inputs);

  const Stopwatch watch;
  encode::EncodeResult result =
      options.live.live ? encode_live(options, how, out, context) : encode_file(options, how, companions, out, context);
  result.report["timing"]["total_s"] = rounded(watch.seconds());
  result.report["timing"]["ms_per_frame"] =
      rounded(1000 * watch.seconds() / static_cast<double>(result.clip.times.size()));

  clip::ByteAccount account;
  result.clip = clip::Clip{};
  if (out.can_be_read_back()) {
    clip::Clip clip = clip::read_clip(options.clip, &account);
    const bool was_stopped = options.live.live && context.progress.cancelled();
    if ((report_file || context.shared.json) && !was_stopped) {
      const Stopwatch evaluation_watch;
      const player::Player player(std::move(clip));
      add_quality(result.report, evaluate::evaluate_against(options.capture, context.plugins(), player,
                                                            {kComparedFrames, false, options.reading.format,
                                                             host::parse_options(options.reading.options)},
                                                            context.progress));
      result.report["timing"]["evaluation_s"] = rounded(evaluation_watch.seconds());
    }
  }
  result.report["file"] = file_json(options.clip, account);
  for (Json& layer : result.report["layers"]) layer["bytes"] = bytes_of_layer(layer["name"], account);
  if (report_file) write_text(*report_file, result.report.dump(1) + "\n");
  if (context.shared.json) {
    context.print_json(result.report);
  } else {
    context.print(summary(result.report));
  }
  if (options.live.live) tell_of_early_end(result.report["live"], options, context);
}

} // namespace

void add_encode(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "encode", "Make a clip of a capture",
                                          "  kinora encode capture/ clip.mkv\n"
                                          "  kinora encode capture/ clip.mkv --holdout 10 --report report.json\n"
                                          "  kinora encode capture/ draft.mkv --preset fast --frames 0:30\n"
                                          "  kinora encode capture/ clip.mkv --set tracking.solver.iterations=3",
                                          [options, &context] { run(*options, context); });
  command.add_option("CAPTURE", options->capture, "The capture to read: a folder of RGB-D frames")
      ->required()
      ->type_name("PATH");
  command.add_option("CLIP", options->clip, "The clip to write, a Matroska file")->required()->type_name("FILE");
  command.add_option("--preset", options->preset, "How long to train: fast or balanced")
      ->check(CLI::IsMember({"fast", "balanced"}))
      ->type_name("NAME")
      ->capture_default_str();
  command.add_option("--frames", options->frames, "Only these frames; counts from 0, B is excluded")
      ->type_name("A:B:S");
  add_reading_options(command, options->reading);
  add_audio_option(command, options->audio);
  command.add_flag("--no-masks", options->no_masks, "Do not read masks: tell people and things by what moves");
  command
      .add_option("--segmenter", options->segmenter,
                  "Label the frames with this network (background, person, object, ...) instead of masks")
      ->type_name("ONNX");
  command
      .add_option("--detector", options->detector,
                  "Find people's joints with this network too: a crop of one person (RGB, ImageNet's mean and "
                  "deviation) in, heat maps of COCO's 17 joints out, such as HRNet, SimpleBaseline or ViTPose")
      ->type_name("ONNX");
  command
      .add_option("--body", options->body,
                  "Take the person's measures from this mesh, an .npz file with SMPL's arrays, at first")
      ->type_name("NPZ");
  auto* holdout = command
                      .add_option("--holdout", options->holdout,
                                  "Let nothing see frames N-1, 2N-1, ... and judge by them: where things are in "
                                  "them lies on a path through the frames beside")
                      ->check(CLI::Range(0, 1'000'000))
                      ->type_name("N");
  command
      .add_option("--holdout-tracked", options->holdout_tracked,
                  "Track and fuse frames N-1, 2N-1, ... but never train on them, to judge by them")
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("N")
      ->excludes(holdout);
  command.add_option("--seed", options->seed, "Begin the training's random numbers here")->type_name("N");
  command
      .add_option("--set", options->changes,
                  "Change a setting, such as tracking.solver.iterations=3; may be repeated, and has the last word")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  command.add_flag_callback(
      "--help-settings", [] { throw CLI::CallForVersion(settings_help(), 0); },
      "All settings with their values, and what they may hold");
  command
      .add_option("--report", options->report, "Compare the clip with the capture and write all numbers here, as JSON")
      ->type_name("FILE");
  add_kb_per_frame_option(command, options->kb_per_frame);
  add_companion_options(command, options->companions);
  command.add_flag("--archive", options->archive,
                   "Keep the whole capture without loss behind the clip, in the same file, as kinora record does");
  add_live_options(command, options->live,
                   "Encode the capture while it is replayed at its own pace, as from a camera: frames that cannot be "
                   "kept up with are lost, and the clip can be read at any moment. It needs masks");
  command
      .add_option("--preview", options->preview, "Draw the growing clip from the side now and then: LOOK_0001.png, ...")
      ->needs("--live")
      ->type_name("LOOK.png");
  command.add_option("--every", options->preview_every, "Seconds between two such pictures, at least")
      ->needs("--preview")
      ->check(CLI::PositiveNumber)
      ->type_name("S")
      ->capture_default_str();
  command.add_flag("--view", options->view, "Show the growing clip in a window, as kinora play does")->needs("--live");
  for (const char* other : {"--holdout", "--holdout-tracked", "--segmenter", "--detector", "--preset", "--archive",
                            "--kb-per-frame", "--flat-preview", "--chapters", "--tag"})
    command.get_option("--live")->excludes(command.get_option(other));
  context.add_overwrite(command);
}

} // namespace kinora::cli
