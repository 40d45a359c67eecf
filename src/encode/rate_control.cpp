#include "encode/rate_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "fields/rendering/renderer.h"

namespace kinora::encode {

namespace {

using clip::Rounding;

// From nothing to what cannot be told from the field itself; `up_from` fills the gaps between powers of two. All but
// the last also coarsen what was rounded before.
constexpr std::array<Rounding, 13> kLadder{{{0},
                                            {0.125, 0.6, true},
                                            {0.25, 0.6, true},
                                            {0.5, 0.7, true},
                                            {0.5, 0.55, true},
                                            {1, 0.7, true},
                                            {1, 0.55, true},
                                            {2, 0.7, true},
                                            {2, 0.55, true},
                                            {4, 0.7, true},
                                            {4, 0.55, true},
                                            {8, 0.5, true},
                                            {16, 0.5}}};
static_assert(kLadder[6].steps_per_rms == 1);
constexpr double kPeak = 255; // of pictures
constexpr std::size_t kNothing = 0;
// A step to the root mean square: drawn, as is nothing; errors of the others grow with those of the parameters. Where
// it changes nothing, as the level was rounded before, the next coarser one that does is drawn.
constexpr std::size_t kProbe = 6;

struct Choice {
  Rounding rounding;
  std::size_t bytes = 0;
  double error = 0; // of pictures, squared
};

// What can be chosen for one level of one layer: every next choice takes more bytes and leaves less of the error.
struct Unit {
  std::size_t layer = 0;
  std::vector<Choice> choices;
};

// A level of a layer, rounded and drawn in each way of the ladder.
struct Trial {
  std::size_t layer = 0;
  std::size_t level = 0;
  std::array<std::size_t, kLadder.size()> bytes{};
  std::array<double, kLadder.size()> parameter_errors{}; // squared
  double error_of_nothing = 0;                           // of pictures, squared
  double error_of_probe = 0;
  std::size_t probe = kNothing;

  bool is_shown() const { return error_of_nothing > 0; }
  /// Of pictures, for each of the parameters that the probe makes.
  double sensitivity() const {
    const double error = probe == kNothing ? error_of_nothing : error_of_probe;
    return parameter_errors[probe] > 0 ? error / parameter_errors[probe] : 0;
  }
};

double squared_error(std::span<const float> a, std::span<const float> b) {
  return std::transform_reduce(a.begin(), a.end(), b.begin(), 0.0, std::plus<>(),
                               [](double x, double y) { return (x - y) * (x - y); });
}

// Pictures of a clip with one of its fields replaced, against those of the clip itself.
class Pictures {
public:
  explicit Pictures(const clip::Clip& clip) : clip_(clip) {
    for (const clip::Layer& layer : clip.layers) drawables_.emplace_back(layer.field, layer.motion.graph().get());
    const auto last = static_cast<double>(clip.times.size() - 1);
    for (const double at : {0.25, 0.75}) {
      const double frame = std::round(at * last);
      for (const Camera& camera : {small(clip.capture_camera(frame)), beside_capture(frame)}) {
        views_.push_back({camera, frame, {}});
        views_.back().truth = draw(views_.back());
        drawn_values_ += 3 * shown_pixels(views_.back());
      }
    }
  }

  /// Of all pictures, where the clip itself shows something.
  std::size_t drawn_values() const { return drawn_values_; }

  double error_with(std::size_t layer, fields::Field field) {
    fields::DrawableField changed(std::move(field), clip_.layers[layer].motion.graph().get());
    std::swap(drawables_[layer], changed);
    double error = 0;
    for (const View& view : views_) error += squared_error(draw(view), view.truth);
    std::swap(drawables_[layer], changed);
    return error;
  }

private:
  struct View {
    Camera camera;
    double frame;
    std::vector<float> truth;
  };

  static Camera small(Camera camera) {
    constexpr int kWidth = 320;
    const Intrinsics& k = camera.intrinsics;
    const int width = std::min(kWidth, k.width);
    camera.intrinsics = k.resized(width, std::max(1, k.height * width / k.width));
    return camera;
  }

  Camera beside_capture(double frame) const {
    constexpr double kAngle = 25 * std::numbers::pi / 180;
    Camera camera = small(clip_.capture_camera(frame));
    const fields::Picture seen = fields::render(posed(frame), camera);
    std::vector<float> depths;
    std::ranges::copy_if(seen.depth.values(), std::back_inserter(depths), [](float depth) { return depth > 0; });
    if (depths.empty()) return camera;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::ranges::nth_element(depths, middle);
    const SE3 pivot = camera.camera_to_world * Eigen::Translation3d(0, 0, double{*middle});
    const SE3 turned = pivot * Eigen::AngleAxisd(kAngle, Eigen::Vector3d::UnitY());
    camera.camera_to_world = turned * pivot.inverse() * camera.camera_to_world;
    return camera;
  }

  std::vector<fields::PosedField> posed(double frame) const {
    std::vector<fields::PosedField> layers;
    layers.reserve(drawables_.size());
    for (std::size_t l = 0; l < drawables_.size(); ++l)
      layers.push_back(fields::pose(drawables_[l], clip_.layers[l].motion.warp(frame)));
    return layers;
  }

