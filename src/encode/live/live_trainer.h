// Fields that grow while the capture goes on: layers take turns at being trained a little more, with the key frames and
// the motion that are known by then.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "encode/layer_training.h"
#include "encode/live/key_frame_pool.h"
#include "encode/live/live_snapshot.h"
#include "encode/live_settings.h"

namespace kinora::encode {

/// Not thread-safe.
class LiveTrainer {
public:
  explicit LiveTrainer(const EncodeOptions& options)
      : settings_(options.settings.fields), config_(options.settings.live.training) {}

  /// A round of so many rays for the layer whose turn it is: as often as many of its pixels are seen, and as badly they
  /// are drawn so far. Layers without a field come first, together; a field whose layer is no longer in the space that
  /// it fills, or is deformed from another pose, is begun anew. Ends early when `progress` is cancelled; what was
  /// learnt before stays. With the last snapshot all layers are trained, those that must be begun anew in any case,
  /// with few rays. False if there is nothing to train.
  bool train(const LiveSnapshot& snapshot, const std::vector<KeyFrame>& frames, std::size_t rays, Progress& progress);
  /// The same for all layers that the frames show, with so many rays in all.
  bool refine(const LiveSnapshot& snapshot, const std::vector<KeyFrame>& frames, std::size_t rays, Progress& progress);

  /// The clip as of the snapshot of the last call of train() or refine().
  clip::Clip clip(const LiveSnapshot& snapshot) const;

  /// Of the stages of each round.
  const StageTimes& times() const { return times_; }
  std::size_t rounds() const { return rounds_; }
  std::size_t begun_anew() const { return begun_anew_; }
  /// By label; without `why`, and without layer: clip() has it.
  const std::map<int, LayerOutcome>& outcomes() const { return outcomes_; }

private:
  struct Share; ///< of a round
  struct StoredKeyFrame {
    fields::PixelStore pixels;
    std::size_t last_round; ///< in which it was asked for
  };
  fields::PixelStore pixels_of(const std::vector<KeyFrame>& frames, const LiveSnapshot& snapshot);
  double loss_of(int label) const;
  std::vector<Share> shares_of(const fields::PixelStore& pixels, const LiveSnapshot& snapshot) const;
  std::vector<Share> next_turn(const std::vector<Share>& shares, const LiveSnapshot& snapshot);
  bool has_field_of(const LiveSnapshot& snapshot, int label) const; ///< and of the canonical space that is known now
  void train_layers(const std::vector<Share>& shares, std::size_t rays, const LiveSnapshot& snapshot,
                    const fields::PixelStore& pixels, Progress& progress);
  void train_layer(int label, std::size_t rays, const LiveSnapshot& snapshot, const fields::PixelStore& pixels,
                   Progress& progress);

  FieldSettings settings_;
  LiveTrainingConfig config_;
  std::map<int, LayerOutcome> outcomes_;
  std::map<int, StoredKeyFrame> stored_; ///< by number
  std::map<int, double> owed_;           ///< turns, by label
  StageTimes times_;
  std::size_t rounds_ = 0;
  std::size_t begun_anew_ = 0;
};

} // namespace kinora::encode
