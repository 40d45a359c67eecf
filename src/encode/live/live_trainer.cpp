#include "encode/live/live_trainer.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "encode/layer_report.h"
#include "fields/training/view_confidence.h"

namespace kinora::encode {
namespace {

/// How many of the stored pixels tell of a layer.
std::size_t measured_pixels(const fields::LayerObservations& layer) {
  std::size_t count = 0;
  for (const fields::StoredFrame& frame : layer.pixels.frames()) {
    if (layer.is_lost(frame)) continue;
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const fields::StoredPixel& pixel = layer.pixels.pixels()[i];
      if (layer.is_foreground(pixel) && pixel.depth.is_measured()) ++count;
    }
  }
  return count;
}

bool contains(const fields::FieldBox& outer, const fields::FieldBox& inner) {
  const auto low = inner.origin - outer.origin;
  const auto high = low + Eigen::Vector3d::Constant(inner.side - outer.side);
  return (low.array() >= 0).all() && (high.array() <= 0).all();
}

fields::FieldConfig with_spare_room(fields::FieldConfig config, double share) {
  const double spare = share * config.box.side;
  config.box.origin -= Eigen::Vector3d::Constant(spare / 2);
  config.box.side += spare;
  config.finest_resolution = std::min(static_cast<int>(config.finest_resolution * (1 + share)), 2048);
  return config;
}

/// Whether points of the motion's canonical space are where they were.
bool has_same_canonical_space(const motion::Motion& before, const motion::Motion& now) {
  constexpr double kSame = 1e-6; // metres
  const auto& old_graph = before.graph();
  const auto& graph = now.graph();
  if ((old_graph == nullptr) != (graph == nullptr)) return false;
  if (graph == nullptr) return true;
  if (graph->nodes().size() < old_graph->nodes().size()) return false;
  for (std::size_t i = 0; i < old_graph->nodes().size(); ++i) {
    if ((graph->nodes()[i] - old_graph->nodes()[i]).norm() > kSame) return false;
  }
  return true;
}

} // namespace

struct LiveTrainer::Share {
  int label;
  double part; ///< of all rays
};

double LiveTrainer::loss_of(int label) const {
  constexpr double kUntrained = 0.1, kLeast = 1e-3;
  const auto found = outcomes_.find(label);
  const double loss = found == outcomes_.end() ? kUntrained : found->second.training.final_loss;
  return loss > kLeast ? std::min(loss, 1.0) : kLeast; // also where it is not a number
}

fields::PixelStore LiveTrainer::pixels_of(const std::vector<KeyFrame>& frames, const LiveSnapshot& snapshot) {
  constexpr std::size_t kRemembered = 4; // rounds in which a frame is not asked for
  fields::PixelStore pixels(config_.pixels_per_frame * frames.size(), frames.size());
  for (const KeyFrame& key_frame : frames) {
    if (static_cast<std::size_t>(key_frame.number) >= snapshot.timeline.times.size()) continue; // not known yet
    const auto [stored, is_new] =
        stored_.try_emplace(key_frame.number, StoredKeyFrame{{config_.pixels_per_frame, 1}, rounds_});
    if (is_new) stored->second.pixels.add(*key_frame.frame, key_frame.number);
    stored->second.last_round = rounds_;
    pixels.add(stored->second.pixels);
  }
  std::erase_if(stored_, [&](const auto& entry) { return rounds_ - entry.second.last_round > kRemembered; });
  return pixels;
}

std::vector<LiveTrainer::Share> LiveTrainer::shares_of(const fields::PixelStore& pixels,
                                                       const LiveSnapshot& snapshot) const {
  std::vector<Share> shares;
  double sum = 0;
  for (const auto& [label, known] : snapshot.labels) {
    const std::size_t count = measured_pixels({pixels, label, known.motion});
    if (count == 0) continue;
    shares.push_back({label, std::sqrt(static_cast<double>(count)) * loss_of(label)});
    sum += shares.back().part;
  }
  for (Share& share : shares) share.part /= sum;
  return shares;
}

bool LiveTrainer::has_field_of(const LiveSnapshot& snapshot, int label) const {
  const auto found = outcomes_.find(label);
  return found != outcomes_.end() &&
         has_same_canonical_space(found->second.layer.motion, snapshot.labels.at(label).motion);
}

std::vector<LiveTrainer::Share> LiveTrainer::next_turn(const std::vector<Share>& shares, const LiveSnapshot& snapshot) {
  std::vector<Share> without_field;
  std::ranges::copy_if(shares, std::back_inserter(without_field),
                       [&](const Share& share) { return !has_field_of(snapshot, share.label); });
  if (!without_field.empty()) {
    double sum = 0;
    for (const Share& share : without_field) sum += share.part;
    for (Share& share : without_field) share.part /= sum;
    return without_field;
  }
  for (const Share& share : shares) owed_[share.label] += share.part;
  const auto most = std::ranges::max_element(shares, {}, [&](const Share& share) { return owed_[share.label]; });
  if (most == shares.end()) return {};
  owed_[most->label] -= 1;
  return {{most->label, 1}};
}