  std::size_t shown_pixels(const View& view) const {
    constexpr std::size_t kChannels = 4;
    constexpr int kHalf = 127;
    const fields::Picture picture = fields::render(posed(view.frame), view.camera);
    const auto& color = picture.color.values();
    std::size_t shown = 0;
    for (std::size_t i = 3; i < color.size(); i += kChannels) shown += color[i] > kHalf ? 1 : 0;
    return shown;
  }

  // Over black.
  std::vector<float> draw(const View& view) const {
    const fields::Picture picture = fields::render(posed(view.frame), view.camera);
    constexpr std::size_t kChannels = 4;
    const auto& color = picture.color.values();
    std::vector<float> values;
    values.reserve(color.size());
    for (std::size_t i = 0; i + kChannels <= color.size(); i += kChannels) {
      const float alpha = static_cast<float>(color[i + 3]) / 255;
      for (std::size_t c = 0; c < 3; ++c) values.push_back(static_cast<float>(color[i + c]) * alpha);
    }
    return values;
  }

  const clip::Clip& clip_;
  std::vector<fields::DrawableField> drawables_;
  std::vector<View> views_;
  std::size_t drawn_values_ = 0;
};

/// Of a field or a constant one.
auto level_of(auto& field, std::size_t level) {
  constexpr std::size_t kFeatures = fields::FieldConfig::kFeatures;
  const std::vector<fields::GridLevel> levels = fields::grid_levels(field.config);
  const std::size_t begin = std::size_t{levels[level].offset} * kFeatures;
  const bool is_last = level + 1 == levels.size();
  const std::size_t end = is_last ? field.table.size() : std::size_t{levels[level + 1].offset} * kFeatures;
  return std::span(field.table).subspan(begin, end - begin);
}

// Leaves what no other choice beats for fewer bytes.
void keep_worthwhile(std::vector<Choice>& choices) {
  std::ranges::sort(choices, [](const Choice& a, const Choice& b) {
    return a.bytes < b.bytes || (a.bytes == b.bytes && a.error < b.error);
  });
  std::vector<Choice> kept;
  for (const Choice& choice : choices) {
    if (kept.empty() || choice.error < kept.back().error) kept.push_back(choice);
  }
  choices = std::move(kept);
}

void try_layer(const clip::Clip& clip, std::size_t layer, Pictures& pictures, std::vector<Trial>& trials,
               Progress& progress) {
  const fields::Field& field = clip.layers[layer].field;
  const auto levels = static_cast<std::size_t>(field.config.levels);
  const fields::Field finest = clip::rounded(field, clip::FieldRounding(levels, kLadder.back())).field;
  std::vector<Trial> of_layer(levels);
  std::vector<std::vector<float>> probes(levels);
  const auto error_with = [&](const auto& values, std::size_t level) {
    fields::Field changed = finest;
    std::ranges::copy(values, level_of(changed, level).begin());
    return pictures.error_with(layer, std::move(changed));
  };
  for (std::size_t c = 0; c < kLadder.size(); ++c) {
    progress.check();
    const clip::RoundedField rounded = clip::rounded(field, clip::FieldRounding(levels, kLadder[c]));
    for (std::size_t l = 0; l < levels; ++l) {
      Trial& trial = of_layer[l];
      const auto values = level_of(rounded.field, l);
      trial.bytes[c] = rounded.level_bytes[l];
      trial.parameter_errors[c] = squared_error(values, level_of(finest, l));
      if (c == kNothing) trial.error_of_nothing = error_with(values, l);
      if (c == kNothing || c > kProbe || trial.parameter_errors[c] == 0) continue;
      trial.probe = c;
      probes[l].assign(values.begin(), values.end());
    }
  }
  for (std::size_t l = 0; l < levels; ++l) {
    of_layer[l].layer = layer;
    of_layer[l].level = l;
    if (of_layer[l].probe != kNothing) of_layer[l].error_of_probe = error_with(probes[l], l);
  }
  trials.insert(trials.end(), of_layer.begin(), of_layer.end());
}

// What no picture shows, as it is hidden there or not yet there, is taken to be as sensitive as what they show.
std::vector<Unit> units_of(const std::vector<Trial>& trials) {
  const auto mean_sensitivity = [&trials](const auto& counts) {
    double sum = 0;
    std::size_t count = 0;
    for (const Trial& trial : trials) {
      if (!trial.is_shown() || !counts(trial)) continue;
      sum += trial.sensitivity();
      ++count;
    }
    return count > 0 ? sum / static_cast<double>(count) : 0;
  };
  std::vector<Unit> units;
  for (const Trial& trial : trials) {
    double sensitivity = trial.sensitivity();
    if (!trial.is_shown())
      sensitivity = mean_sensitivity([&](const Trial& other) { return other.level == trial.level; });
    if (sensitivity == 0) sensitivity = mean_sensitivity([](const Trial&) { return true; });
    if (sensitivity == 0) sensitivity = 1;
    Unit& unit = units.emplace_back(Unit{trial.layer, {}});
    for (std::size_t c = 0; c < kLadder.size(); ++c) {
      const double error = sensitivity * trial.parameter_errors[c];
      unit.choices.push_back(
          {kLadder[c], trial.bytes[c], c == kNothing && trial.is_shown() ? trial.error_of_nothing : error});
    }
    keep_worthwhile(unit.choices);
  }
  return units;
}

// Of each unit the choice with which all together leave the least error for at most `bytes` more than with the cheapest
// of each: a knapsack of which one thing of each kind is taken. Bytes are counted in parts of all, rounded up.
std::vector<std::size_t> best_choices(const std::vector<Unit>& units, std::size_t bytes) {
  constexpr std::size_t kParts = 8192;
  const auto more = [](const Unit& unit, std::size_t c) { return unit.choices[c].bytes - unit.choices[0].bytes; };
  std::size_t most = 0;
  for (const Unit& unit : units) most += more(unit, unit.choices.size() - 1);
  std::vector<std::size_t> chosen(units.size());
  if (bytes >= most) {
    for (std::size_t u = 0; u < units.size(); ++u) chosen[u] = units[u].choices.size() - 1;
    return chosen;
  }
  const std::size_t part = bytes / kParts + 1;
  const std::size_t room = bytes / part;
  std::vector<double> least(room + 1, 0); // error of the units so far in so many parts
  std::vector<std::vector<std::uint8_t>> choice_in(units.size());
  for (std::size_t u = 0; u < units.size(); ++u) {
    std::vector<double> with_unit(room + 1, std::numeric_limits<double>::infinity());
    choice_in[u].resize(room + 1);
    for (std::size_t c = 0; c < units[u].choices.size(); ++c) {
      const std::size_t parts = (more(units[u], c) + part - 1) / part;
      for (std::size_t r = parts; r <= room; ++r) {
        const double error = least[r - parts] + units[u].choices[c].error;
        if (error >= with_unit[r]) continue;
        with_unit[r] = error;
        choice_in[u][r] = static_cast<std::uint8_t>(c);
      }
    }
    least = std::move(with_unit);
  }
  std::size_t left = room;
  for (std::size_t u = units.size(); u-- > 0;) {
    chosen[u] = choice_in[u][left];
    left -= (more(units[u], chosen[u]) + part - 1) / part;
  }
  return chosen;
}

} // namespace

struct RateControl::Units {
  std::vector<Unit> units; // nothing is chosen
  std::size_t layers = 0;
  std::size_t other_bytes = 0;
  std::size_t drawn_values = 0; // that errors are sums over

