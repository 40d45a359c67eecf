#include "ingest/segmentation/frame_labelling.h"

#include <fmt/format.h>

#include "core/parallel.h"
#include "ingest/images/grab_cut.h"
#include "ingest/images/optical_flow.h"
#include "ingest/images/picture_change.h"
#include "ingest/segmentation/flat_faces.h"

namespace kinora::ingest {
namespace {

constexpr std::uint8_t kPerson = 1;
constexpr int kSharpened = 4; ///< pixels to both sides of a border
constexpr std::size_t kRowsPerChunk = 16;
constexpr float kImpossible = -100;
constexpr float kMinScore = 0.3F;
constexpr float kOfLast = 2.5F;  ///< score of a pixel whose neighbourhood had the label before
constexpr float kOfFace = 2;     ///< … that lies on a flat face
constexpr float kOfRest = 1.5F;  ///< … where the thing lay
constexpr double kAtRest = 0.02; ///< metres
constexpr float kSameDepth = 0.06F;
constexpr float kMinLogRatio = 0.8F; ///< mean log ratio at which a lost thing is found again by colour alone
constexpr double kMinBody = 0.02;    ///< square metres: less is no person, unless it hangs on one
constexpr double kNearBody = 0.15;   ///< metres
constexpr double kReachOfBody = 0.4;
constexpr double kMinColorOverlap = 0.35; ///< overlap of the colours of a face and of the thing it belongs to
constexpr double kBesideFace = 0.03;      ///< metres
constexpr int kFaceMargin = 6;            ///< pixels around a face that may be the thing's other sides
constexpr int kOtherColor = 20;           ///< of 255

} // namespace

enum class FaceArea : std::uint8_t { kElsewhere, kBeside, kOn };

namespace {

template <class Body> void for_rows(int height, const Body& body) {
  parallel_for(static_cast<std::size_t>(height), kRowsPerChunk, [&](const Chunk& rows) {
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v) body(v);
  });
}

/// 1 where a pixel or one beside it is labelled: elsewhere there is nothing to decide.
Mask near_labels(const LabelImage& labels) {
  Mask near(labels.width(), labels.height());
  for (int v = 0; v < labels.height(); ++v) {
    for (int u = 0; u < labels.width(); ++u) {
      if (labels.at(u, v) == 0) continue;
      for (int y = std::max(0, v - 1); y <= std::min(labels.height() - 1, v + 1); ++y)
        for (int x = std::max(0, u - 1); x <= std::min(labels.width() - 1, u + 1); ++x) near.at(x, y) = 1;
    }
  }
  return near;
}

/// The label that most of the labelled neighbours within `radius` have; 0 if fewer than a third are labelled.
std::uint8_t label_around(const LabelImage& labels, int u, int v, int radius) {
  int counts[256] = {};
  int seen = 0;
  for (int y = std::max(0, v - radius); y <= std::min(labels.height() - 1, v + radius); ++y) {
    for (int x = std::max(0, u - radius); x <= std::min(labels.width() - 1, u + radius); ++x) {
      ++counts[labels.at(x, y)];
      ++seen;
    }
  }
  if (3 * (seen - counts[0]) < seen) return 0;
  return static_cast<std::uint8_t>(std::max_element(counts + 1, counts + 256) - counts);
}

/// The flat faces that look like a thing.
Image<FaceArea> faces_of(const HandledObject& object, const ReducedView& view, const Mask& faces) {
  const SurfaceComponents pieces = surface_components(view.depth, faces, view.intrinsics);
  std::vector<ColorCounts> counts(pieces.list.size());
  std::vector<ColorModel> colors;
  for (std::size_t i = 0; i < faces.pixel_count(); ++i)
    if (pieces.map.data()[i] >= 0)
      counts[static_cast<std::size_t>(pieces.map.data()[i])].add(&view.color.data()[3 * i]);
  int best = -1;
  double best_score = 0;
  for (std::size_t n = 0; n < counts.size(); ++n) {
    colors.push_back(counts[n].model());
    const double overlap = colors[n].overlap(object.color);
    const double score = overlap * std::min(pieces.list[n].area, object.area);
    if (overlap < kMinColorOverlap || score <= best_score) continue;
    best_score = score;
    best = static_cast<int>(n);
  }
  Image<FaceArea> result(faces.width(), faces.height());
  if (best < 0) return result;
  const SurfaceComponent& main = pieces.list[static_cast<std::size_t>(best)];
  for (int v = 0; v < faces.height(); ++v) {
    for (int u = 0; u < faces.width(); ++u) {
      const std::int32_t number = pieces.map.at(u, v);
      if (number < 0) continue;
      const SurfaceComponent& piece = pieces.list[static_cast<std::size_t>(number)];
      const bool beside = colors[static_cast<std::size_t>(number)].overlap(object.color) > kMinColorOverlap &&
                          piece.box.exteriorDistance(main.box) < kBesideFace;
      if (number != best && !beside) continue;
      for (int y = std::max(0, v - kFaceMargin); y <= std::min(faces.height() - 1, v + kFaceMargin); ++y)
        for (int x = std::max(0, u - kFaceMargin); x <= std::min(faces.width() - 1, u + kFaceMargin); ++x)
          if (result.at(x, y) == FaceArea::kElsewhere) result.at(x, y) = FaceArea::kBeside;
      result.at(u, v) = FaceArea::kOn;
    }
  }
  return result;
}

/// Pieces of the foreground before which the background's texture is seen.
void drop_unchanged(const ReducedView& view, const LocalBackground& background, Mask& foreground) {
  const SurfaceComponents parts = surface_components(view.depth, foreground, view.intrinsics);
  std::vector<PictureChange> pictures(parts.list.size());
  const auto for_each = [&](const auto& use) {
    for (int v = 0; v < foreground.height(); ++v)
      for (int u = 0; u < foreground.width(); ++u)
        if (const std::int32_t number = parts.map.at(u, v); number >= 0)
          use(u, v, pictures[static_cast<std::size_t>(number)]);
  };
  for_each([&](int u, int v, PictureChange& picture) {
    if (!has_texture(view.color, u, v)) return;
    const auto change = background.color_difference(u, v, view.color.pixel(u, v));
    picture.add(!change || *change > kColorChange);
  });
  for_each([&](int u, int v, const PictureChange& picture) {
    if (picture.denies()) foreground.at(u, v) = 0;
  });
}

/// Whether the surface at a pixel is where the thing last lay.
bool is_at_rest(const HandledObject& object, const ReducedView& view, int u, int v) {
  const Eigen::Vector3d point = view.camera_to_world * view.intrinsics.unproject(u, v, view.depth.at(u, v));
  for (std::size_t i = object.resting_views.size(); i-- > 0;) {
    const RestingView& rest = object.resting_views[i];
    const auto seen = project_point(rest.camera.intrinsics, rest.camera.camera_to_world.inverse() * point);
    if (!seen || !(rest.depth.at(seen->u, seen->v) > 0)) continue;
    return std::abs(rest.depth.at(seen->u, seen->v) - seen->z) < kAtRest;
  }
  return false;
}

} // namespace

