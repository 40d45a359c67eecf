#include "ingest/capture/capture.h"

#include <future>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "host/plugin_table.h"
#include "ingest/capture/frame_source.h"

namespace kinora::ingest {
namespace {

CaptureInfo info_of(const host::FrameReader& reader, const CaptureOptions& options) {
  const KinoraCaptureInfo& given = reader.info();
  CaptureInfo info;
  info.format = reader.format().name;
  info.intrinsics = {given.camera.width, given.camera.height, given.camera.fx,
                     given.camera.fy,    given.camera.cx,     given.camera.cy};
  info.frame_count = static_cast<int>(std::min<std::int64_t>(given.frame_count, std::numeric_limits<int>::max()));
  info.frames_per_second = given.frames_per_second;
  info.has_poses = given.has_poses != 0;
  info.has_masks = given.has_masks != 0 && options.use_masks;
  info.has_depth_camera = given.has_depth_camera != 0;
  info.registration = options.registration;
  if (info.registration) info.intrinsics = info.registration->color;
  for (std::size_t i = 0; i < given.label_count; ++i)
    info.labels[given.labels[i].label] = {given.labels[i].name, given.labels[i].kind, ""};
  return info;
}

/// A capture that a plugin reads. While the caller works on a frame, the next one is read on another thread.
class PluginCapture final : public Capture {
public:
  PluginCapture(const std::filesystem::path& path, host::FrameReader reader, const CaptureOptions& options,
                Progress& progress)
      : path_(path.string()), info_(info_of(reader, options)), expected_(options.frames.count_of(info_.frame_count)),
        progress_(progress), source_(std::move(reader), options), device_(options.device) {
    if (expected_ == 0)
      throw Error(ErrorCode::kUsage, fmt::format("{}: has {} frames, none of which lies in the range that starts at {}",
                                                 path_, info_.frame_count, options.frames.begin));
    const KinoraCaptureInfo& given = source_.reader().info();
    for (std::size_t i = 0; i < given.warning_count; ++i) progress_.warn(given.warnings[i]);
  }

  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }

  std::size_t dropped() const override { return dropped_; }
  double age() const override { return device_ ? device_->age(last_time_) : 0; }

  std::optional<Frame> next() override {
    while (!ended_) {
      progress_.check();
      SourceResult result = take();
      ended_ = result.end;
      if (ended_) break;
      dropped_ += result.dropped;
      last_time_ = result.device_time;
      if (result.has_infrared) warn_of_infrared();
      if (result.mask_was_laid) warn_of_mask(result.index);
      if (result.problem.empty()) return std::move(result.frame);
      skip(result);
    }
    return std::nullopt;
  }

private:
  SourceResult take() {
    const bool read_ahead = thread_count() > 1;
    SourceResult result = ahead_.valid() ? ahead_.get() : source_.next();
    if (read_ahead && !result.end) ahead_ = std::async(std::launch::async, [this] { return source_.next(); });
    return result;
  }

  void warn_of_infrared() {
    if (!std::exchange(warned_of_infrared_, true))
      progress_.warn(
          fmt::format("{}: the infrared images that the format {} delivers are not used", path_, info_.format));
  }

  void warn_of_mask(int index) {
    if (!std::exchange(warned_of_mask_, true))
      progress_.warn(
          fmt::format("the mask of frame {} misses the edges of what it covers; it is laid on edges of depth and "
                      "colour, and so are others like it (--set ingest.masks_on_edges=false: as they are)",
                      index));
  }

  void skip(const SourceResult& result) {
    skipped_.push_back({result.index, result.problem});
    progress_.warn(fmt::format("frame {} is skipped: {}", result.index, result.problem));
    if (2 * skipped_.size() > static_cast<std::size_t>(expected_))
      throw Error(
          ErrorCode::kCorruptInput,
          fmt::format("{}: {} of {} frames cannot be used; repair the capture or choose other frames; the first: {}",
                      path_, skipped_.size(), expected_, skipped_.front().reason));
  }

  std::string path_;
  CaptureInfo info_;
  int expected_;
  Progress& progress_;
  FrameSource source_;
  std::shared_ptr<host::SimulatedDevice> device_;
  std::size_t dropped_ = 0;
  double last_time_ = 0; ///< the device's
  std::vector<SkippedFrame> skipped_;
  bool ended_ = false;
  bool warned_of_infrared_ = false;
  bool warned_of_mask_ = false;
  std::future<SourceResult> ahead_; ///< last, so that its thread has ended before anything else goes
};

} // namespace

std::unique_ptr<Capture> Capture::open(const host::PluginTable& plugins, const std::filesystem::path& path,
                                       const CaptureOptions& options, Progress& progress) {
  const KinoraFormat& format = options.format.empty() ? plugins.recognise(path) : plugins.find(options.format);
  host::Options reader_options = options.format_options;
  for (std::size_t i = 0; i < format.option_count; ++i)
    if (!options.use_masks && std::string_view(format.options[i].name) == "masks") reader_options["masks"] = "false";
  return std::make_unique<PluginCapture>(path, host::FrameReader(format, path, reader_options), options, progress);
}

} // namespace kinora::ingest
