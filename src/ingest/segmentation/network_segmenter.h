// Labels from a segmentation network in an ONNX file.
#pragma once

#include <filesystem>
#include <memory>

#include "ingest/opencv/opencv_functions.h"
#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {

/// The network takes one RGB image, float, 1 × 3 × height × width, values 0 to 1, at the capture's size (both sides
/// rounded down to multiples of 32 if they are larger than that), and gives 1 × classes × h × w scores:
///  - one class: a foreground score; above 0.5 is label 1 (person),
///  - more: the class with the largest score is the label: 0 background, 1 person, 2 object, 3….
/// Scores of another size are read at the nearest pixel. No pass over the capture is needed.
/// Throws Error: kCorruptInput if the file is missing or is no network that OpenCV can run; `label` throws
/// kCorruptInput if the output is of another form.
inline std::unique_ptr<Segmenter> make_network_segmenter(const std::filesystem::path& network) {
  return opencv_functions().make_network_segmenter(network);
}

} // namespace kinora::ingest
