// A clip that can be looked at: any frame or time, any camera, any of its layers.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "clip/layer_choice.h"
#include "fields/rendering/renderer.h"
#include "player/backdrops.h"

namespace kinora::player {

using clip::LayerChoice;

/// Samples along each side of a pixel (DrawOptions) with which a picture shows no less than the capture's pixels would,
/// averaged: 1 unless it is smaller than the capture.
int samples_per_side(const Intrinsics& picture, const Intrinsics& capture);

/// How much is made ready before a clip can be seen.
enum class Readiness {
  kWhole,
  kFirstLook ///< several times sooner, and coarser: for the first picture, until the whole is ready
};

/// Holds the clip and, for each layer, the field in the form in which it is drawn. Immutable; may be shared by threads.
/// What a camera that draws again and again sees of layers that stay where they are is drawn once: no picture differs.
class Player {
public:
  explicit Player(clip::Clip clip, Readiness readiness = Readiness::kWhole);

  const clip::Clip& clip() const { return clip_; }
  Readiness readiness() const { return readiness_; }
  std::size_t frame_count() const { return clip_.times.size(); }

  LayerChoice all_layers() const { return clip::all_layers(clip_); }
  std::optional<std::size_t> layer_with_label(int label) const;

  /// The layers as they are at a whole or fractional frame (clamped to the clip), seen from `camera`. A layer is drawn
  /// only when it is there (clip/shown_frames.h); one that is lost later stays where it was last. Pictures smaller than
  /// the capture get the samples that they need; `options.samples` is not looked at.
  fields::Picture draw(const Camera& camera, double frame, const LayerChoice& layers,
                       const fields::DrawOptions& options = {}) const;
  /// The same with one sample for each pixel, whatever the capture's were: what is seen while something moves.
  fields::Picture preview(const Camera& camera, double frame, const LayerChoice& layers,
                          const fields::DrawOptions& options = {}) const;
  /// As draw(), at a time in seconds from the start.
  fields::Picture draw_at(const Camera& camera, double seconds, const LayerChoice& layers,
                          const fields::DrawOptions& options = {}) const {
    return draw(camera, clip_.frame_at(seconds), layers, options);
  }

  /// Those of the layers that are there at that frame: what is drawn, in the order of Picture::front.
  LayerChoice drawn_layers(double frame, const LayerChoice& layers) const;

  /// How well each layer that is drawn was tracked at that frame, in the order of Picture::front. A fraction of a frame
  /// counts as the one before it.
  std::vector<motion::Health> drawn_health(double frame, const LayerChoice& layers) const;

  /// Centre of what a layer's occupancy fills, in world coordinates at a frame; nothing if it fills nothing, or nothing
  /// of it is there then.
  std::optional<Eigen::Vector3d> centre_of(std::size_t layer, double frame) const;

  /// The layers that are drawn, as they are at a frame: for a renderer of one's own (player/gl).
  std::vector<fields::PosedField> posed_layers(double frame, const LayerChoice& layers) const;

private:
  fields::Picture drawn(const Camera& camera, double frame, const LayerChoice& layers,
                        const fields::DrawOptions& options) const;
  bool is_drawn(std::size_t layer, double frame) const { return shown_.at(layer).at(clamped(frame)); }
  double clamped(double frame) const;
  fields::PosedField posed(std::size_t layer, double frame) const;

  clip::Clip clip_;
  Readiness readiness_;
  std::vector<std::unique_ptr<fields::DrawableField>> drawables_;
  struct Centre {
    std::once_flag found;
    std::optional<Eigen::Vector3d> canonical; ///< metres
  };
  mutable std::deque<Centre> centres_; ///< by layer; each found when it is first asked for
  std::vector<motion::Presence> shown_;
  /// Of a layer that deforms, the last frame that was drawn: from other cameras it is often drawn again.
  struct LastPosed {
    double frame;
    fields::PosedField posed;
  };
  mutable std::mutex last_posed_mutex_;
  mutable std::map<std::size_t, LastPosed> last_posed_; ///< by layer
  mutable Backdrops backdrops_;
};

} // namespace kinora::player
