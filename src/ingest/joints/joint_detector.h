// Joints of people in a capture's pictures, from a pose network in an ONNX file.
// Sources: Xiao, Wu, Wei, "Simple Baselines for Human Pose Estimation and Tracking", ECCV 2018; Sun et al., "Deep
// High-Resolution Representation Learning for Human Pose Estimation", CVPR 2019 (a crop of one person in, heat maps
// out).
#pragma once

#include <filesystem>
#include <memory>

#include "ingest/capture/capture.h"
#include "ingest/opencv/opencv_functions.h"

namespace kinora::ingest {

/// Not thread-safe; the same bits for any number of threads.
class JointDetector {
public:
  virtual ~JointDetector() = default;
  /// Joints of the person that has the label; those of a label that the frame hardly shows are not found.
  virtual DetectedPerson detect(const Frame& frame, int label) = 0;
};

/// The network takes a crop of one person, 1 × 3 × height × width as its file says, RGB with ImageNet's mean and
/// deviation (0.485, 0.456, 0.406; 0.229, 0.224, 0.225 of 1), and gives 1 × 17 × h × w heat maps of COCO's joints, as
/// HRNet, SimpleBaseline and ViTPose do. The crop is the bounding box of the label in the network's proportions, 1.25
/// times as large. A joint is where its heat map is largest, a quarter of a cell towards the larger neighbour; its
/// score is that value. Throws Error: kCorruptInput if the file is missing, is no network that OpenCV can run, or takes
/// or gives anything else; said before any picture is looked at.
inline std::unique_ptr<JointDetector> make_network_detector(const std::filesystem::path& network) {
  return opencv_functions().make_network_detector(network);
}

/// The capture with joints of its people in every frame (Frame::people): of the labels that the capture says to be
/// deforming, and of label 1 if it says nothing of that.
std::unique_ptr<Capture> detected_capture(std::unique_ptr<Capture> capture, std::unique_ptr<JointDetector> detector);

} // namespace kinora::ingest
