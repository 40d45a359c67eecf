// Live encoding of a capture that runs forth and back, with everything tracked once, so that rules of training can be
// compared on the same motion; every tenth frame is looked at from one of the truth's cameras, the next one each time,
// as a viewer would while the performance goes on. All rules train as many rays: without refinement for the view that
// is asked for, those of the burst before each look are of all key frames.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "encode/live/key_frame_pool.h"
#include "encode/live/live_trainer.h"
#include "ingest/capture/capture.h"
#include "novel_look.h"

namespace kinora::bench {

struct LivePerformance {
  std::vector<std::shared_ptr<const ingest::Frame>> frames;
  std::vector<int> captured; ///< number of each in the capture
  std::map<int, encode::LiveSnapshot> snapshots;

  static constexpr int kFramesPerRound = 12; ///< what two cores train in 0.4 s
  static constexpr int kFramesPerLook = 10;
  static constexpr int kFirstLook = 30;
  static bool is_round(int frame) { return frame % kFramesPerRound == 0; }

  LivePerformance(ingest::Capture& capture, int count, const encode::EncodeOptions& options) {
    std::vector<std::shared_ptr<const ingest::Frame>> read;
    while (auto frame = capture.next()) read.push_back(std::make_shared<const ingest::Frame>(std::move(*frame)));
    const int length = static_cast<int>(read.size());
    Progress progress;
    encode::StageTimes times;
    encode::FrontEnd front_end(capture.info(), options, progress);
    for (int i = 0; i < count; ++i) {
      const int phase = length > 1 ? i % (2 * length - 2) : 0;
      const int number = phase < length ? phase : 2 * length - 2 - phase;
      auto frame = std::make_shared<ingest::Frame>(*read[static_cast<std::size_t>(number)]);
      frame->index = i;
      frame->time = i / capture.info().frames_per_second;
      front_end.add(*frame, false, times);
      frames.push_back(std::move(frame));
      captured.push_back(number);
      if (is_round(i) || number % kFramesPerLook == 0)
        snapshots.emplace(i, snapshot_of(front_end.timeline(), front_end.labels(), false));
    }
  }
};

/// One look: the clip as it is then, the frame of the performance, the camera and what it should see.
using Looking =
    std::function<void(const clip::Clip&, int frame, const evaluate::NovelCamera&, const evaluate::NovelView&)>;

/// From the second second on.
inline void train_live(const LivePerformance& performance, const evaluate::GroundTruth& truth,
                       const encode::EncodeOptions& options, bool refines, const Looking& look) {
  Progress progress;
  encode::KeyFramePool pool(options.settings.live.key_frames);
  encode::LiveTrainer trainer(options);
  const encode::LiveTrainingConfig& config = options.settings.live.training;
  std::size_t shown = 0, looks = 0;
  for (const auto& [last, snapshot] : performance.snapshots) {
    for (; shown <= static_cast<std::size_t>(last); ++shown)
      pool.add({static_cast<int>(shown), performance.frames[shown]}, snapshot);
    if (LivePerformance::is_round(last))
      trainer.train(snapshot, pool.frames(), last == 0 ? config.first_rays : config.rays, progress);
    if (last < LivePerformance::kFirstLook) continue;
    const evaluate::NovelCamera& camera = truth.novel_cameras()[looks % truth.novel_cameras().size()];
    const int number = performance.captured[static_cast<std::size_t>(last)];
    if (std::ranges::find(camera.frames, number) == camera.frames.end()) continue;
    ++looks;
    const std::vector<encode::KeyFrame> frames =
        refines ? pool.frames_for(camera.camera.camera_to_world, snapshot) : pool.frames();
    trainer.refine(snapshot, frames, config.view_rays, progress);
    look(trainer.clip(snapshot), last, camera, truth.novel_view(camera, number));
  }
}

} // namespace kinora::bench
