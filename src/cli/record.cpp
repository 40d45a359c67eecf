// kinora record: a capture becomes one file, without loss.
#include <chrono>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "cli/capture_input.h"
#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/live_device.h"
#include "cli/output_file.h"
#include "cli/sound_input.h"
#include "cli/text.h"
#include "core/error.h"
#include "record/recorder.h"
#include "recording/recording_file.h"

namespace kinora::cli {
namespace {

constexpr double kQueueSeconds = 0.5; // of frames that a camera keeps for us

struct Options {
  std::filesystem::path capture;
  std::filesystem::path output;
  CaptureReading reading;
  std::filesystem::path audio;
  double duration = std::numeric_limits<double>::infinity();
  LiveOptions live;
};

struct Outcome {
  std::size_t frames = 0;
  std::vector<std::string> problems; ///< of frames that could not be recorded
  std::size_t dropped = 0;           ///< frames that the camera lost
  double first_time = 0, last_time = 0;
  bool interrupted = false;
  bool disconnected = false; ///< the camera is gone
  bool opened = false;       ///< what stands under the output's name is ours
};

/// The file is written under its own name, so that it can be followed; there is nothing to rename.
void check_output(const Options& options, bool overwrite) {
  std::error_code ignored;
  if (same_file(options.capture, options.output))
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written: it is also the input; give another name", options.output.string()));
  if (std::filesystem::is_regular_file(options.output, ignored) && !overwrite)
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written: it exists already; add --overwrite to replace it, or give another "
                            "name",
                            options.output.string()));
}

void note_problem(Outcome& outcome, const std::string& sentence, Context& context) {
  context.progress.warn(sentence);
  outcome.problems.push_back(sentence);
}

/// The room that is left, as time at the rate so far.
std::string forecast(const std::filesystem::path& output, const Outcome& outcome) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(output, error);
  const auto space = error ? std::filesystem::space_info{} : std::filesystem::space(output, error);
  const double seconds = outcome.last_time - outcome.first_time;
  if (error || bytes == 0 || seconds <= 0) return {};
  const double left = static_cast<double>(space.available) / (static_cast<double>(bytes) / seconds);
  return fmt::format("room for {:.0f} more minutes", left / 60);
}

record::Arrival arrival_of(const host::ReadFrame& read, bool live) {
  using std::chrono::system_clock;
  record::Arrival arrival{read.dropped_before, std::nullopt};
  if (live) {
    arrival.host_time_ns =
        std::chrono::duration_cast<std::chrono::nanoseconds>(system_clock::now().time_since_epoch()).count();
  }
  return arrival;
}

std::string progress_detail(const std::filesystem::path& output, const Outcome& outcome) {
  std::string detail = forecast(output, outcome);
  if (outcome.dropped > 0) detail += fmt::format("{}{} dropped", detail.empty() ? "" : ", ", outcome.dropped);
  return detail;
}

/// All that is to be heard up to a frame.
void record_sound(sound::SoundFeed& feed, std::int64_t time_ns, record::Recorder& recorder) {
  container::Payload packet;
  while (feed.next_until(time_ns, packet)) recorder.write_sound(packet);
}

void record_frames(host::FrameReader& reader, sound::SoundSource* sound, const Options& options,
                   std::optional<record::Recorder>& recorder, Outcome& outcome, Context& context) {
  const recording::Description description = recording::description_of(reader.info(), reader.format().name);
  std::optional<sound::SoundFeed> feed;
  if (sound != nullptr) feed.emplace(*sound);
  while (auto read = reader.next()) {
    outcome.interrupted = context.progress.cancelled();
    if (outcome.interrupted) return;
    const KinoraFrame& frame = read->frame;
    const record::Arrival arrival = arrival_of(*read, options.live.live);
    outcome.dropped += arrival.dropped_before;
    if (!read->problem.empty()) {
      note_problem(outcome, read->problem, context);
      if (recorder) recorder->write_problem(frame.index, outcome.last_time, read->problem, arrival);
      continue;
    }
    if (!recorder) {
      outcome.first_time = frame.time;
      outcome.opened = std::ofstream(options.output, std::ios::app).is_open();
      recorder.emplace(options.output, description, frame, sound != nullptr ? &sound->track() : nullptr);
    }
    if (frame.time - outcome.first_time >= options.duration) return;
    outcome.last_time = frame.time;
    if (feed) record_sound(*feed, nanoseconds_of(frame.time, reader.info()), *recorder);
    if (recorder->write(frame, arrival)) {
      ++outcome.frames;
    } else {
      note_problem(outcome, fmt::format("frame {} does not fit the first one and is not recorded", frame.index),
                   context);
    }
    context.progress.advance(static_cast<std::size_t>(frame.index) + 1, progress_detail(options.output, outcome));
  }
  outcome.interrupted = context.progress.cancelled();
}

