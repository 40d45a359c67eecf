#include "player/player.h"

#include <algorithm>

#include "clip/shown_frames.h"

namespace kinora::player {
namespace {

std::optional<Eigen::Vector3d> occupied_centre(const fields::Field& field) {
  const int n = field.occupancy.resolution();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  fields::for_each_occupied(field.occupancy, [&](int x, int y, int z) {
    sum += Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
    ++count;
  });
  if (count == 0) return std::nullopt;
  return field.config.box.origin + sum * (field.config.box.side / (static_cast<double>(count) * n));
}

} // namespace

int samples_per_side(const Intrinsics& picture, const Intrinsics& capture) {
  constexpr double kCoarser = 1.2; // than the capture's pixels: shows no difference yet
  int samples = 1;
  while (samples < fields::DrawOptions::kMaxSamples && kCoarser * samples * picture.fx < capture.fx) samples *= 2;
  return samples;
}

Player::Player(clip::Clip clip, Readiness readiness) : clip_(std::move(clip)), readiness_(readiness) {
  const auto detail = readiness == Readiness::kWhole ? fields::BrickDetail::kWhole : fields::BrickDetail::kHalf;
  for (const clip::Layer& layer : clip_.layers) {
    const std::shared_ptr<const fields::Field> held_by_the_clip(std::shared_ptr<const void>(), &layer.field);
    drawables_.push_back(std::make_unique<fields::DrawableField>(held_by_the_clip, layer.motion.graph().get(),
                                                                 layer.confidence, detail));
    centres_.emplace_back();
    shown_.push_back(clip::shown_frames(layer, clip_.times.size()));
  }
}

std::optional<std::size_t> Player::layer_with_label(int label) const {
  for (std::size_t i = 0; i < clip_.layers.size(); ++i) {
    if (clip_.layers[i].label == label) return i;
  }
  return std::nullopt;
}

fields::PosedField Player::posed(std::size_t layer, double frame) const {
  const motion::Motion& motion = clip_.layers[layer].motion;
  if (motion.kind() != motion::MotionKind::kDeforming) return fields::pose(*drawables_.at(layer), motion.warp(frame));
  const std::lock_guard lock(last_posed_mutex_);
  const auto known = last_posed_.find(layer);
  if (known != last_posed_.end() && known->second.frame == frame) return known->second.posed;
  fields::PosedField posed =
      fields::pose(*drawables_.at(layer), motion.warp(frame), clip_.layers[layer].births.unborn(clamped(frame)));
  last_posed_.insert_or_assign(layer, LastPosed{frame, posed});
  return posed;
}

double Player::clamped(double frame) const {
  return frame > 0 ? std::min(frame, static_cast<double>(frame_count() - 1)) : 0; // NaN goes to the first frame
}

LayerChoice Player::drawn_layers(double frame, const LayerChoice& layers) const {
  LayerChoice drawn;
  for (const std::size_t i : layers) {
    if (is_drawn(i, frame)) drawn.push_back(i);
  }
  return drawn;
}

std::vector<fields::PosedField> Player::posed_layers(double frame, const LayerChoice& layers) const {
  std::vector<fields::PosedField> posed;
  for (const std::size_t i : drawn_layers(frame, layers)) posed.push_back(this->posed(i, frame));
  return posed;
}

fields::Picture Player::draw(const Camera& camera, double frame, const LayerChoice& layers,
                             const fields::DrawOptions& options) const {
  fields::DrawOptions wanted = options;
  wanted.samples = samples_per_side(camera.intrinsics, clip_.intrinsics);
  return drawn(camera, frame, layers, wanted);
}

fields::Picture Player::preview(const Camera& camera, double frame, const LayerChoice& layers,
                                const fields::DrawOptions& options) const {
  fields::DrawOptions wanted = options;
  wanted.samples = 1;
  return drawn(camera, frame, layers, wanted);
}

fields::Picture Player::drawn(const Camera& camera, double frame, const LayerChoice& layers,
                              const fields::DrawOptions& options) const {
  const LayerChoice shown = drawn_layers(frame, layers);
  std::vector<fields::PosedField> all, still;
  StillView view{camera, options, {}};
  fields::Backdrop backdrop;
  for (const std::size_t i : shown) {
    all.push_back(posed(i, frame));
    if (clip_.layers[i].motion.kind() != motion::MotionKind::kStill) continue;
    still.push_back(all.back());
    view.layers.push_back(i);
    backdrop.layers.push_back(static_cast<std::uint8_t>(all.size() - 1));
  }
  if (still.empty() || options.quality == fields::DrawQuality::kFast) return fields::render(all, camera, options);
  const auto picture = backdrops_.picture_of(view, [&] { return fields::render(still, camera, options); });
  backdrop.picture = picture.get();
  return fields::render(all, camera, options, picture != nullptr ? &backdrop : nullptr);
}

std::vector<motion::Health> Player::drawn_health(double frame, const LayerChoice& layers) const {
  const auto whole = static_cast<std::size_t>(clamped(frame));
  std::vector<motion::Health> health;
  for (const std::size_t i : drawn_layers(frame, layers)) health.push_back(clip_.layers[i].motion.health(whole));
  return health;
}

std::optional<Eigen::Vector3d> Player::centre_of(std::size_t layer, double frame) const {
  Centre& known = centres_.at(layer);
  std::call_once(known.found, [&] { known.canonical = occupied_centre(clip_.layers[layer].field); });
  const std::optional<Eigen::Vector3d>& centre = known.canonical;
  if (!centre || !is_drawn(layer, frame)) return std::nullopt;
  const motion::Warp warp = clip_.layers[layer].motion.warp(frame);
  if (warp.is_rigid()) return warp.rigid() * *centre;
  // No node need be near the centre of what bends.
  const motion::UnbornNodes unborn = clip_.layers[layer].births.unborn(clamped(frame));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (std::size_t n = 0; n < warp.node_positions().size(); ++n) {
    if (!unborn.empty() && unborn[n]) continue;
    sum += warp.node_positions()[n];
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Eigen::Vector3d(sum / count);
}

} // namespace kinora::player
