#include "encode/live/live_encoder.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "encode/capture_report.h"
#include "encode/layer_report.h"
#include "encode/live/live_exchange.h"
#include "encode/rounding.h"
#include "ingest/segmentation/segmenter.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// The trainer's: says nothing, and is cancelled when the user or the front end wants it to end.
class StopSign final : public Progress {
public:
  StopSign(const LiveExchange& exchange, const Progress& user) : exchange_(exchange), user_(user) {}
  bool cancelled() const override { return exchange_.is_stopped() || user_.cancelled(); }

private:
  const LiveExchange& exchange_;
  const Progress& user_;
};

/// What is published, and when.
class Publisher {
public:
  Publisher(const LiveRequest& request, Clock::time_point start) : request_(request), start_(start) {}

  bool is_due() const { return !last_ || seconds_since(*last_) > std::max(request_.interval, 9 * cost_); }
  void publish(const clip::Clip& clip) {
    if (clip.layers.empty()) return;
    const Clock::time_point begin = Clock::now();
    request_.publish(clip);
    cost_ = seconds_since(begin);
    last_ = Clock::now();
    if (count_++ == 0) first_ = seconds_since(start_);
  }
  std::size_t count() const { return count_; }
  double first() const { return first_; } ///< seconds from the start

private:
  const LiveRequest& request_;
  Clock::time_point start_;
  std::optional<Clock::time_point> last_;
  double cost_ = 0;
  double first_ = 0;
  std::size_t count_ = 0;
};

/// The trainer's thread, from the first snapshot to the last.
class TrainerThread {
public:
  TrainerThread(const LiveRequest& request, const EncodeOptions& options, Json metadata, LiveExchange& exchange,
                const Progress& user)
      : request_(request), config_(options.settings.live.training), metadata_(std::move(metadata)), exchange_(exchange),
        user_(user), pool_(options.settings.live.key_frames), trainer_(options), publisher_(request, Clock::now()),
        thread_([this] { run(); }) {}
  TrainerThread(const TrainerThread&) = delete;
  TrainerThread& operator=(const TrainerThread&) = delete;
  ~TrainerThread() {
    if (!thread_.joinable()) return;
    exchange_.stop(); // an error on the way
    exchange_.give(LiveSnapshot{{}, {}, true});
    thread_.join();
  }

  /// Waits for its end. Throws what ended it.
  void join() {
    thread_.join();
    exchange_.rethrow();
  }
  const LiveTrainer& trainer() const { return trainer_; }
  const KeyFramePool& pool() const { return pool_; }
  std::size_t views_refined() const { return views_refined_; }
  const Publisher& publisher() const { return publisher_; }
  const clip::Clip& clip() const { return clip_; } ///< the last one

private:
  void run() {
    yield_to_other_threads();
    try {
      work();
    } catch (...) {
      exchange_.fail(std::current_exception());
    }
  }

  void work() {
    StopSign stop(exchange_, user_);
    std::optional<SerialLoops> serial(std::in_place); // while there are frames to follow
    std::optional<Clock::time_point> end;             // of the capture
    std::shared_ptr<const LiveSnapshot> snapshot = exchange_.newest();
    for (;;) {
      if (snapshot->is_last) serial.reset();
      // The last snapshot is trained with once in any case: its motion becomes that of the layers.
      const bool has_trained = train(*snapshot, stop);
      if (snapshot->is_last && !end) end = Clock::now();
      const bool is_over = end && (!has_trained || stop.cancelled() || seconds_since(*end) >= request_.after_end);
      if (is_over || publisher_.is_due()) {
        if (has_trained) refine_asked_view(*snapshot, stop);
        publisher_.publish(clip_of(*snapshot));
      }
      if (is_over) break;
      if (!snapshot->is_last) snapshot = exchange_.newest(has_trained ? nullptr : snapshot.get());
    }
    clip_ = clip_of(*snapshot);
  }

  bool train(const LiveSnapshot& snapshot, Progress& stop) {
    for (const KeyFrame& frame : exchange_.take_frames(static_cast<int>(snapshot.timeline.times.size())))
      pool_.add(frame, snapshot);
    const std::size_t rays = trainer_.outcomes().empty() ? config_.first_rays : config_.rays;
    return trainer_.train(snapshot, pool_.frames(), rays, stop);
  }