bool holds_a_frame(const std::filesystem::path& path) {
  try {
    return recording::RecordingFile(path).frame_count() > 0;
  } catch (const Error&) {
    return false;
  }
}

/// A full disk: completes the file as far as it goes, and says so. Removes it if no frame is in it.
[[noreturn]] void complete_and_tell(const std::filesystem::path& path, std::optional<record::Recorder>& recorder,
                                    const Error& error) {
  if (recorder) recorder->finish_at_last_cluster();
  recorder.reset();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw error; // a device
  if (holds_a_frame(path))
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{}; the recording is complete up to there and can be read", error.what()));
  std::filesystem::remove(path, ignored);
  throw Error(ErrorCode::kUnwritableOutput,
              fmt::format("{}; the recording holds no frame yet and is removed", error.what()));
}

Outcome record_capture(const Options& options, Context& context) {
  host::FrameReader reader = open_frames(options.capture, options.reading, context);
  const std::shared_ptr<host::SimulatedDevice> device = make_device(options.live, kQueueSeconds);
  reader.replay(device);
  for (std::size_t i = 0; i < reader.info().warning_count; ++i) context.progress.warn(reader.info().warnings[i]);
  const std::unique_ptr<sound::SoundSource> sound = open_sound_of(reader, options.audio);
  context.progress.stage("recording", static_cast<std::size_t>(reader.info().frame_count));
  std::optional<record::Recorder> recorder;
  Outcome outcome;
  try {
    record_frames(reader, sound.get(), options, recorder, outcome, context);
    if (!recorder)
      throw Error(outcome.interrupted ? ErrorCode::kInterrupted : ErrorCode::kCorruptInput,
                  fmt::format("{}: no frame was recorded, and no file was made", options.capture.string()));
    recorder->finish();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kUnwritableOutput && outcome.opened)
      complete_and_tell(options.output, recorder, error);
    if (!recorder) throw;
    recorder->finish(); // the capture cannot be read any further
    throw Error(error.code(), fmt::format("{}; {} is complete up to there", error.what(), options.output.string()));
  }
  outcome.disconnected = device && device->was_disconnected();
  return outcome;
}

void run(const Options& options, Context& context) {
  require_capture(options.capture, context);
  check_output(options, context.shared.overwrite);
  const Outcome outcome = record_capture(options, context);
  std::error_code ignored;
  const std::uintmax_t bytes = std::filesystem::file_size(options.output, ignored);
  const double seconds = outcome.last_time - outcome.first_time;
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.record/1"},
                        {"output", options.output.string()},
                        {"frames", outcome.frames},
                        {"dropped", outcome.dropped},
                        {"problems", outcome.problems},
                        {"duration_s", seconds},
                        {"bytes", bytes},
                        {"interrupted", outcome.interrupted}});
  } else {
    context.print(fmt::format("{}: {} frames, {:.2f} s, {}; {} dropped, {} could not be recorded\n",
                              options.output.string(), outcome.frames, seconds, format_bytes(bytes), outcome.dropped,
                              outcome.problems.size()));
  }
  if (!outcome.interrupted && !outcome.disconnected) return;
  context.flush();
  if (outcome.disconnected) {
    throw Error(ErrorCode::kFailure, fmt::format("{}: the camera was disconnected; {} is complete up to there",
                                                 options.capture.string(), options.output.string()));
  }
  throw Error(ErrorCode::kInterrupted, fmt::format("stopped; {} is complete up to there", options.output.string()));
}

} // namespace

void add_record(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "record", "Record a capture in one file, without loss",
                                          "  kinora record capture/ recording.mkv\n"
                                          "  kinora record capture/ start.mkv --duration 5\n"
                                          "  kinora record capture/ as_from_a_camera.mkv --live",
                                          [options, &context] { run(*options, context); });
  command.add_option("CAPTURE", options->capture, "The capture to record")->required()->type_name("PATH");
  command.add_option("OUTPUT", options->output, "The recording to write, a Matroska file")
      ->required()
      ->type_name("FILE");
  command.add_option("--duration", options->duration, "Stop after this many seconds of the capture")
      ->check(CLI::PositiveNumber)
      ->type_name("S");
  add_reading_options(command, options->reading);
  add_audio_option(command, options->audio);
  add_live_options(command, options->live, "Replay the capture at its own pace, and lose what cannot be kept up with");
  context.add_overwrite(command);
}

} // namespace kinora::cli
