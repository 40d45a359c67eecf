// Fields that grow while the capture goes on: in turns each layer is trained a little more, with the key frames and the
// motion that are known by then.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "encode/layer_training.h"
#include "encode/live/key_frame_pool.h"
#include "encode/live/live_snapshot.h"

namespace kinora::encode {

struct LiveTrainingConfig {
  std::size_t first_rays = 24'000;        ///< of all layers together, in the first round: a picture is wanted soon
  std::size_t rays = 96'000;              ///< in every later one
  std::size_t pixels_per_frame = 100'000; ///< that are looked at
  double spare = 0.1;                     ///< of a box's side: room for surface that comes into view
};

/// Not thread-safe.
class LiveTrainer {
public:
  LiveTrainer(const EncodeOptions& options, const LiveTrainingConfig& config)
      : settings_(options.settings.fields), config_(config) {}

  /// Trains every layer that the frames show. A field whose layer is no longer in the space that it fills, or is
  /// deformed from another pose, is begun anew. Ends early when `progress` is cancelled; what was learnt before stays,
  /// and with the last snapshot those that must be begun anew are, with few rays.
  /// False if there is nothing to train.
  bool train(const LiveSnapshot& snapshot, const std::vector<KeyFrame>& frames, Progress& progress);

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
  void train_layer(const Share& share, const LiveSnapshot& snapshot, const fields::PixelStore& pixels,
                   Progress& progress);

  FieldSettings settings_;
  LiveTrainingConfig config_;
  std::map<int, LayerOutcome> outcomes_;
  StageTimes times_;
  std::size_t rounds_ = 0;
  std::size_t begun_anew_ = 0;
};

} // namespace kinora::encode