  void refine_asked_view(const LiveSnapshot& snapshot, Progress& stop) {
    if (!request_.asked_view || config_.view_rays == 0 || stop.cancelled()) return;
    const std::optional<SE3> camera_to_world = request_.asked_view();
    if (!camera_to_world) return;
    trainer_.refine(snapshot, pool_.frames_for(*camera_to_world, snapshot), config_.view_rays, stop);
    ++views_refined_;
  }

  clip::Clip clip_of(const LiveSnapshot& snapshot) const {
    clip::Clip clip = trainer_.clip(snapshot);
    clip.metadata.update(metadata_);
    return clip;
  }

  const LiveRequest& request_;
  LiveTrainingConfig config_;
  Json metadata_;
  LiveExchange& exchange_;
  const Progress& user_;
  KeyFramePool pool_;
  LiveTrainer trainer_;
  Publisher publisher_;
  clip::Clip clip_;
  std::size_t views_refined_ = 0;
  std::thread thread_; ///< last: it uses all the others
};

/// How the frames were kept up with.
struct FrontEndLog {
  std::vector<double> latencies; ///< seconds from a frame's capture to its motion
  double seconds = 0;            ///< from the first frame to the last motion
  bool was_stopped = false;      ///< by the user
};

std::optional<ingest::Frame> next_frame(ingest::Capture& capture, FrontEndLog& log) {
  try {
    return capture.next();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInterrupted) throw;
    log.was_stopped = true;
    return std::nullopt;
  }
}

FrontEndLog follow_frames(ingest::Capture& capture, FrontEnd& front_end, LiveExchange& exchange, StageTimes& times,
                          Progress& progress) {
  FrontEndLog log;
  const Clock::time_point start = Clock::now();
  for (int number = 0;; ++number) {
    exchange.rethrow();
    std::optional<ingest::Frame> read = times.measure("wait for a frame", [&] { return next_frame(capture, log); });
    if (!read) break;
    const auto frame = std::make_shared<const ingest::Frame>(std::move(*read));
    if (front_end.add(*frame, false, times)) exchange.show({number, frame});
    log.latencies.push_back(capture.age());
    if (exchange.wants_snapshot()) {
      times.measure("tell the trainer",
                    [&] { exchange.give(snapshot_of(front_end.timeline(), front_end.labels(), false)); });
    }
    log.seconds = seconds_since(start);
    progress.advance(static_cast<std::size_t>(frame->index) + 1,
                     fmt::format("{:.1f} frames/s, {} lost", (number + 1) / log.seconds, capture.dropped()));
  }
  return log;
}

Json live_json(const ingest::Capture& capture, FrontEndLog log, const TrainerThread& trainer, double after_end) {
  std::sort(log.latencies.begin(), log.latencies.end());
  const auto latency = [&](double share) {
    return round4(1000 *
                  log.latencies[static_cast<std::size_t>(share * static_cast<double>(log.latencies.size() - 1))]);
  };
  Json rounds = Json::object(); // median milliseconds of each stage
  const Json spent = trainer.trainer().times().json(1);
  for (const auto& [stage, time] : spent.items()) rounds[stage] = time["ms_per_frame"];
  return {{"frames_followed", log.latencies.size()},
          {"frames_lost", capture.dropped()},
          {"frames_per_second", round4(static_cast<double>(log.latencies.size()) / log.seconds)},
          {"capture_to_motion_ms", {{"median", latency(0.5)}, {"p95", latency(0.95)}, {"max", latency(1)}}},
          {"seconds", round4(log.seconds)},
          {"seconds_after_end", round4(after_end)},
          {"stopped", log.was_stopped},
          {"rounds", trainer.trainer().rounds()},
          {"round_ms", std::move(rounds)},
          {"key_frames", trainer.pool().frames().size()},
          {"frames_blurred", trainer.pool().blurred()},
          {"views_refined", trainer.views_refined()},
          {"fields_begun_anew", trainer.trainer().begun_anew()},
          {"clips_written", trainer.publisher().count()},
          {"first_clip_s", round4(trainer.publisher().first())}};
}

