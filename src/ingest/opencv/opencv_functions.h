// What Kinora has OpenCV do. OpenCV is large and only some captures need it: its users stand in a module
// (core/module.h) of these functions, which is opened when one is first asked for. Images of a call have one size. All
// functions give the same bits for any number of threads.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>

#include "core/image.h"

namespace kinora::ingest {

class JointDetector;
class Segmenter;

/// Five Gaussians of colour: weights, means, covariances, as OpenCV keeps them.
using ColorMixture = std::array<double, 65>;

/// Regions of pixels that touch each other, also at corners.
struct PixelRegions {
  Image<std::int32_t> map; ///< number of each pixel's region; 0: none
  int count = 0;           ///< with number 0
};

/// Defined in the module alone: called through opencv_functions().
namespace opencv {

/// As ingest/optical_flow.h says.
Image<float> optical_flow(const ColorImage& to, const ColorImage& from);

/// Of one channel, with a standard deviation in pixels; beyond the border its pixels are repeated. Thread-safe.
Image<float> gaussian_blur(const Image<float>& image, double sigma);

/// Of the pixels that are not 0. Thread-safe.
PixelRegions connected_regions(const Image<std::uint8_t>& mask);

/// 1 where all labels within `radius` pixels are equal. Thread-safe.
Image<std::uint8_t> inner_pixels(const LabelImage& labels, int radius);

/// Colours of the pixels with the label and of all others; both must occur. Thread-safe.
void learn_mixtures(const ColorImage& color, const LabelImage& labels, std::uint8_t label, ColorMixture& own,
                    ColorMixture& rest);

/// One cut by these mixtures, which stay. `states` are OpenCV's: 0 not the label, 1 the label, 2 perhaps not, 3
/// perhaps. Thread-safe.
void cut(const ColorImage& color, const ColorMixture& own, const ColorMixture& rest, Image<std::uint8_t>& states);

/// As ingest/grab_cut.h says; `present` are the labels that occur.
void sharpen_borders(const ColorImage& color, int radius, std::span<const std::uint8_t> present, LabelImage& labels);

/// As ingest/network_segmenter.h and ingest/joint_detector.h say.
std::unique_ptr<Segmenter> make_network_segmenter(const std::filesystem::path& network);
std::unique_ptr<JointDetector> make_network_detector(const std::filesystem::path& network);

} // namespace opencv

/// What the module exports, through `extern "C" const OpenCvFunctions* kinora_functions()`.
struct OpenCvFunctions {
  decltype(&opencv::optical_flow) optical_flow;
  decltype(&opencv::gaussian_blur) gaussian_blur;
  decltype(&opencv::connected_regions) connected_regions;
  decltype(&opencv::inner_pixels) inner_pixels;
  decltype(&opencv::learn_mixtures) learn_mixtures;
  decltype(&opencv::cut) cut;
  decltype(&opencv::sharpen_borders) sharpen_borders;
  decltype(&opencv::make_network_segmenter) make_network_segmenter;
  decltype(&opencv::make_network_detector) make_network_detector;
};

/// Thread-safe. Throws Error(kMissingComponent) if the module or OpenCV is not installed.
const OpenCvFunctions& opencv_functions();

} // namespace kinora::ingest
