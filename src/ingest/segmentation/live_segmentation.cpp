#include <algorithm>
#include <chrono>
#include <deque>
#include <future>
#include <utility>

#include "core/parallel.h"
#include "ingest/segmentation/frame_labelling.h"
#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kMostSamples = 48;
constexpr std::size_t kFewestSamples = 16;     ///< before anything is told apart
constexpr double kLongestWithoutLearning = 30; ///< seconds
constexpr double kMinSameColor = 0.35;         ///< overlap of the colours of one thing, learnt twice

/// Views at equal distances over all that was seen so far.
class SpreadSamples {
public:
  void add(const Frame& frame) {
    if (count_++ % every_ != 0) return;
    views_.push_back(reduced_view(frame, reduction_factor(frame.depth.width())));
    if (views_.size() <= kMostSamples) return;
    for (std::size_t i = 1; 2 * i < views_.size(); ++i) views_[i] = std::move(views_[2 * i]);
    views_.resize((views_.size() + 1) / 2);
    every_ *= 2;
  }
  const std::vector<ReducedView>& views() const { return views_; }

private:
  std::vector<ReducedView> views_;
  std::size_t count_ = 0;
  std::size_t every_ = 1;
};

/// Things of before keep their places, as they look now if they are there again; others follow.
SceneObjects continued(const SceneObjects& before, SceneObjects now) {
  SceneObjects all = before;
  all.others = now.others;
  std::vector<bool> is_taken(before.objects.size(), false);
  for (HandledObject& object : now.objects) {
    std::size_t best = before.objects.size();
    double most = kMinSameColor;
    for (std::size_t i = 0; i < before.objects.size(); ++i) {
      const double overlap = object.color.overlap(before.objects[i].color);
      if (is_taken[i] || overlap <= most) continue;
      most = overlap;
      best = i;
    }
    if (best == before.objects.size()) {
      all.objects.push_back(std::move(object));
    } else {
      is_taken[best] = true;
      all.objects[best] = std::move(object);
    }
  }
  return all;
}

/// Nothing where hardly anything keeps still.
std::unique_ptr<FrameLabelling> learn(const std::vector<ReducedView>& samples, const SceneObjects& before) {
  auto background = std::make_unique<BackgroundMap>(samples);
  if (!background->keeps_still()) return nullptr;
  SceneObjects objects = continued(before, find_handled_objects(samples, *background));
  return std::make_unique<FrameLabelling>(std::move(background), std::move(objects), samples.size(),
                                          LabellingEffort::kLive);
}

class LiveSegmentedCapture final : public Capture {
public:
  LiveSegmentedCapture(Capture& capture, const LiveLabelling& how, Progress& progress)
      : capture_(capture), how_(how), progress_(progress), info_(capture.info()) {
    info_.has_masks = true;
    info_.labels = {{0, background_label()}};
  }

  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return capture_.skipped(); }
  std::size_t dropped() const override { return capture_.dropped(); }
  double age() const override { return capture_.age(); }

  std::optional<Frame> next() override {
    if (!has_learnt_) watch();
    std::optional<Frame> frame;
    if (watched_.empty()) {
      frame = capture_.next();
    } else { // the capture has ended
      frame = std::move(watched_.front());
      watched_.pop_front();
    }
    if (frame) label(*frame);
    return frame;
  }

private:
  /// Until enough was seen, or the capture ends: then what was watched is still to come.
  void watch() {
    double first = 0;
    while (std::optional<Frame> frame = capture_.next()) {
      if (samples_.views().empty()) first = frame->time;
      samples_.add(*frame);
      watched_.push_back(std::move(*frame));
      if (watched_.size() > kMostSamples) watched_.pop_front();
      const double seen = watched_.back().time - first;
      if (seen < how_.watched || samples_.views().size() < kFewestSamples) continue;
      watched_.clear();
      next_learning_ = first + 2 * seen;
      first_time_ = first;
      break;
    }
    has_learnt_ = true;
    if (!samples_.views().empty()) take(learn(samples_.views(), {}));
  }

  void take(std::unique_ptr<FrameLabelling> labelling) {
    if (!labelling) {
      if (!labelling_ && !std::exchange(has_warned_, true))
        progress_.warn("hardly anything keeps still before the camera, so that what moves cannot be told without "
                       "masks; everything is taken for background");
      return;
    }
    labelling_ = std::move(labelling);
    info_.labels = labelling_->labels();
  }

  void label(Frame& frame) {
    samples_.add(frame);
    if (learning_.valid() && learning_.wait_for(std::chrono::seconds(0)) != std::future_status::timeout)
      take(learning_.get());
    if (!learning_.valid() && next_learning_ > 0 && frame.time >= next_learning_) learn_again(frame.time);
    if (labelling_)
      labelling_->label(frame);
    else
      frame.labels = LabelImage(frame.depth.width(), frame.depth.height());
  }

  void learn_again(double now) {
    next_learning_ = std::min(now + (now - first_time_), now + kLongestWithoutLearning);
    learning_ = std::async(how_.learns_beside ? std::launch::async : std::launch::deferred,
                           [samples = samples_.views(), before = labelling_ ? labelling_->objects() : SceneObjects{},
                            beside = how_.learns_beside] {
                             if (!beside) return learn(samples, before);
                             yield_to_other_threads();
                             const SerialLoops serial;
                             return learn(samples, before);
                           });
  }

  Capture& capture_;
  LiveLabelling how_;
  Progress& progress_;
  CaptureInfo info_;
  SpreadSamples samples_;
  std::deque<Frame> watched_; ///< of a capture that ended before enough was seen
  bool has_learnt_ = false;
  bool has_warned_ = false;
  double first_time_ = 0;    ///< seconds
  double next_learning_ = 0; ///< seconds; 0: never
  std::unique_ptr<FrameLabelling> labelling_;
  std::future<std::unique_ptr<FrameLabelling>> learning_; // last: it ends first
};

} // namespace

std::unique_ptr<Capture> live_segmented_capture(Capture& capture, const LiveLabelling& how, Progress& progress) {
  return std::make_unique<LiveSegmentedCapture>(capture, how, progress);
}

} // namespace kinora::ingest
