// How blurred what a frame shows is, without knowing it sharp.
// Source: Crété, Dolmière, Ladret, Nicolas, "The Blur Effect: Perception and Estimation with a New No-Reference
// Perceptual Blur Metric", SPIE 6492, 2007: blurring once more takes much from a sharp picture and little from a
// blurred one.
#pragma once

#include <optional>

#include "ingest/frame/frame.h"

namespace kinora::encode {

/// From 0, sharp, to 1, within what is labelled (not background), or in the whole picture where nothing is. The worse
/// of the two directions counts. Nothing if too few pixels tell. Thread-safe.
std::optional<double> blurriness(const ingest::Frame& frame);

} // namespace kinora::encode
