// Things that people handle, found over a whole capture: where they were alone, and what they look like.
#pragma once

#include <span>
#include <vector>

#include "ingest/images/color_model.h"
#include "ingest/segmentation/background_map.h"

namespace kinora::ingest {

/// Where a thing was seen at rest, from one place.
struct RestingView {
  Camera camera;
  DepthImage depth; ///< metres; 0: the thing is not there
};

struct HandledObject {
  ColorModel color;
  double area = 0;          ///< square metres that are seen of it, median
  float prior = 0;          ///< by its share of the foreground, as a log ratio of at least −2
  bool flat = false;        ///< found by flat faces that it shows all along; else it was seen alone, at rest
  bool is_flexible = false; ///< nothing shows that it is rigid: it lay alone and has no flat faces
  std::vector<RestingView> resting_views; ///< none if `flat`
};

/// What one pass over samples of a capture learns about what moves in it.
struct SceneObjects {
  std::vector<HandledObject> objects; ///< the largest first
  ColorModel others;                  ///< colours of all other foreground
};

/// Foreground pixels without specks: of each piece, what stands clear of still surfaces must be none.
Mask foreground_mask(const ReducedView& view, const LocalBackground& background);

/// A thing is (a) a small surface that lay alone, at one place, in at least a tenth of the samples, and was touched or
/// moved in others, or (b) flat faces that are seen in at least two fifths of the samples and differ in colour from the
/// rest of the foreground. With fewer than eight samples nothing is told apart.
SceneObjects find_handled_objects(std::span<const ReducedView> samples, const BackgroundMap& background);

} // namespace kinora::ingest