LabelInfo background_label() { return {"background", "still", "what keeps still, and planes that it lies on"}; }

FrameLabelling::FrameLabelling(std::unique_ptr<BackgroundMap> background, SceneObjects objects, std::size_t samples,
                               LabellingEffort effort)
    : background_(std::move(background)), objects_(std::move(objects)), samples_(samples), effort_(effort),
      lost_(objects_.objects.size(), true) {}

std::map<int, LabelInfo> FrameLabelling::labels() const {
  std::map<int, LabelInfo> labels = {
      {0, background_label()},
      {kPerson, {"person", "deforming", "what moves before the background, without the things it handles"}}};
  int label = kPerson;
  for (const HandledObject& object : objects_.objects) {
    ++label;
    const std::string name = label == 2 ? "object" : fmt::format("object{}", label - 1);
    if (object.flat)
      labels[label] = {name, "rigid", "flat faces, of other colours than the one who holds it, are seen all along"};
    else if (object.is_flexible)
      labels[label] = {name, "deforming",
                       "it lay alone, was touched or moved, and has no flat faces that would keep their shape"};
    else
      labels[label] = {name, "rigid", "it lay alone, was touched or moved, and has flat faces"};
  }
  return labels;
}

void FrameLabelling::label(Frame& frame) {
  const int factor = reduction_factor(frame.depth.width());
  const ReducedView view = reduced_view(frame, factor);
  const LocalBackground background(*background_, view);
  Mask foreground = foreground_mask(view, background);
  drop_unchanged(view, background, foreground);
  warp_last_labels(view);
  LabelImage labels = label_objects(view, foreground);
  label_persons(view, foreground, labels);
  last_labels_ = labels;
  last_depth_ = view.depth;
  last_color_ = view.color;
  fill_unmeasured(view, background, labels);
  frame.labels = at_full_size(frame, factor, view, background, labels);
  if (effort_ == LabellingEffort::kFull) sharpen_borders(frame.color, kSharpened, frame.labels);
}

