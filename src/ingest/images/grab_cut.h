// GrabCut (Rother et al., 2004) through OpenCV: borders of labels, by colour. All images of a call have one size. The
// same bits for any number of threads; thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "ingest/images/surface_components.h"
#include "ingest/opencv/opencv_functions.h"

namespace kinora::ingest {

/// What is known of a pixel before the cut, with OpenCV's values.
enum class Trimap : std::uint8_t { kBackground = 0, kForeground = 1, kProbableBackground = 2, kProbableForeground = 3 };

/// The labels that occur, without the background, in ascending order.
std::vector<std::uint8_t> labels_in(const LabelImage& labels);

/// 1 where all labels within `radius` pixels are equal.
Mask inner_pixels(const LabelImage& labels, int radius);

/// Colours of a label and of all else, as Gaussian mixtures.
class ColorMixtures {
public:
  /// From the pixels with the label and those without; both must occur.
  ColorMixtures(const ColorImage& color, const LabelImage& labels, std::uint8_t label);

  /// 1 where `color` has the label. What `known` is not sure of is decided by these mixtures and by edges.
  Mask cut(const ColorImage& color, const Image<Trimap>& known) const;

private:
  ColorMixture foreground_{};
  ColorMixture background_{};
};

/// Decides anew within `radius` pixels of the labels' borders, by the colours of this frame. Labels too small to have
/// an inside stay as they are.
void sharpen_borders(const ColorImage& color, int radius, LabelImage& labels);

} // namespace kinora::ingest
