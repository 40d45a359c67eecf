#include "tracking/view/layer_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"

namespace kinora::tracking {
namespace {

struct Box {
  int u0, v0, u1, v1; ///< end excluded
  bool empty() const { return u0 >= u1; }
};

Box bounding_box(const LabelImage& labels, int label) {
  Box box{labels.width(), labels.height(), 0, 0};
  if (label < 0 || label > 255) return box;
  for (int v = 0; v < labels.height(); ++v) {
    const std::uint8_t* row = labels.pixel(0, v);
    const void* first = std::memchr(row, label, static_cast<std::size_t>(labels.width()));
    if (first == nullptr) continue;
    int end = labels.width();
    while (row[end - 1] != label) --end;
    const int begin = static_cast<int>(static_cast<const std::uint8_t*>(first) - row);
    box = {std::min(box.u0, begin), std::min(box.v0, v), std::max(box.u1, end), v + 1};
  }
  return box;
}

Box grown(const Box& box, int width, int height) {
  const int margin = 8 + std::max(box.u1 - box.u0, box.v1 - box.v0) / 4;
  return {std::max(0, box.u0 - margin), std::max(0, box.v0 - margin), std::min(width, box.u1 + margin),
          std::min(height, box.v1 + margin)};
}

// Of zeros and ones, one more where the 5×5 around has ones alone: the values of MaskArea.
LabelImage cut_mask(const LabelImage& labels, int label, const Box& box) {
  LabelImage mask(box.u1 - box.u0, box.v1 - box.v0);
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u)
      mask.at(u, v) = labels.at(box.u0 + u, box.v0 + v) == label ? MaskArea::kBorder : MaskArea::kOutside;
  }
  LabelImage across(mask.width(), mask.height());
  for (int v = 0; v < mask.height(); ++v) {
    const std::uint8_t* in = mask.pixel(0, v);
    std::uint8_t* out = across.pixel(0, v);
    for (int u = 2; u + 2 < mask.width(); ++u) out[u] = in[u - 2] & in[u - 1] & in[u] & in[u + 1] & in[u + 2];
  }
  for (int v = 2; v + 2 < mask.height(); ++v) {
    std::uint8_t* out = mask.pixel(0, v);
    const std::uint8_t* in = across.pixel(0, v - 2);
    const std::ptrdiff_t row = mask.width();
    for (std::ptrdiff_t u = 0; u < row; ++u) {
      out[u] += in[u] & in[u + row] & in[u + 2 * row] & in[u + 3 * row] & in[u + 4 * row];
    }
  }
  return mask;
}

// Binomial 3×3 over the pixels of the mask.
Image<float> smoothed(const Image<float>& values, const LabelImage& mask) {
  constexpr std::array<float, 3> kWeights = {1, 2, 1};
  Image<float> result(values.width(), values.height());
  const std::ptrdiff_t row = values.width();
  for (int v = 0; v < values.height(); ++v) {
    for (int u = 0; u < values.width(); ++u) {
      if (mask.at(u, v) == 0) continue;
      float sum = 0;
      float weights = 0;
      if (mask.at(u, v) == MaskArea::kInterior) { // all around is of the mask
        const float* above = values.pixel(u - 1, v - 1);
        for (std::size_t y = 0; y < 3; ++y, above += row) {
          for (std::size_t x = 0; x < 3; ++x) sum += kWeights[x] * kWeights[y] * above[x];
        }
        weights = 16;
      } else {
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) {
            if (!mask.contains(u + du, v + dv) || mask.at(u + du, v + dv) == 0) continue;
            const float w = (du == 0 ? 2.0F : 1.0F) * (dv == 0 ? 2.0F : 1.0F);
            sum += w * values.at(u + du, v + dv);
            weights += w;
          }
        }
      }
      result.at(u, v) = sum / weights;
    }
  }
  return result;
}

template <class T> Image<T> cut(const Image<T>& image, const Box& box) {
  Image<T> result(box.u1 - box.u0, box.v1 - box.v0);
  for (int v = 0; v < result.height(); ++v) {
    std::copy_n(image.pixel(box.u0, box.v0 + v), result.width(), result.pixel(0, v));
  }
  return result;
}

void check_sizes(const ingest::Frame& frame) {
  const Intrinsics& camera = frame.camera.intrinsics;
  const auto fits = [&camera](const auto& image) {
    return image.width() == camera.width && image.height() == camera.height;
  };
  if (!fits(frame.color) || !fits(frame.depth) || !fits(frame.clean_depth) ||
      (frame.has_labels() && !fits(frame.labels)) || frame.color.channels() < 3) {
    throw Error(ErrorCode::kFailure, "frame " + std::to_string(frame.index) +
                                         " has images of different sizes; colour, depth and labels must be registered");
  }
}

// Nothing is found if nobody has looked.
ingest::DetectedJoints cut_joints(const std::vector<ingest::DetectedPerson>& people, int label, const Box& box) {
  const auto person = std::find_if(people.begin(), people.end(), [&](const auto& p) { return p.label == label; });
  if (person == people.end()) return {};
  ingest::DetectedJoints joints = person->joints;
  for (ingest::DetectedJoint& joint : joints) joint.pixel -= Eigen::Vector2d(box.u0, box.v0);
  return joints;
}

void measure_depth(LayerView& view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int v = 0; v < view.mask.height(); ++v) {
    for (int u = 0; u < view.mask.width(); ++u) {
      if (view.planes.weights.at(u, v) <= 0) continue;
      sum += view.point(u, v);
      ++view.depth_pixels;
    }
  }
  if (view.depth_pixels > 0) view.centroid = sum / static_cast<double>(view.depth_pixels);
}

} // namespace

LayerView view_label(const ingest::Frame& frame, int label) {
  check_sizes(frame);
  LayerView view;
  if (!frame.has_labels()) return view;
  const Box tight = bounding_box(frame.labels, label);
  if (tight.empty()) return view;
  const Box box = grown(tight, frame.labels.width(), frame.labels.height());
  view.intrinsics = frame.camera.intrinsics;
  view.intrinsics.width = box.u1 - box.u0;
  view.intrinsics.height = box.v1 - box.v0;
  view.intrinsics.cx -= box.u0;
  view.intrinsics.cy -= box.v0;
  view.mask = cut_mask(frame.labels, label, box);
  view.depth = cut(frame.depth, box);
  view.joints = cut_joints(frame.people, label, box);
  const std::array<std::function<void()>, 3> parts = {
      [&] { view.to_silhouette = offsets_to_silhouette(cut(frame.labels, box)); }, // another label may hide this one
      [&] {
        view.texture = smoothed(log_luminance(frame.color, box.u0, box.v0, view.mask), view.mask);
        fill_outside(view.texture, view.mask);
        view.pyramid = texture_pyramid(view.texture, 1);
      },
      [&] {
        view.planes = fit_depth_planes(cut(frame.clean_depth, box), view.intrinsics, view.mask);
        measure_depth(view);
      }};
  parallel_for(parts.size(), 1, [&](const Chunk& chunk) { parts[chunk.begin](); });
  return view;
}

} // namespace kinora::tracking