Json capture_json(const ingest::Capture& capture, bool has_masks, const clip::Clip& clip, std::size_t unlabelled) {
  const ingest::CaptureInfo& info = capture.info();
  Json skipped = Json::array();
  for (const ingest::SkippedFrame& frame : capture.skipped())
    skipped.push_back({{"frame", frame.index}, {"reason", frame.reason}});
  return {{"format", info.format},
          {"size", {info.intrinsics.width, info.intrinsics.height}},
          {"frames_in_source", info.frame_count},
          {"frames_used", clip.times.size()},
          {"frames_held_out", 0},
          {"frames_without_mask", unlabelled},
          {"frames_per_second", info.frames_per_second},
          {"has_poses", info.has_poses},
          {"has_masks", has_masks},
          {"skipped", std::move(skipped)}};
}

/// Every label, with what became of it, for the report.
void add_layers(const std::map<int, TrackedLabel>& labels, const LiveTrainer& trainer, Json& report) {
  report["layers"] = report["not_modelled"] = Json::array();
  for (const auto& [number, label] : labels) {
    const auto found = trainer.outcomes().find(number);
    if (found != trainer.outcomes().end()) {
      LayerOutcome outcome = found->second;
      outcome.why = why_it_moves_so(label, outcome.layer.motion);
      report["layers"].push_back(layer_json(label, outcome));
      continue;
    }
    const std::string why = why_not_followed(label);
    report["not_modelled"].push_back({{"name", label.plan.name},
                                      {"label", number},
                                      {"why", why.empty() ? "it was not trained before the end" : why}});
  }
}

void check_clip(const clip::Clip& clip, bool was_stopped) {
  if (!clip.layers.empty()) return;
  const ErrorCode code = was_stopped          ? ErrorCode::kInterrupted
                         : clip.times.empty() ? ErrorCode::kCorruptInput
                                              : ErrorCode::kFailure;
  throw Error(code, clip.times.empty() ? "the capture gave no usable frame, and no clip was made"
                                       : "nothing in this capture could be modelled so far, and no clip was made");
}

} // namespace

EncodeResult encode_live(ingest::Capture& given, const LiveRequest& request, const EncodeOptions& options,
                         Progress& progress) {
  const std::unique_ptr<ingest::Capture> labelled =
      given.info().has_masks ? nullptr : ingest::live_segmented_capture(given, {}, progress);
  ingest::Capture& capture = labelled ? *labelled : given;
  const ingest::CaptureInfo& info = capture.info();
  Json config = options.json();
  config["labels_from"] = labelled ? "motion" : "masks";
  config["joints_from"] = "";
  const Json settings = settings_json(options.settings);
  StageTimes times;
  FrontEnd front_end(info, options, progress);
  LiveExchange exchange;
  progress.stage("following live", options.expected_frames(info.frame_count));
  TrainerThread trainer(request, options, clip_metadata(info, config, settings), exchange, progress);
  FrontEndLog log = follow_frames(capture, front_end, exchange, times, progress);
  if (log.was_stopped) exchange.stop();
  const Clock::time_point end = Clock::now();
  const std::size_t unlabelled = front_end.unlabelled();
  const clip::Clip timeline = front_end.timeline();
  const std::map<int, TrackedLabel> labels = std::move(front_end).finish(times);
  exchange.give(snapshot_of(timeline, labels, true));
  trainer.join();
  log.was_stopped |= progress.cancelled();
  check_clip(trainer.clip(), log.was_stopped);
  Json report = {{"schema", "kinora.encode/1"},
                 {"version", KINORA_VERSION},
                 {"config", config},
                 {"settings", settings},
                 {"capture", capture_json(capture, !labelled, timeline, unlabelled)},
                 {"live", live_json(capture, log, trainer, seconds_since(end))},
                 {"timing", {{"stages", times.json(timeline.times.size())}}}};
  add_layers(labels, trainer.trainer(), report);
  return {trainer.clip(), std::move(report)};
}

} // namespace kinora::encode
