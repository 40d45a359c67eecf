#include "host/frame_fault.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace kinora::host {
namespace {

/// Of the camera's size, with rows that do not overlap.
bool is_image(const KinoraImage& image, const KinoraCamera& camera, int channels, KinoraPixelType type) {
  const std::size_t value_bytes = type == KINORA_PIXEL_U16 ? 2 : 1;
  return image.data != nullptr && image.width > 0 && image.width == camera.width && image.height > 0 &&
         image.height == camera.height && image.channels == channels && image.pixel_type == type &&
         image.row_bytes >= value_bytes * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(channels);
}

bool is_absent_or_image(const KinoraImage& image, const KinoraCamera& camera, KinoraPixelType type) {
  return image.data == nullptr || is_image(image, camera, 1, type);
}

} // namespace

std::string fault_of(const KinoraFrame& frame, const KinoraCaptureInfo& info) {
  const KinoraCamera& depth_camera = info.has_depth_camera != 0 ? info.depth_camera : info.camera;
  if (!is_image(frame.color, info.camera, 3, KINORA_PIXEL_U8))
    return "gave no colour image of the camera's size (or rows that overlap)";
  if (!is_image(frame.depth, depth_camera, 1, KINORA_PIXEL_U16))
    return "gave no depth image of the camera's size (or rows that overlap)";
  if (!is_absent_or_image(frame.infrared, depth_camera, KINORA_PIXEL_U16))
    return "gave an infrared image that is not of the depth camera's size";
  if (!is_absent_or_image(frame.confidence, depth_camera, KINORA_PIXEL_U8))
    return "gave a confidence image that is not of the depth camera's size";
  if (!is_absent_or_image(frame.labels, info.camera, KINORA_PIXEL_U8))
    return "gave a mask that is not of the camera's size";
  if (!(frame.depth_unit > 0) || !std::isfinite(frame.depth_unit)) return "gave no unit of depth";
  if (!std::isfinite(frame.time)) return "gave a time that is not finite";
  if (frame.has_pose != 0 && !std::all_of(std::begin(frame.camera_to_world), std::end(frame.camera_to_world),
                                          [](double value) { return std::isfinite(value); }))
    return "gave a camera pose that is not finite";
  return {};
}

} // namespace kinora::host
