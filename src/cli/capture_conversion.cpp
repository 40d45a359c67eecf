#include "cli/capture_conversion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <system_error>

#include <fmt/format.h>

#include "cli/capture_input.h"
#include "cli/output_file.h"
#include "cli/text.h"
#include "core/error.h"
#include "host/frame_reader.h"
#include "host/frame_writer.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void unwritable(const fs::path& path, const std::string& why) {
  throw Error(ErrorCode::kUnwritableOutput, fmt::format("{} cannot be written: {}", path.string(), why));
}

/// A file, or a folder, that appears under its name when it is whole.
class CaptureOutput {
public:
  CaptureOutput(const CaptureConversion& conversion, bool overwrite) : path_(conversion.output) {
    if (*conversion.target->extensions != '\0') {
      file_.emplace(path_, overwrite, std::vector<fs::path>{conversion.input});
      return;
    }
    std::error_code ignored;
    if (fs::exists(path_, ignored) && !fs::is_empty(path_, ignored))
      unwritable(path_, "it exists already, and a folder is never replaced; remove it, or give another name");
    folder_.emplace(path_, Unfinished::Kind::kFolder);
  }

  const fs::path& writing_path() const { return file_ ? file_->writing_path() : folder_->path(); }

  std::uintmax_t bytes() const {
    std::error_code ignored;
    if (file_) return file_->can_be_read_back() ? fs::file_size(writing_path(), ignored) : 0;
    std::uintmax_t sum = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_->path()))
      if (entry.is_regular_file()) sum += entry.file_size();
    return sum;
  }

  void commit() {
    if (file_) return file_->commit();
    std::error_code error;
    fs::rename(folder_->path(), path_, error); // in the place of an empty folder too
    if (error) unwritable(path_, error.message());
    folder_->keep();
  }

private:
  fs::path path_;
  std::optional<OutputFile> file_;
  std::optional<Unfinished> folder_;
};

/// Says once of each thing that the target has no place for it.
class Losses {
public:
  Losses(const CaptureConversion& conversion, Context& context) : conversion_(conversion), context_(context) {}

  void check(const KinoraCaptureInfo& info) {
    if (info.has_depth_camera != 0 && !keeps(KINORA_WRITES_DEPTH_CAMERA))
      throw Error(ErrorCode::kFailure,
                  fmt::format("{}: depth comes from a camera of its own, for which {} has no place; convert it to a "
                              "recording (NAME.mkv)",
                              conversion_.input.string(), conversion_.target->name));
    if (info.has_poses != 0 && !keeps(KINORA_WRITES_POSES)) tell("camera poses");
    if (info.has_masks != 0 && !keeps(KINORA_WRITES_MASKS)) tell("masks");
  }
  void check_sound(host::FrameReader& reader) {
    if (!keeps(KINORA_WRITES_SOUND) && reader.sound()) tell("sound");
  }

  void check(const KinoraFrame& frame, double nominal_time) {
    constexpr double kSameTime = 5e-4;
    if (frame.infrared.data != nullptr && !keeps(KINORA_WRITES_INFRARED)) tell("infrared images");
    if (frame.confidence.data != nullptr && !keeps(KINORA_WRITES_CONFIDENCE)) tell("confidence of depth");
    if (std::abs(frame.time - nominal_time) > kSameTime && !keeps(KINORA_WRITES_TIMES)) tell("times of its own");
  }

private:
  bool keeps(std::uint64_t capability) const { return host::supports(*conversion_.target, capability); }
  void tell(const char* what) {
    if (!told_.insert(what).second) return;
    const std::string sentence = fmt::format("{}: has {}, for which {} has no place", conversion_.input.string(), what,
                                             conversion_.target->name);
    if (conversion_.strict) throw Error(ErrorCode::kFailure, sentence + "; without --strict this is a warning");
    context_.progress.warn(sentence);
  }

  const CaptureConversion& conversion_;
  Context& context_;
  std::set<std::string> told_;
};

/// Sound in step with the frames that are converted.
class SoundCopy {
public:
  SoundCopy(host::FrameReader& reader, host::FrameWriter& writer) : reader_(reader), writer_(writer) {
    if (!host::supports(writer.format(), KINORA_WRITES_SOUND)) return;
    const std::optional<KinoraSound> sound = reader.sound();
    if (!sound) return;
    writer.set_sound(*sound);
    waiting_ = reader.next_sound();
  }

  /// All from the first of these times on, up to this one.
  void go_on_to(double time) {
    if (!begin_) begin_ = time;
    for (; waiting_ && waiting_->time <= time; waiting_ = reader_.next_sound())
      if (waiting_->time >= *begin_) writer_.write_sound(*waiting_);
  }

private:
  host::FrameReader& reader_;
  host::FrameWriter& writer_;
  std::optional<KinoraSoundPacket> waiting_;
  std::optional<double> begin_;
};