void FrameLabelling::mark_foreground(Frame& frame) const {
  const int factor = reduction_factor(frame.depth.width());
  const ReducedView view = reduced_view(frame, factor);
  const Mask foreground = foreground_mask(view, LocalBackground(*background_, view));
  frame.labels = LabelImage(frame.depth.width(), frame.depth.height());
  for_rows(frame.labels.height(), [&](int v) {
    const int y = std::min(v / factor, foreground.height() - 1);
    for (int u = 0; u < frame.labels.width(); ++u)
      frame.labels.at(u, v) = foreground.at(std::min(u / factor, foreground.width() - 1), y);
  });
}

/// What is known of the last frame moves with the picture.
void FrameLabelling::warp_last_labels(const ReducedView& view) {
  if (last_labels_.empty() || objects_.objects.empty() || effort_ != LabellingEffort::kFull) return;
  const Image<float> flow = optical_flow(view.color, last_color_);
  last_labels_ = warped(last_labels_, flow);
  last_depth_ = warped(last_depth_, flow);
}

/// How much likelier each foreground pixel is the thing than the rest, by colour around it, by where the thing was and
/// by shape.
void FrameLabelling::score_object(std::size_t object, const ReducedView& view, const Mask& foreground,
                                  const Image<FaceArea>& faces, Scores& scores) const {
  const HandledObject& model = objects_.objects[object];
  const int width = view.depth.width();
  const int height = view.depth.height();
  Image<float> ratio(width, height);
  for (std::size_t i = 0; i < ratio.pixel_count(); ++i)
    if (foreground.data()[i] != 0)
      ratio.data()[i] =
          std::clamp(model.color.log_ratio(objects_.others, &view.color.data()[3 * i]) + (model.flat ? 0 : model.prior),
                     -3.0F, 3.0F);
  const auto label = static_cast<std::uint8_t>(object + 2);
  for_rows(height, [&](int v) {
    for (int u = 0; u < width; ++u) {
      scores.at(u, v) = kImpossible;
      if (foreground.at(u, v) == 0) continue;
      const float z = view.depth.at(u, v);
      float color = 0;
      float around = 0, before = 0;
      for (int y = std::max(0, v - 2); y <= std::min(height - 1, v + 2); ++y) {
        for (int x = std::max(0, u - 2); x <= std::min(width - 1, u + 2); ++x) {
          if (foreground.at(x, y) == 0 || std::abs(view.depth.at(x, y) - z) > kSameDepth) continue;
          color += ratio.at(x, y);
          ++around;
          if (!last_labels_.empty() && last_labels_.at(x, y) == label &&
              std::abs(last_depth_.at(x, y) - z) < kSameDepth)
            ++before;
        }
      }
      color /= around;
      float support = 0;
      bool possible = lost_[object] && color > kMinLogRatio;
      if (before > 0) {
        support += kOfLast * (before / around - 0.3F);
        possible = true;
      } else if (!lost_[object]) {
        support -= 0.5F;
      }
      if (model.flat) {
        possible = faces.at(u, v) != FaceArea::kElsewhere;
        if (faces.at(u, v) == FaceArea::kOn) support += kOfFace;
      }
      if (is_at_rest(model, view, u, v)) {
        support += kOfRest;
        possible = true;
      }
      if (possible) scores.at(u, v) = color + support;
    }
  });
}

LabelImage FrameLabelling::label_objects(const ReducedView& view, const Mask& foreground) {
  LabelImage labels(view.depth.width(), view.depth.height());
  if (objects_.objects.empty()) return labels;
  const bool any_flat =
      std::any_of(objects_.objects.begin(), objects_.objects.end(), [](const auto& t) { return t.flat; });
  const Mask faces =
      any_flat ? flat_faces(view.depth, foreground, view.intrinsics) : Mask(view.depth.width(), view.depth.height());
  Scores best(view.depth.width(), view.depth.height(), 1, kMinScore);
  Scores scores(view.depth.width(), view.depth.height());
  for (std::size_t object = 0; object < objects_.objects.size(); ++object) {
    const HandledObject& model = objects_.objects[object];
    score_object(object, view, foreground, model.flat ? faces_of(model, view, faces) : Image<FaceArea>(), scores);
    for (std::size_t i = 0; i < best.pixel_count(); ++i) {
      if (scores.data()[i] <= best.data()[i]) continue;
      best.data()[i] = scores.data()[i];
      labels.data()[i] = static_cast<std::uint8_t>(object + 2);
    }
  }
  clean_objects(view, labels);
  return labels;
}

