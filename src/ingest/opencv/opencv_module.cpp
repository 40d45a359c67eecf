// The module opencv: what it exports.
#include "ingest/opencv/opencv_functions.h"

extern "C" const kinora::ingest::OpenCvFunctions* kinora_functions() {
  namespace opencv = kinora::ingest::opencv;
  static constexpr kinora::ingest::OpenCvFunctions functions = {
      .optical_flow = opencv::optical_flow,
      .gaussian_blur = opencv::gaussian_blur,
      .connected_regions = opencv::connected_regions,
      .inner_pixels = opencv::inner_pixels,
      .learn_mixtures = opencv::learn_mixtures,
      .cut = opencv::cut,
      .sharpen_borders = opencv::sharpen_borders,
      .make_network_segmenter = opencv::make_network_segmenter,
      .make_network_detector = opencv::make_network_detector,
  };
  return &functions;
}
