#include "evaluate/evaluate.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "evaluate/comparison.h"
#include "evaluate/ground_truth.h"
#include "evaluate/ground_truth_comparison.h"
#include "evaluate/picture_shift.h"
#include "evaluate/track_error.h"
#include "ingest/depth/registration_json.h"
#include "player/as_recorded.h"

namespace kinora::evaluate {
namespace {

using Json = nlohmann::json;
using namespace nlohmann::literals;

/// A subject's means over the two groups of frames.
struct Groups {
  Subject subject;
  Means held_out;
  Means trained;

  Json json() const {
    Json out = {
        {"name", subject.name}, {"region", subject.region}, {"held_out", held_out.json()}, {"trained", trained.json()}};
    const auto a = trained.mean("psnr");
    const auto b = held_out.mean("psnr");
    if (a && b) out["trained_minus_held_out_db"] = std::round((*a - *b) * 1e4) / 1e4;
    return out;
  }
};

// One per layer that can be told from the others, then groups of layers where they say more.
std::vector<Groups> groups_of(const player::Player& player, bool masks, bool moving) {
  std::vector<Subject> subjects;
  const bool several = player.clip().layers.size() > 1;
  if (masks || !several) subjects = layer_subjects(player, masks);
  if (several) subjects.push_back(whole_subject(player, masks));
  if (auto foreground = foreground_subject(player); masks && several && foreground) {
    subjects.push_back(std::move(*foreground));
  }
  subjects.push_back(picture_subject(player));
  if (moving) {
    for (Subject& subject : moving_subjects(player)) subjects.push_back(std::move(subject));
  }
  std::vector<Groups> groups;
  groups.reserve(subjects.size());
  for (Subject& subject : subjects) groups.push_back({std::move(subject), {}, {}});
  return groups;
}

// Capture frame number -> clip frame, of those that are to be compared.
std::map<int, std::size_t> chosen_frames(const clip::Clip& clip, int max_trained) {
  std::map<int, std::size_t> chosen;
  for (const bool held_out : {false, true}) {
    std::vector<std::size_t> group;
    for (std::size_t i = 0; i < clip.times.size(); ++i) {
      if (clip.held_out[i] == held_out) group.push_back(i);
    }
    const std::size_t count =
        max_trained > 0 && !held_out ? std::min(group.size(), static_cast<std::size_t>(max_trained)) : group.size();
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = group[(2 * k + 1) * group.size() / (2 * count)];
      chosen[clip.capture_frames[i]] = i;
    }
  }
  return chosen;
}

void require_same_source(const clip::Clip& clip, const ingest::CaptureInfo& info) {
  if (clip.intrinsics.width == info.intrinsics.width && clip.intrinsics.height == info.intrinsics.height) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("the clip was made from {}x{} pictures, but this capture has {}x{}; compare a clip with the "
                          "capture it was made from",
                          clip.intrinsics.width, clip.intrinsics.height, info.intrinsics.width,
                          info.intrinsics.height));
}

} // namespace

Json evaluate(const player::Player& player, ingest::Capture& capture, const MovingPixels* moving,
              const EvaluateOptions& options, Progress& progress) {
  const clip::Clip& clip = player.clip();
  require_same_source(clip, capture.info());
  std::vector<Groups> groups = groups_of(player, capture.info().has_masks, moving != nullptr);
  PictureShift held_out_shift, trained_shift;
  const player::AsRecorded recorded(clip, {.exposure = true, .rolling_shutter = true});
  const std::map<int, std::size_t> chosen = chosen_frames(clip, options.max_trained_frames);
  progress.stage("comparing", chosen.size());
  std::size_t done = 0;
  while (done < chosen.size()) {
    auto frame = capture.next();
    if (!frame) break;
    const auto match = chosen.find(frame->index);
    if (match == chosen.end()) continue;
    if (moving != nullptr) frame->labels = moving->in(frame->color);
    const std::size_t i = match->second;
    std::map<std::vector<std::size_t>, fields::Picture> pictures; // of layers: several groups show the same ones
    for (const Groups& group : groups) {
      const auto [drawn, is_new] = pictures.try_emplace(group.subject.layers);
      if (!is_new) continue;
      progress.check();
      drawn->second =
          player.draw(clip.capture_camera(static_cast<double>(i)), static_cast<double>(i), group.subject.layers);
      recorded.apply_to(drawn->second, clip.intrinsics, i);
    }
    parallel_for(groups.size(), 1, [&](const Chunk& chunk) {
      Groups& group = groups[chunk.index];
      compare(pictures.at(group.subject.layers), *frame, group.subject,
              clip.held_out[i] ? group.held_out : group.trained);
    });
    (clip.held_out[i] ? held_out_shift : trained_shift).add(pictures.at(player.all_layers()).color, frame->color);
    progress.advance(++done, "");
  }
  if (done == 0) {
    throw Error(ErrorCode::kUsage, "the capture has none of the clip's frames; compare a clip with the capture it was "
                                   "made from");
  }
  Json report = {{"schema", "kinora.evaluation/1"}, {"frames_compared", done}, {"layers", Json::array()}};
  for (const Groups& group : groups) {
    if (group.subject.of_one_layer) {
      report["layers"].push_back(group.json());
    } else {
      report[group.subject.name] = group.json();
    }
  }
  report["picture"]["held_out"].update(held_out_shift.json());
  report["picture"]["trained"].update(trained_shift.json());
  return report;
}

Json evaluate_against(const std::filesystem::path& capture, const host::PluginTable& plugins,
                      const player::Player& player, const EvaluateOptions& options, Progress& progress) {
  ingest::CaptureOptions how;
  how.format = options.format;
  how.format_options = options.format_options;
  if (const Json& metadata = player.clip().metadata; metadata.contains("registration")) {
    how.registration = ingest::registration_from_json(metadata["registration"], "the clip's registration");
  }
  auto opened = ingest::Capture::open(plugins, capture, how, progress);
  std::optional<MovingPixels> moving;
  if (!opened->info().has_masks && player.clip().camera_to_world.size() == 1) {
    progress.stage("telling what moves", 0);
    moving = MovingPixels::of(*opened);
    opened = ingest::Capture::open(plugins, capture, how, progress);
  }
  Json report = evaluate(player, *opened, moving ? &*moving : nullptr, options, progress);
  if (!options.ground_truth) return report;
  if (const auto truth = GroundTruth::read(capture, player.clip().capture_camera(0).camera_to_world)) {
    report["ground_truth"] = compare_with_ground_truth(player, *truth, progress);
    report["ground_truth"]["tracks"] = track_error(player.clip(), read_ground_truth_tracks(capture));
  }
  return report;
}

} // namespace kinora::evaluate
