// What every USD text file begins with, and its words.
// Source: Pixar, "USD glossary", layer metadata.
#pragma once

#include <string>

#include "common/facts.h"
#include "common/world_axes.h"

namespace kinora::formats {

/// A layer: one file of USD.
struct UsdLayer {
  double rate = 30;     ///< time codes, which are frames, per second
  double last_time = 0; ///< seconds
  WorldAxes axes = {};  ///< upAxis and metersPerUnit
  Facts facts = {};     ///< customLayerData
};

/// "#usda 1.0" and the layer's metadata; its root prim is called "clip".
std::string usd_layer_head(const UsdLayer& layer);

/// Seconds as a time code, to a thousandth.
std::string usd_time_code(double seconds, double rate);

/// A string with its quotation marks.
std::string usd_quoted(const std::string& text);

} // namespace kinora::formats