std::vector<std::string> option_names(const KinoraFormat& format) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < format.option_count; ++i) names.emplace_back(format.options[i].name);
  return names;
}

/// Those of the reader are taken out of `options`: an option that both have is the reader's.
host::Options take_options_of(const KinoraFormat& reader, host::Options& options) {
  host::Options taken;
  for (const std::string& name : option_names(reader)) taken.insert(options.extract(name));
  return taken;
}

struct Outcome {
  std::size_t frames = 0;
  std::uintmax_t bytes = 0;
  std::vector<std::string> problems;
};

void convert_frames(host::FrameReader& reader, host::FrameWriter& writer, const CaptureConversion& conversion,
                    Losses& losses, Outcome& outcome, Context& context) {
  const FrameRange& range = conversion.frames;
  const KinoraCaptureInfo& info = reader.info();
  const auto note = [&](const std::string& problem) {
    if (conversion.strict) throw Error(ErrorCode::kCorruptInput, problem + "; without --strict this is a warning");
    context.progress.warn(problem);
    outcome.problems.push_back(problem);
  };
  std::optional<double> first_time;
  SoundCopy sound(reader, writer);
  const std::int64_t end =
      std::min<std::int64_t>(range.end.value_or(std::numeric_limits<int>::max()), info.frame_count);
  for (std::int64_t index = range.begin; index < end; index += range.step) {
    context.progress.check();
    reader.seek(index);
    const auto read = reader.next();
    if (!read) return;
    if (!read->problem.empty()) {
      note(read->problem);
      continue;
    }
    if (!first_time) first_time = read->frame.time;
    losses.check(read->frame, *first_time + static_cast<double>(outcome.frames) / info.frames_per_second);
    sound.go_on_to(read->frame.time);
    if (const std::string why = writer.write(read->frame); why.empty())
      ++outcome.frames;
    else
      note(why);
    context.progress.advance(static_cast<std::size_t>(index) + 1, "");
  }
}

Outcome convert(host::FrameReader& reader, const host::Options& options, const CaptureConversion& conversion,
                Losses& losses, Context& context) {
  CaptureOutput output(conversion, context.shared.overwrite);
  context.progress.stage("converting", static_cast<std::size_t>(reader.info().frame_count));
  Outcome outcome;
  host::FrameWriter writer(*conversion.target, output.writing_path(), options, reader.info());
  convert_frames(reader, writer, conversion, losses, outcome, context);
  if (outcome.frames == 0)
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: no frame could be converted, and nothing was written", conversion.input.string()));
  writer.finish();
  outcome.bytes = output.bytes();
  output.commit();
  return outcome;
}

} // namespace

void convert_capture(const CaptureConversion& conversion, Context& context) {
  require_capture(conversion.input, context);
  const KinoraFormat& source = conversion.source_format.empty() ? context.plugins().recognise(conversion.input)
                                                                : context.plugins().find(conversion.source_format);
  host::Options options = conversion.options;
  const host::Options reading = take_options_of(source, options);
  host::check_options(*conversion.target, options, option_names(source));
  host::FrameReader reader(source, conversion.input, reading);
  const auto count =
      static_cast<int>(std::min<std::int64_t>(reader.info().frame_count, std::numeric_limits<int>::max()));
  const int wanted = conversion.frames.count_of(count);
  if (wanted == 0)
    throw Error(ErrorCode::kUsage, fmt::format("{}: has {} frames, none of which lies in the range that starts at {}",
                                               conversion.input.string(), count, conversion.frames.begin));
  for (std::size_t i = 0; i < reader.info().warning_count; ++i) context.progress.warn(reader.info().warnings[i]);
  Losses losses(conversion, context);
  losses.check(reader.info());
  losses.check_sound(reader);
  Outcome outcome;
  if (conversion.dry_run)
    outcome.frames = static_cast<std::size_t>(wanted);
  else
    outcome = convert(reader, options, conversion, losses, context);
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.convert/1"},
                        {"output", conversion.output.string()},
                        {"source_format", source.name},
                        {"format", conversion.target->name},
                        {"frames", outcome.frames},
                        {"problems", outcome.problems},
                        {"bytes", outcome.bytes},
                        {"dry_run", conversion.dry_run}});
    return;
  }
  const std::string frames =
      fmt::format("{} frame{} as {}", outcome.frames, outcome.frames == 1 ? "" : "s", conversion.target->name);
  context.print(conversion.dry_run ? fmt::format("{}: would hold {}\n", conversion.output.string(), frames)
                                   : fmt::format("{}: {}, {}; {} could not be converted\n", conversion.output.string(),
                                                 frames, format_bytes(outcome.bytes), outcome.problems.size()));
}

} // namespace kinora::cli
