#include "ingest/segmentation/segmenter.h"

#include <fmt/format.h>

#include "ingest/segmentation/background_map.h"
#include "ingest/segmentation/frame_labelling.h"
#include "ingest/segmentation/handled_objects.h"
#include "ingest/segmentation/sample_views.h"

namespace kinora::ingest {
namespace {

constexpr double kMinStatic = 0.35; ///< share of the background that keeps still, else the camera is elsewhere

class MotionSegmenter final : public Segmenter {
public:
  explicit MotionSegmenter(bool only_foreground) : only_foreground_(only_foreground) {}

  void prepare(const CaptureFactory& open, const FrameRange& range, Progress& progress) override {
    labels_ = {{0, {"background", "still", "what keeps still, and planes that it lies on"}}};
    std::vector<ReducedView> samples = sample_views(open, range, progress);
    if (samples.empty()) return;
    auto background = std::make_unique<BackgroundMap>(samples);
    if (background->static_share() < kMinStatic) return take_all_for_background(progress);
    SceneObjects objects = only_foreground_ ? SceneObjects{} : find_handled_objects(samples, *background);
    labels_[1] = {"person", "deforming", "what moves before the background, without the things it handles"};
    for (std::size_t i = 0; i < objects.objects.size(); ++i) add_object(objects.objects[i], static_cast<int>(i) + 2);
    labelling_ = std::make_unique<FrameLabelling>(std::move(background), std::move(objects), samples.size());
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

  void add_object(const HandledObject& object, int label) {
    const std::string name = label == 2 ? "object" : fmt::format("object{}", label - 1);
    if (object.flat)
      labels_[label] = {name, "rigid", "flat faces, of other colours than the one who holds it, are seen all along"};
    else if (object.is_flexible)
      labels_[label] = {name, "deforming",
                        "it lay alone, was touched or moved, and has no flat faces that would keep their shape"};
    else
      labels_[label] = {name, "rigid", "it lay alone, was touched or moved, and has flat faces"};
  }

  bool only_foreground_;
  std::map<int, LabelInfo> labels_;
  std::unique_ptr<FrameLabelling> labelling_;
};

} // namespace

std::unique_ptr<Segmenter> make_motion_segmenter() { return std::make_unique<MotionSegmenter>(false); }

std::unique_ptr<Segmenter> make_foreground_segmenter() { return std::make_unique<MotionSegmenter>(true); }

} // namespace kinora::ingest
