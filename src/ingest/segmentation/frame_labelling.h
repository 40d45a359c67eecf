// The second pass: labels one frame after another with what was learnt about the scene.
#pragma once

#include <map>
#include <memory>

#include "ingest/capture/capture.h"
#include "ingest/segmentation/handled_objects.h"

namespace kinora::ingest {

/// How a pixel lies to the flat faces that look like a thing.
enum class FaceArea : std::uint8_t;

/// What a frame's labels are worth in time.
enum class LabellingEffort : std::uint8_t {
  kFull, ///< the last labels move with the picture, and borders are cut by colour
  kLive  ///< neither: a fraction of the time
};

/// Label 0 of a scene in which nothing is told apart.
LabelInfo background_label();

/// Keeps the labels of the last frame, which are the prior of the next. Not thread-safe.
class FrameLabelling {
public:
  /// `samples`: how many frames the background was made from.
  FrameLabelling(std::unique_ptr<BackgroundMap> background, SceneObjects objects, std::size_t samples,
                 LabellingEffort effort = LabellingEffort::kFull);

  /// 0 background, 1 person, 2… the things.
  std::map<int, LabelInfo> labels() const;
  const SceneObjects& objects() const { return objects_; }

  /// Fills in `frame.labels`: 0 background, 1 person, 2… the things in their order.
  void label(Frame& frame);
  /// Only what is in front of the background, as label 1 in whole pixels of the view; as if the frame came alone.
  void mark_foreground(Frame& frame) const;

private:
  void warp_last_labels(const ReducedView& view);

  using Scores = Image<float>;

  void score_object(std::size_t object, const ReducedView& view, const Mask& foreground, const Image<FaceArea>& faces,
                    Scores& scores) const;
  LabelImage label_objects(const ReducedView& view, const Mask& foreground);
  void clean_objects(const ReducedView& view, LabelImage& labels);
  void label_persons(const ReducedView& view, const Mask& foreground, LabelImage& labels) const;
  static void fill_unmeasured(const ReducedView& view, const LocalBackground& background, LabelImage& labels);
  static LabelImage at_full_size(const Frame& frame, int factor, const ReducedView& view,
                                 const LocalBackground& background, const LabelImage& small);

  std::unique_ptr<BackgroundMap> background_;
  SceneObjects objects_;
  std::size_t samples_;
  LabellingEffort effort_;
  std::vector<bool> lost_; ///< by thing: not seen in the last frame
  LabelImage last_labels_;
  DepthImage last_depth_;
  ColorImage last_color_;
};

} // namespace kinora::ingest
