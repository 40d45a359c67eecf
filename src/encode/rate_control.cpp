#include "encode/rate_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "fields/rendering/renderer.h"

namespace kinora::encode {

namespace {

using clip::Rounding;

// From nothing to what cannot be told from the field itself; `up_from` fills the gaps between powers of two.
constexpr std::array<Rounding, 13> kLadder{{{0},
                                            {0.125, 0.6},
                                            {0.25, 0.6},
                                            {0.5, 0.7},
                                            {0.5, 0.55},
                                            {1, 0.7},
                                            {1, 0.55},
                                            {2, 0.7},
                                            {2, 0.55},
                                            {4, 0.7},
                                            {4, 0.55},
                                            {8, 0.5},
                                            {16, 0.5}}};
static_assert(kLadder[6].steps_per_rms == 1);
constexpr double kPeak = 255; // of pictures
constexpr std::size_t kNothing = 0;
constexpr std::size_t kProbe =
    6; // a step to the root mean square: drawn, as is nothing; errors of the others grow with those of the parameters

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

std::span<float> level_of(fields::Field& field, std::size_t level) {
  constexpr std::size_t kFeatures = fields::FieldConfig::kFeatures;
  const std::vector<fields::GridLevel> levels = fields::grid_levels(field.config);
  const std::size_t begin = std::size_t{levels[level].offset} * kFeatures;
  const bool is_last = level + 1 == levels.size();
  const std::size_t end = is_last ? field.table.size() : std::size_t{levels[level + 1].offset} * kFeatures;
  return std::span<float>(field.table).subspan(begin, end - begin);
}

// Leaves the lower convex hull: nothing that costs more than a mix of two others for the same error.
void keep_worthwhile(std::vector<Choice>& choices) {
  std::ranges::sort(choices, [](const Choice& a, const Choice& b) {
    return a.bytes < b.bytes || (a.bytes == b.bytes && a.error < b.error);
  });
  const auto slope = [](const Choice& a, const Choice& b) {
    return (a.error - b.error) / (static_cast<double>(b.bytes) - static_cast<double>(a.bytes));
  };
  std::vector<Choice> hull;
  for (const Choice& choice : choices) {
    if (!hull.empty() && (choice.error >= hull.back().error || choice.bytes == hull.back().bytes)) continue;
    while (hull.size() > 1 && slope(hull.back(), choice) >= slope(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(choice);
  }
  choices = std::move(hull);
}

void add_units(const clip::Clip& clip, std::size_t layer, Pictures& pictures, std::vector<Unit>& units,
               Progress& progress) {
  const fields::Field& field = clip.layers[layer].field;
  const auto levels = static_cast<std::size_t>(field.config.levels);
  fields::Field finest = clip::rounded(field, clip::FieldRounding(levels, kLadder.back())).field;
  std::vector<Unit> of_layer(levels);
  std::vector<std::array<double, kLadder.size()>> parameter_errors(levels);
  std::vector<std::array<double, kLadder.size()>> drawn_errors(levels);
  for (std::size_t c = 0; c < kLadder.size(); ++c) {
    progress.check();
    clip::RoundedField rounded = clip::rounded(field, clip::FieldRounding(levels, kLadder[c]));
    for (std::size_t l = 0; l < levels; ++l) {
      of_layer[l].layer = layer;
      of_layer[l].choices.push_back({kLadder[c], rounded.level_bytes[l], 0});
      parameter_errors[l][c] = squared_error(level_of(rounded.field, l), level_of(finest, l));
      if (c != kNothing && c != kProbe) continue;
      fields::Field changed = finest;
      std::ranges::copy(level_of(rounded.field, l), level_of(changed, l).begin());
      drawn_errors[l][c] = pictures.error_with(layer, std::move(changed));
    }
  }
  for (std::size_t l = 0; l < levels; ++l) {
    const double probed = parameter_errors[l][kProbe];
    const double per_parameter = probed > 0 ? drawn_errors[l][kProbe] / probed : 0;
    for (std::size_t c = 0; c < kLadder.size(); ++c) {
      of_layer[l].choices[c].error = c == kNothing ? drawn_errors[l][c] : per_parameter * parameter_errors[l][c];
    }
    keep_worthwhile(of_layer[l].choices);
    units.push_back(std::move(of_layer[l]));
  }
}

struct Step {
  std::size_t unit;
  std::size_t to;
  double error_per_byte;
};

// Of all units, the one that lowers the error most for its bytes first.
std::vector<Step> steps_of(const std::vector<Unit>& units) {
  std::vector<Step> steps;
  for (std::size_t u = 0; u < units.size(); ++u) {
    const std::vector<Choice>& choices = units[u].choices;
    for (std::size_t c = 1; c < choices.size(); ++c) {
      const auto more = static_cast<double>(choices[c].bytes - choices[c - 1].bytes);
      steps.push_back({u, c, (choices[c - 1].error - choices[c].error) / more});
    }
  }
  std::ranges::stable_sort(steps, std::greater<>(), &Step::error_per_byte);
  return steps;
}

} // namespace

struct RateControl::Units {
  std::vector<Unit> units; // nothing is chosen
  std::vector<Step> steps;
  std::size_t layers = 0;
  std::size_t other_bytes = 0;
  std::size_t drawn_values = 0; // that errors are sums over

  template <class ChoiceOf> std::size_t bytes_with(const ChoiceOf& choice_of) const {
    std::size_t sum = other_bytes;
    for (const Unit& unit : units) sum += choice_of(unit).bytes;
    return sum;
  }

  // Each unit begins with its cheapest choice. A step that does not fit ends its unit; those of others may still fit.
  RateChoice choose(std::size_t bytes) const {
    std::vector<std::size_t> chosen(units.size(), 0);
    RateChoice result;
    result.bytes = bytes_with([](const Unit& unit) -> const Choice& { return unit.choices.front(); });
    double error = 0;
    for (const Unit& unit : units) error += unit.choices.front().error;
    for (const Step& step : steps) {
      const Choice& before = units[step.unit].choices[step.to - 1];
      const Choice& after = units[step.unit].choices[step.to];
      if (chosen[step.unit] + 1 != step.to || result.bytes + after.bytes - before.bytes > bytes) continue;
      chosen[step.unit] = step.to;
      result.bytes += after.bytes - before.bytes;
      error += after.error - before.error;
    }
    constexpr double kMostDecibels = 100;
    const double mean = error / static_cast<double>(std::max<std::size_t>(1, drawn_values));
    result.picture_psnr = mean > 0 ? std::min(kMostDecibels, 10 * std::log10(kPeak * kPeak / mean)) : kMostDecibels;
    result.fields.resize(layers);
    for (std::size_t u = 0; u < units.size(); ++u)
      result.fields[units[u].layer].push_back(units[u].choices[chosen[u]].rounding);
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
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    const fields::Field& field = clip.layers[l].field;
    for (const std::size_t bytes : clip::rounded(field, clip::usual_rounding(field.config)).level_bytes)
      made->other_bytes -= bytes;
    add_units(clip, l, pictures, made->units, progress);
    progress.advance(l + 1, clip.layers[l].name);
  }
  made->steps = steps_of(made->units);
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
