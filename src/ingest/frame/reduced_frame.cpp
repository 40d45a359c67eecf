#include "ingest/frame/reduced_frame.h"

#include "core/parallel.h"
#include "ingest/frame/pixel_blocks.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kRowsPerChunk = 16;

} // namespace

Frame reduced_frame(const Frame& frame, int factor) {
  const Intrinsics& k = frame.camera.intrinsics;
  const int width = k.width / factor;
  const int height = k.height / factor;
  const double middle = 0.5 * (factor - 1);
  Frame reduced{frame.index,
                frame.time,
                {{width, height, k.fx / factor, k.fy / factor, (k.cx - middle) / factor, (k.cy - middle) / factor},
                 frame.camera.camera_to_world},
                ColorImage(width, height, 3),
                DepthImage(width, height),
                DepthImage(width, height),
                frame.has_labels() ? LabelImage(width, height) : LabelImage(),
                frame.people};
  for (DetectedPerson& person : reduced.people) {
    for (DetectedJoint& joint : person.joints) joint.pixel = (joint.pixel - Eigen::Vector2d::Constant(middle)) / factor;
  }
  parallel_for(static_cast<std::size_t>(height), kRowsPerChunk, [&](const Chunk& rows) {
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v) {
      for (int u = 0; u < width; ++u) {
        const int left = u * factor;
        const int top = v * factor;
        const std::uint8_t label = frame.label_at(left + factor / 2, top + factor / 2);
        const auto has_label = [&](int x, int y) { return frame.label_at(x, y) == label; };
        if (frame.has_labels()) reduced.labels.at(u, v) = label;
        reduced.depth.at(u, v) = mean_depth(frame.depth, left, top, factor, has_label);
        reduced.clean_depth.at(u, v) = mean_depth(frame.clean_depth, left, top, factor, has_label);
        mean_color(frame.color, left, top, factor, reduced.color.pixel(u, v));
      }
    }
  });
  return reduced;
}

} // namespace kinora::ingest
