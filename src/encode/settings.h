// All that can be changed about how a capture becomes a clip: one tree of the plain structs that the rooms are set up
// with. It is written into every clip; `kinora encode --set` changes it (setting_list.h).
#pragma once

#include <cstddef>

#include "encode/live_settings.h"
#include "encode/motion_refinement.h"
#include "encode/pose_refinement.h"
#include "encode/setting_list.h"
#include "fields/training/trainer.h"
#include "ingest/capture/capture.h"
#include "tracking/camera/camera_tracker.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/rigid/rigid_tracker.h"

namespace kinora::encode {

struct IngestSettings {
  double max_depth = ingest::CaptureOptions().max_depth;
  ingest::DepthCleaning cleaning;
  bool masks_on_edges = true; ///< also labels from a network
};

struct TrackingSettings {
  tracking::CameraTrackerConfig camera;
  tracking::RigidTrackerConfig rigid;
  tracking::DeformingTrackerConfig deforming;
};

/// The trainer's rays are those of each layer; 0: what the budget allows. Tables end as a file stores them.
inline fields::TrainerConfig trainer_within_budget() {
  fields::TrainerConfig trainer;
  trainer.rays = 0;
  trainer.quantisation.begin = 0.75;
  return trainer;
}

struct FieldSettings {
  fields::TrainerConfig trainer = trainer_within_budget();
  MotionRefinementConfig refinement;
  PoseRefinementConfig poses; ///< of a moving camera
};

/// How much is trained; presets differ in this alone.
struct TrainingBudget {
  std::size_t max_stored_pixels = 24'000'000; ///< bound of what training remembers; 12 bytes each
  /// What a layer must gain, in dB, to be trained another second of a processor for each frame of the capture
  /// (fields::ExchangeRate); 0: as long as rays_per_pixel says.
  double decibels_per_second = 0;
  /// How often each stored pixel of a layer is looked at, at most. What deforms is followed less exactly than others
  /// are: more looks teach its field each frame's error, which rays held apart of the same frames do not tell.
  double rays_per_pixel = 40;
  double deforming_rays_per_pixel = 5;
  bool try_geometries = false; ///< whether each layer takes the geometry that draws it better (geometry_trial.h)
};

struct Settings {
  IngestSettings ingest;
  TrackingSettings tracking;
  FieldSettings fields;
  TrainingBudget budget;
  LiveSettings live; ///< of encoding live alone
};

/// Whose measures are known is told with them (EncodeOptions::body).
template <> inline constexpr bool kIsData<tracking::BodyPrior> = true;

/// `settings` must outlive the list.
SettingList list_settings(Settings& settings);
nlohmann::json settings_json(Settings settings);

/// Throws Error(kUsage), naming the setting, if one is zero that is divided by or without which nothing is left to do.
void check(Settings settings);

} // namespace kinora::encode