bool LiveTrainer::train(const LiveSnapshot& snapshot, const std::vector<KeyFrame>& frames, std::size_t rays,
                        Progress& progress) {
  const fields::PixelStore pixels = times_.measure("store pixels", [&] { return pixels_of(frames, snapshot); });
  const std::vector<Share> shares = shares_of(pixels, snapshot);
  train_layers(snapshot.is_last ? shares : next_turn(shares, snapshot), rays, snapshot, pixels, progress);
  return !shares.empty();
}

bool LiveTrainer::refine(const LiveSnapshot& snapshot, const std::vector<KeyFrame>& frames, std::size_t rays,
                         Progress& progress) {
  const fields::PixelStore pixels = times_.measure("store pixels", [&] { return pixels_of(frames, snapshot); });
  const std::vector<Share> shares = shares_of(pixels, snapshot);
  train_layers(shares, rays, snapshot, pixels, progress);
  return !shares.empty();
}

void LiveTrainer::train_layers(const std::vector<Share>& shares, std::size_t rays, const LiveSnapshot& snapshot,
                               const fields::PixelStore& pixels, Progress& progress) {
  for (const Share& share : shares) {
    times_.measure("train " + snapshot.labels.at(share.label).name, [&] {
      train_layer(share.label, static_cast<std::size_t>(share.part * static_cast<double>(rays)), snapshot, pixels,
                  progress);
    });
  }
  // What is not seen now has the motion that is known now, if its field is of that canonical space.
  for (auto entry = outcomes_.begin(); entry != outcomes_.end();) {
    const auto known = snapshot.labels.find(entry->first);
    const bool stays =
        known != snapshot.labels.end() && has_same_canonical_space(entry->second.layer.motion, known->second.motion);
    if (stays) entry->second.layer.motion = known->second.motion;
    entry = stays ? std::next(entry) : outcomes_.erase(entry);
  }
  ++rounds_;
}

void LiveTrainer::train_layer(int label, std::size_t rays, const LiveSnapshot& snapshot,
                              const fields::PixelStore& pixels, Progress& progress) {
  const LabelSnapshot& known = snapshot.labels.at(label);
  const auto found = outcomes_.find(label);
  const bool is_of_this_space = has_field_of(snapshot, label);
  const bool is_needed = snapshot.is_last && !is_of_this_space; // else the last clip would not have the layer
  if (progress.cancelled() && !is_needed) return;
  const fields::LayerObservations observations{pixels, label, known.motion};
  fields::FieldRequirements requirements;
  const fields::FieldConfig wanted = fields::choose_field_config(observations, &requirements);
  const bool goes_on = is_of_this_space && contains(found->second.config.box, wanted.box);
  if (found != outcomes_.end() && !goes_on) ++begun_anew_;
  LayerOutcome next;
  next.requirements = requirements;
  next.config = goes_on ? found->second.config : with_spare_room(wanted, config_.spare);
  next.trainer = settings_.trainer;
  next.trainer.rays = progress.cancelled() ? std::min(rays, config_.first_rays) : rays;
  next.trainer.seed += rounds_;
  next.trainer.rays_per_step = config_.rays_per_step;
  next.trainer.max_log2_table_size = 0; // tables stay as they are
  next.trainer.quantisation = {};       // and the next round goes on from them
  next.consistency = fields::measure_view_consistency(observations);
  fields::adapt_to(next.consistency, settings_.trainer, next.trainer);
  next.trainer.carve_free_space = false; // it is slow, and a later round may see otherwise
  next.trainer.empty_hidden_cells = snapshot.is_last;
  next.layer = {known.name, label, {}, known.motion, std::nullopt, std::nullopt};
  Progress to_the_end;
  try {
    next.layer.field = fields::train_field(observations, next.config, next.trainer, is_needed ? to_the_end : progress,
                                           &next.training, goes_on ? &found->second.layer.field : nullptr);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInterrupted) throw;
    return;
  }
  next.layer.confidence = fields::view_confidence(observations, next.layer.field);
  if (goes_on) {
    next.training.rays += found->second.training.rays;
    next.training.samples += found->second.training.samples;
    next.training.steps += found->second.training.steps;
  }
  outcomes_.insert_or_assign(label, std::move(next));
}

clip::Clip LiveTrainer::clip(const LiveSnapshot& snapshot) const {
  clip::Clip clip = snapshot.timeline;
  for (const auto& [label, outcome] : outcomes_) {
    clip.metadata["layers"][outcome.layer.name] = layer_metadata(outcome);
    clip.layers.push_back(outcome.layer);
    if (const auto known = snapshot.labels.find(label); known != snapshot.labels.end())
      clip.layers.back().joints = known->second.joints;
  }
  return clip;
}

} // namespace kinora::encode
