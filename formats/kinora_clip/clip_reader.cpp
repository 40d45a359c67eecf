#include "kinora_clip/clip_reader.h"

#include <algorithm>

#include "clip/clip_io.h"
#include "clip/missing_parts.h"
#include "common/float_depth.h"
#include "common/frame_pairs.h"

namespace kinora::formats {
namespace {

clip::Clip read_clip(const std::filesystem::path& path, std::vector<std::string>& warnings) {
  std::vector<std::string> missing;
  clip::Clip clip = clip::read_whole_parts(std::make_unique<container::FileSource>(path), missing);
  if (!missing.empty()) warnings.push_back(clip::missing_sentence(path.string(), missing));
  return clip;
}

bool has_labelled_layer(const clip::Clip& clip) {
  return std::ranges::any_of(clip.layers, [](const clip::Layer& layer) { return layer.label != 0; });
}

} // namespace

ClipReader::ClipReader(const std::filesystem::path& path, bool read_masks)
    : player_(read_clip(path, warnings_)), has_masks_(read_masks && has_labelled_layer(player_.clip())) {
  for (const clip::Layer& layer : player_.clip().layers)
    labels_.add(layer.label, layer.name, std::string(motion::name_of(layer.motion.kind())));
  warning_table_.set(warnings_);
}

void ClipReader::fill_info(KinoraCaptureInfo& info) const {
  const clip::Clip& clip = player_.clip();
  info.frame_count = static_cast<std::int64_t>(clip.times.size());
  info.start_time = clip.times.front();
  info.frames_per_second = median_rate(clip.times);
  info.camera = camera_of(clip.intrinsics, {});
  info.has_poses = clip.camera_to_world.size() > 1 ? 1 : 0;
  info.has_masks = has_masks_ ? 1 : 0;
  if (has_masks_) labels_.fill(info);
  warning_table_.fill(info);
}

KinoraStatus ClipReader::next(KinoraFrame& frame) {
  const clip::Clip& clip = player_.clip();
  if (next_ >= clip.times.size()) return KINORA_END;
  const std::size_t index = next_++;
  const auto number = static_cast<double>(index);
  const Camera camera = clip.capture_camera(number);
  const clip::LayerChoice drawn = player_.drawn_layers(number, player_.all_layers());
  take(player_.draw(camera, number, drawn), drawn);
  frame.index = static_cast<std::int64_t>(index);
  frame.time = clip.times[index];
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = kFloatDepthUnit;
  if (has_masks_) frame.labels = view_of(mask_, KINORA_PIXEL_U8);
  if (clip.camera_to_world.size() > 1) set_pose(frame, camera.camera_to_world);
  return KINORA_OK;
}

void ClipReader::take(const fields::Picture& picture, const clip::LayerChoice& drawn) {
  const int width = picture.color.width();
  const int height = picture.color.height();
  color_ = ColorImage(width, height, 3);
  depth_ = DepthImage16(width, height);
  mask_ = LabelImage(width, height);
  const std::vector<clip::Layer>& layers = player_.clip().layers;
  for (std::size_t i = 0; i < color_.pixel_count(); ++i) {
    const std::uint8_t* pixel = picture.color.data() + 4 * i;
    for (std::size_t c = 0; c < 3; ++c)
      color_.data()[3 * i + c] = static_cast<std::uint8_t>((pixel[c] * pixel[3] + 127) / 255);
    depth_.data()[i] = depth_units(static_cast<double>(picture.depth.data()[i]));
    const std::size_t front = picture.front.data()[i];
    mask_.data()[i] = front == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(layers[drawn[front - 1]].label);
  }
}

void ClipReader::seek(std::int64_t index) { next_ = checked_seek(index, player_.frame_count()); }

} // namespace kinora::formats
