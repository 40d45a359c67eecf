#include <set>

#include "ingest/joints/joint_detector.h"

namespace kinora::ingest {
namespace {

std::set<int> labels_of_people(const std::map<int, LabelInfo>& labels) {
  std::set<int> people;
  const auto person = labels.find(1);
  if (person == labels.end() || person->second.kind.empty()) people.insert(1);
  for (const auto& [label, info] : labels) {
    if (info.kind == "deforming") people.insert(label);
  }
  return people;
}

class DetectedCapture final : public Capture {
public:
  DetectedCapture(std::unique_ptr<Capture> capture, std::unique_ptr<JointDetector> detector)
      : capture_(std::move(capture)), detector_(std::move(detector)),
        people_(labels_of_people(capture_->info().labels)) {}

  const CaptureInfo& info() const override { return capture_->info(); }
  const std::vector<SkippedFrame>& skipped() const override { return capture_->skipped(); }

  std::optional<Frame> next() override {
    std::optional<Frame> frame = capture_->next();
    if (!frame) return frame;
    for (const int label : people_) frame->people.push_back(detector_->detect(*frame, label));
    return frame;
  }

private:
  std::unique_ptr<Capture> capture_;
  std::unique_ptr<JointDetector> detector_;
  std::set<int> people_;
};

} // namespace

std::unique_ptr<Capture> detected_capture(std::unique_ptr<Capture> capture, std::unique_ptr<JointDetector> detector) {
  return std::make_unique<DetectedCapture>(std::move(capture), std::move(detector));
}

} // namespace kinora::ingest
