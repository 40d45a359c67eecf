#include "ingest/segmentation/segmenter.h"

#include "ingest/segmentation/background_map.h"
#include "ingest/segmentation/frame_labelling.h"
#include "ingest/segmentation/handled_objects.h"
#include "ingest/segmentation/sample_views.h"

namespace kinora::ingest {
namespace {

class MotionSegmenter final : public Segmenter {
public:
  explicit MotionSegmenter(bool only_foreground) : only_foreground_(only_foreground) {}

  void prepare(const CaptureFactory& open, const FrameRange& range, Progress& progress) override {
    labels_ = {{0, background_label()}};
    std::vector<ReducedView> samples = sample_views(open, range, progress);
    if (samples.empty()) return;
    auto background = std::make_unique<BackgroundMap>(samples);
    if (!background->keeps_still()) return take_all_for_background(progress);
    SceneObjects objects = only_foreground_ ? SceneObjects{} : find_handled_objects(samples, *background);
    labelling_ = std::make_unique<FrameLabelling>(std::move(background), std::move(objects), samples.size());
    labels_ = labelling_->labels();
  }

  void label(Frame& frame) override {
    if (labelling_ && only_foreground_)
      labelling_->mark_foreground(frame);
    else if (labelling_)
      labelling_->label(frame);
    else
      frame.labels = LabelImage(frame.depth.width(), frame.depth.height());
  }

  const std::map<int, LabelInfo>& labels() const override { return labels_; }

private:
  void take_all_for_background(Progress& progress) {
    labels_[0].why = "hardly anything keeps still: without masks or a network everything is taken for background";
    progress.warn("hardly anything keeps still before the camera, so that what moves by itself cannot be told without "
                  "masks or --segmenter; everything is taken for background");
  }

  bool only_foreground_;
  std::map<int, LabelInfo> labels_;
  std::unique_ptr<FrameLabelling> labelling_;
};

} // namespace

std::unique_ptr<Segmenter> make_motion_segmenter() { return std::make_unique<MotionSegmenter>(false); }

std::unique_ptr<Segmenter> make_foreground_segmenter() { return std::make_unique<MotionSegmenter>(true); }

} // namespace kinora::ingest