/// Of each thing stay the largest piece and those not much smaller; a thing of which little is left is lost.
void FrameLabelling::clean_objects(const ReducedView& view, LabelImage& labels) {
  for (std::size_t object = 0; object < objects_.objects.size(); ++object) {
    const auto label = static_cast<std::uint8_t>(object + 2);
    Mask mask(labels.width(), labels.height());
    for (std::size_t i = 0; i < mask.pixel_count(); ++i) mask.data()[i] = labels.data()[i] == label ? 1 : 0;
    const SurfaceComponents pieces = surface_components(view.depth, mask, view.intrinsics);
    const int largest = pieces.largest();
    double area = 0;
    for (const SurfaceComponent& piece : pieces.list) area = std::max(area, piece.area);
    lost_[object] = largest < 0 || area < 0.15 * objects_.objects[object].area;
    for (std::size_t i = 0; i < mask.pixel_count(); ++i) {
      if (mask.data()[i] == 0) continue;
      const SurfaceComponent& piece = pieces.list[static_cast<std::size_t>(pieces.map.data()[i])];
      if (lost_[object] || piece.area < 0.2 * area) labels.data()[i] = 0;
    }
  }
}

/// Foreground that is no thing is a person if there is enough of it, or if it is close to one.
void FrameLabelling::label_persons(const ReducedView& view, const Mask& foreground, LabelImage& labels) const {
  Mask rest = foreground;
  for (std::size_t i = 0; i < rest.pixel_count(); ++i)
    if (labels.data()[i] != 0) rest.data()[i] = 0;
  const SurfaceComponents parts = surface_components(view.depth, rest, view.intrinsics);
  const int largest = parts.largest();
  if (largest < 0) return;
  const SurfaceComponent& body = parts.list[static_cast<std::size_t>(largest)];
  if (body.area < kMinBody) return;
  std::vector<bool> person(parts.list.size());
  for (std::size_t n = 0; n < parts.list.size(); ++n) {
    const SurfaceComponent& part = parts.list[n];
    const bool near = part.box.exteriorDistance(body.box) < kNearBody && part.area > 0.05 * kMinBody;
    // Of a pair of frames little is known: what is far from the body may be furniture.
    const bool large =
        part.area >= kMinBody && (samples_ >= kFewSamples || part.box.exteriorDistance(body.box) < kReachOfBody);
    person[n] = near || large;
  }
  for (std::size_t i = 0; i < rest.pixel_count(); ++i)
    if (parts.map.data()[i] >= 0 && person[static_cast<std::size_t>(parts.map.data()[i])]) labels.data()[i] = kPerson;
}

/// Pixels without depth beside a labelled one follow it where they do not look like the background.
void FrameLabelling::fill_unmeasured(const ReducedView& view, const LocalBackground& background, LabelImage& labels) {
  for (int round = 0; round < 3; ++round) {
    const LabelImage before = labels;
    const Mask near = near_labels(before);
    for_rows(labels.height(), [&](int v) {
      for (int u = 0; u < labels.width(); ++u) {
        if (near.at(u, v) == 0 || view.depth.at(u, v) > 0 || before.at(u, v) != 0) continue;
        const auto change = background.color_difference(u, v, view.color.pixel(u, v));
        if (!change || *change > kOtherColor) labels.at(u, v) = label_around(before, u, v, 1);
      }
    });
  }
}

LabelImage FrameLabelling::at_full_size(const Frame& frame, int factor, const ReducedView& view,
                                        const LocalBackground& background, const LabelImage& small) {
  if (factor == 1) return small;
  const Intrinsics& intrinsics = frame.camera.intrinsics;
  LabelImage labels(intrinsics.width, intrinsics.height);
  const Mask near = near_labels(small);
  for_rows(labels.height(), [&](int v) {
    for (int u = 0; u < labels.width(); ++u) {
      const int x = std::min(u / factor, small.width() - 1);
      const int y = std::min(v / factor, small.height() - 1);
      if (near.at(x, y) == 0) continue;
      const float z = frame.depth.at(u, v);
      if (z <= 0) {
        const auto change = background.color_difference(x, y, frame.color.pixel(u, v));
        std::uint8_t label = small.at(x, y);
        if (label == 0) label = label_around(small, x, y, 1);
        if (!change ? small.at(x, y) != 0 : *change > kOtherColor) labels.at(u, v) = label;
        continue;
      }
      if (background.ground_of(intrinsics.unproject(u, v, z)) != Ground::kForeground) continue;
      float nearest = std::numeric_limits<float>::infinity();
      for (int j = std::max(0, y - 1); j <= std::min(small.height() - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(small.width() - 1, x + 1); ++i) {
          if (view.depth.at(i, j) <= 0) continue;
          const float off = std::abs(view.depth.at(i, j) - z) + (i == x && j == y ? 0.0F : 0.01F);
          if (off >= nearest) continue;
          nearest = off;
          labels.at(u, v) = small.at(i, j);
        }
      }
    }
  });
  return labels;
}

} // namespace kinora::ingest
