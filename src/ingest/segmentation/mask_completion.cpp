#include "ingest/segmentation/mask_completion.h"

#include <cmath>

#include <fmt/format.h>

#include "ingest/images/grab_cut.h"
#include "ingest/images/optical_flow.h"
#include "ingest/opencv/opencv_functions.h"

namespace kinora::ingest {
namespace {

constexpr int kBorder = 2;                 ///< pixels beside another label that are decided anew
constexpr int kSameColor = 30;             ///< of 255, in every channel: the flow led to the same point
constexpr float kSameDepth = 0.05F;        ///< metres: the same
constexpr double kMaxRoundTripError = 1.5; ///< pixels that the flow there and back may miss
constexpr double kMinOverlap = 0.1;        ///< share of a piece, or of the label, that had the label before
constexpr double kMinArea = 0.2;           ///< of the label's pixels before: a smaller piece elsewhere is not it

bool same_color(const std::uint8_t* a, const std::uint8_t* b) {
  for (int c = 0; c < 3; ++c)
    if (std::abs(a[c] - b[c]) > kSameColor) return false;
  return true;
}

bool same_depth(float a, float b) { return a <= 0 ? b <= 0 : b > 0 && std::abs(a - b) < kSameDepth; }

/// The last frame's labels, moved with the picture; sure where the flow leads to the same point and back.
struct WarpedLabels {
  LabelImage labels;
  Mask is_reliable;
};

WarpedLabels warp_labels(const Frame& last, const Frame& frame) {
  const Image<float> flow = optical_flow(frame.color, last.color);
  const Image<float> back = optical_flow(last.color, frame.color);
  const Mask inner = inner_pixels(last.labels, kBorder);
  WarpedLabels result{warped(last.labels, flow), Mask(frame.color.width(), frame.color.height())};
  for (int v = 0; v < frame.color.height(); ++v) {
    for (int u = 0; u < frame.color.width(); ++u) {
      const auto [x, y] = origin_of(flow, u, v);
      if (!inner.contains(x, y) || inner.at(x, y) == 0) continue;
      const double round_trip_error =
          std::hypot(flow.at(u, v, 0) + back.at(x, y, 0), flow.at(u, v, 1) + back.at(x, y, 1));
      if (round_trip_error < kMaxRoundTripError && same_depth(frame.depth.at(u, v), last.depth.at(x, y)) &&
          same_color(frame.color.pixel(u, v), last.color.pixel(x, y)))
        result.is_reliable.at(u, v) = 1;
    }
  }
  return result;
}

Mask mask_of(const LabelImage& labels, std::uint8_t label) {
  Mask mask(labels.width(), labels.height());
  for (std::size_t i = 0; i < mask.pixel_count(); ++i) mask.data()[i] = labels.data()[i] == label ? 1 : 0;
  return mask;
}

Mask cut(const ColorImage& color, std::uint8_t label, const ColorMixtures& mixtures, const WarpedLabels& warped) {
  Image<Trimap> known(color.width(), color.height(), 1, Trimap::kProbableBackground);
  for (std::size_t i = 0; i < known.pixel_count(); ++i)
    if (warped.is_reliable.data()[i] != 0)
      known.data()[i] = warped.labels.data()[i] == label ? Trimap::kForeground : Trimap::kBackground;
  return mixtures.cut(color, known);
}

/// Which pieces had the label before; if none had, the largest one unless it is too small.
std::vector<bool> components_of_label(const SurfaceComponents& components, const Mask& before) {
  std::vector<double> overlap(components.list.size());
  double pixels_before = 0;
  for (std::size_t i = 0; i < before.pixel_count(); ++i) {
    pixels_before += before.data()[i];
    if (components.map.data()[i] >= 0) overlap[static_cast<std::size_t>(components.map.data()[i])] += before.data()[i];
  }
  std::vector<bool> wanted(components.list.size());
  bool any = false;
  for (std::size_t n = 0; n < components.list.size(); ++n) {
    wanted[n] = overlap[n] > kMinOverlap * std::min(pixels_before, static_cast<double>(components.list[n].pixels));
    any |= wanted[n];
  }
  if (const int largest = components.largest(); !any && largest >= 0) {
    const auto n = static_cast<std::size_t>(largest);
    wanted[n] = static_cast<double>(components.list[n].pixels) > kMinArea * pixels_before;
  }
  return wanted;
}

/// Of `found` the surfaces that had the label `before`, with the unmeasured pixels that hang on them.
Mask on_same_surfaces(const Frame& frame, const Mask& found, const Mask& before) {
  const SurfaceComponents components = surface_components(frame.depth, found, frame.camera.intrinsics);
  const std::vector<bool> wanted = components_of_label(components, before);
  Mask result = found;
  for (std::size_t i = 0; i < found.pixel_count(); ++i)
    if (components.map.data()[i] >= 0 && !wanted[static_cast<std::size_t>(components.map.data()[i])])
      result.data()[i] = 0;
  const PixelRegions regions = opencv_functions().connected_regions(result);
  std::vector<bool> measured(static_cast<std::size_t>(regions.count));
  const auto region = [&](std::size_t i) { return static_cast<std::size_t>(regions.map.data()[i]); };
  for (std::size_t i = 0; i < found.pixel_count(); ++i)
    if (result.data()[i] != 0 && components.map.data()[i] >= 0) measured[region(i)] = true;
  for (std::size_t i = 0; i < found.pixel_count(); ++i)
    if (!measured[region(i)]) result.data()[i] = 0;
  return result;
}

class MaskCompletion final : public Segmenter {
public:
  void prepare(const CaptureFactory& open, const FrameRange& range, Progress& progress) override {
    progress_ = &progress;
    const auto capture = open(range);
    labels_ = capture->info().labels;
    while (auto frame = capture->next()) {
      if (!frame->has_labels()) continue;
      last_ = std::move(*frame);
      break;
    }
  }

