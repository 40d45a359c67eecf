// Fields that grow while the capture goes on: in turns each layer is trained a little more, with the key frames and the
// motion that are known by then.
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

  /// Trains every layer that the frames show with so many rays in all. A field whose layer is no longer in the space
  /// that it fills, or is deformed from another pose, is begun anew. Ends early when `progress` is cancelled; what was
  /// learnt before stays, and with the last snapshot those that must be begun anew are, with few rays. False if there
  /// is nothing to train.
  bool train(const LiveSnapshot& snapshot, const std::vector<KeyFrame>& frames, std::size_t rays, Progress& progress);

  /// The clip as of the snapshot of the last call of train().
  clip::Clip clip(const LiveSnapshot& snapshot) const;

  /// Of the stages of each round.
  const StageTimes& times() const { return times_; }
  std::size_t rounds() const { return rounds_; }
  std::size_t begun_anew() const { return begun_anew_; }
  /// By label; without `why`, and without layer: clip() has it.
  const std::map<int, LayerOutcome>& outcomes() const { return outcomes_; }

private:
  struct Share; ///< of a round
  double loss_of(int label) const;
  void train_layer(int label, std::size_t rays, const LiveSnapshot& snapshot, const fields::PixelStore& pixels,
                   Progress& progress);

  FieldSettings settings_;
  LiveTrainingConfig config_;
  std::map<int, LayerOutcome> outcomes_;
  StageTimes times_;
  std::size_t rounds_ = 0;
  std::size_t begun_anew_ = 0;
};

} // namespace kinora::encode
