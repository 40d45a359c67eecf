// Pixels out of ROS image messages.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "ros/messages.h"

namespace kinora::formats {

/// Whether an encoding (or the format of a compressed image) is of depth, or of colour.
bool is_depth_encoding(const std::string& encoding, bool compressed);
bool is_color_encoding(const std::string& encoding, bool compressed);
/// Whether its depth comes as floats in metres, which are rounded to kFloatDepthUnit.
bool is_float_depth(const std::string& encoding);

/// sRGB. Throws Error(kCorruptInput), naming `source`.
ColorImage color_image_of(const ImageMessage& message, bool compressed, const std::string& source);
/// Units of the sender, or of kFloatDepthUnit. Throws Error(kCorruptInput), naming `source`.
DepthImage16 depth_image_of(const ImageMessage& message, bool compressed, const std::string& source);

} // namespace kinora::formats