  void label(Frame& frame) override {
    if (frame.has_labels()) {
      mixtures_.clear();
    } else if (last_.has_labels()) {
      warn_once(frame.index);
      if (mixtures_.empty()) learn_colors();
      complete(frame);
    }
    if (frame.has_labels()) last_ = frame;
  }

  const std::map<int, LabelInfo>& labels() const override { return labels_; }

private:
  void warn_once(int index) {
    if (progress_ != nullptr)
      progress_->warn(fmt::format("frame {} has no mask; such frames are segmented by those that have one", index));
    progress_ = nullptr;
  }

  void learn_colors() {
    for (const std::uint8_t label : labels_in(last_.labels))
      if (last_.labels.pixel_count() > static_cast<std::size_t>(std::ranges::count(last_.labels.values(), label)))
        mixtures_.emplace(label, ColorMixtures(last_.color, last_.labels, label));
  }

  void complete(Frame& frame) const {
    const WarpedLabels warped = warp_labels(last_, frame);
    LabelImage labels(frame.color.width(), frame.color.height());
    for (const auto& [label, mixtures] : mixtures_) {
      const Mask found =
          on_same_surfaces(frame, cut(frame.color, label, mixtures, warped), mask_of(warped.labels, label));
      for (std::size_t i = 0; i < labels.pixel_count(); ++i)
        if (found.data()[i] != 0 && (labels.data()[i] == 0 || warped.labels.data()[i] == label))
          labels.data()[i] = label;
    }
    frame.labels = std::move(labels);
  }

  Progress* progress_ = nullptr; ///< until the first frame without a mask
  std::map<int, LabelInfo> labels_;
  Frame last_; ///< the last frame, with its labels; before the first frame, the first one with a mask
  std::map<std::uint8_t, ColorMixtures> mixtures_; ///< of the last frame with a mask; empty: not yet learned
};

} // namespace

std::unique_ptr<Segmenter> make_mask_completion() { return std::make_unique<MaskCompletion>(); }

} // namespace kinora::ingest