  template <class ChoiceOf> std::size_t bytes_with(const ChoiceOf& choice_of) const {
    std::size_t sum = other_bytes;
    for (const Unit& unit : units) sum += choice_of(unit).bytes;
    return sum;
  }

  RateChoice choose(std::size_t bytes) const {
    const std::size_t fewest = bytes_with([](const Unit& unit) -> const Choice& { return unit.choices.front(); });
    const std::vector<std::size_t> chosen = best_choices(units, bytes > fewest ? bytes - fewest : 0);
    RateChoice result;
    result.bytes = other_bytes;
    result.fields.resize(layers);
    double error = 0;
    for (std::size_t u = 0; u < units.size(); ++u) {
      const Choice& choice = units[u].choices[chosen[u]];
      result.bytes += choice.bytes;
      result.fields[units[u].layer].push_back(choice.rounding);
      error += choice.error;
    }
    constexpr double kMostDecibels = 100;
    const double mean = error / static_cast<double>(std::max<std::size_t>(1, drawn_values));
    result.picture_psnr = mean > 0 ? std::min(kMostDecibels, 10 * std::log10(kPeak * kPeak / mean)) : kMostDecibels;
    return result;
  }
};

RateControl::RateControl(const clip::Clip& clip, std::size_t usual_bytes, Progress& progress) {
  progress.stage("choosing where bytes go", clip.layers.size());
  Pictures pictures(clip);
  auto made = std::make_unique<Units>();
  made->layers = clip.layers.size();
  made->other_bytes = usual_bytes;
  made->drawn_values = pictures.drawn_values();
  std::vector<Trial> trials;
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    const fields::Field& field = clip.layers[l].field;
    for (const std::size_t bytes : clip::rounded(field, clip::usual_rounding(field.config)).level_bytes)
      made->other_bytes -= bytes;
    try_layer(clip, l, pictures, trials, progress);
    progress.advance(l + 1, clip.layers[l].name);
  }
  made->units = units_of(trials);
  units_ = std::move(made);
}

RateControl::~RateControl() = default;

std::size_t RateControl::fewest_bytes() const {
  return units_->bytes_with([](const Unit& unit) -> const Choice& { return unit.choices.front(); });
}

std::size_t RateControl::most_bytes() const {
  return units_->bytes_with([](const Unit& unit) -> const Choice& { return unit.choices.back(); });
}

RateChoice RateControl::for_bytes(std::size_t bytes) const { return units_->choose(bytes); }

} // namespace kinora::encode
