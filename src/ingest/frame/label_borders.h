// Masks as networks and people give them, some pixels too wide, too narrow or ragged, laid on the edges of the picture.
// A label's border is the edge of a thing: where it is right, colour changes there more than beside it.
#pragma once

#include <optional>

#include "ingest/frame/frame.h"

namespace kinora::ingest {

/// Pixels to both sides of a border between which the edge is looked for: an eightieth of the picture's longer side.
int border_reach(int width, int height);

/// How much colours change across the borders of labels, relative to how much they do beside them, within
/// border_reach(): 2 to 5 where borders are right, 1 where they lie anywhere. Null without a border. Thread-safe.
std::optional<double> border_contrast(const LabelImage& labels, const ColorImage& color);

/// How far borders of labels lie beside the nearest edge of depth: the median over their pixels that have one within
/// border_reach(), in pixels. Null where hardly any have. Thread-safe.
std::optional<double> border_offset(const LabelImage& labels, const DepthImage& depth);

/// Decides anew what lies within border_reach() of a border: labels grow from where they are certain over the lowest
/// edges of depth and colour, so that they meet at the highest; whole borders go to where most edges of depth are
/// before. Where there is no edge a border stays, and what is too narrow to have an inside goes to its surroundings.
/// Background within half of border_reach() of what is labelled loses its depth and clean depth: it may be a rim that
/// was missed. Thread-safe.
/// Source: Beucher, Meyer, "The Morphological Approach to Segmentation: The Watershed Transformation", 1993 (flooding
/// from markers).
void lay_borders_on_edges(Frame& frame);

/// The same only where borders miss the edges of colour and of depth. Returns whether. A frame without labels is left
/// alone.
bool repair_borders(Frame& frame);

} // namespace kinora::ingest
