// One drawn picture against one true picture, layer by layer, and the means over many.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "ingest/frame/frame.h"
#include "player/player.h"

namespace kinora::evaluate {

/// Sums of named values over frames, for their means.
class Means {
public:
  void add(const std::string& name, double value);
  void add_frame() { ++frames_; }
  int frames() const { return frames_; }
  std::optional<double> mean(const std::string& name) const;
  /// Rounded to four digits after the point (depths are in metres: to a tenth of a millimetre); null if not finite.
  nlohmann::json json() const;

private:
  std::map<std::string, std::pair<double, int>> sums_;
  int frames_ = 0;
};

/// What is drawn and where it is compared: one layer alone, or all that is modelled.
struct Subject {
  std::string name;
  std::string region; ///< in words
  clip::LayerChoice layers;
  std::optional<std::set<int>> labels; ///< of the region's pixels; nothing: every pixel is in it
  bool measured_only = false;          ///< the region is cut to pixels with measured depth
  bool of_one_layer = false;
};

/// One for each layer.
std::vector<Subject> layer_subjects(const player::Player& player, bool masks);
/// All layers together: where masks tell which pixels are modelled, else everywhere.
Subject whole_subject(const player::Player& player, bool masks);
/// All layers together over every pixel of the picture, measured or not: what a person sees who opens the clip.
Subject picture_subject(const player::Player& player);
/// All layers together over moving and over still pixels: `moving` has label 1, `still` label 0.
std::vector<Subject> moving_subjects(const player::Player& player);

/// All labelled layers together against everything that is labelled, modelled or not; nothing if there is none.
std::optional<Subject> foreground_subject(const player::Player& player);

/// Adds the measures of evaluate.h to `means`; nothing if the frame shows nothing of the subject. Of the frame, only
/// colour, depth and labels are looked at.
void compare(const fields::Picture& picture, const ingest::Frame& frame, const Subject& subject, Means& means);

} // namespace kinora::evaluate
