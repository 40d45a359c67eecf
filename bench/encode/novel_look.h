// What a clip shows to a camera that the capture did not have, against the truth.
#pragma once

#include <map>
#include <string>

#include "evaluate/comparison.h"
#include "evaluate/ground_truth.h"
#include "player/player.h"

namespace kinora::bench {

/// Adds the measures of a frame of the clip: of each layer alone by its name, and of all labelled ones as "foreground".
inline void look(const player::Player& player, double clip_frame, const evaluate::NovelCamera& camera,
                 evaluate::NovelView truth, std::map<std::string, evaluate::Means>& means) {
  ingest::Frame frame;
  frame.camera = camera.camera;
  frame.color = std::move(truth.color);
  frame.depth = std::move(truth.depth);
  frame.labels = std::move(truth.mask);
  std::vector<evaluate::Subject> subjects = evaluate::layer_subjects(player, true);
  if (auto both = evaluate::foreground_subject(player)) subjects.push_back(std::move(*both));
  for (const evaluate::Subject& subject : subjects)
    evaluate::compare(player.draw(camera.camera, clip_frame, subject.layers), frame, subject, means[subject.name]);
}

} // namespace kinora::bench
