#include "ingest/grab_cut.h"

#include <opencv2/imgproc.hpp>

#include "ingest/opencv_images.h"

namespace kinora::ingest {
namespace {

constexpr int kSurroundings = 16; ///< pixels

cv::Mat bgr(const ColorImage& color) {
  cv::Mat out;
  cv::cvtColor(view_of(color), out, cv::COLOR_RGB2BGR);
  return out;
}

cv::Rect grown(const cv::Rect& rect, int by) {
  return {rect.x - by, rect.y - by, rect.width + 2 * by, rect.height + 2 * by};
}

/// `states`: Belonging as bytes.
void grab_cut(const cv::Mat& image, cv::Mat states, std::span<double> rest, std::span<double> own, int iterations,
              int mode) {
  cv::Mat rest_view(1, static_cast<int>(rest.size()), CV_64F, rest.data());
  cv::Mat own_view(1, static_cast<int>(own.size()), CV_64F, own.data());
  cv::theRNG().state = 1; // it begins with random clusters
  cv::grabCut(image, states, {}, rest_view, own_view, iterations, mode);
}

} // namespace

std::vector<std::uint8_t> labels_in(const LabelImage& labels) {
  std::array<bool, 256> seen{};
  for (const std::uint8_t label : labels.values()) seen[label] = true;
  std::vector<std::uint8_t> list;
  for (std::size_t label = 1; label < seen.size(); ++label)
    if (seen[label]) list.push_back(static_cast<std::uint8_t>(label));
  return list;
}

Mask inner_pixels(const LabelImage& labels, int radius) {
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  cv::Mat least, most;
  cv::erode(view_of(labels), least, disc);
  cv::dilate(view_of(labels), most, disc);
  Mask inner(labels.width(), labels.height());
  for (std::size_t i = 0; i < inner.pixel_count(); ++i) inner.data()[i] = least.data[i] == most.data[i] ? 1 : 0;
  return inner;
}

ColorMixtures::ColorMixtures(const ColorImage& color, const LabelImage& labels, std::uint8_t label) {
  const cv::Mat states = (view_of(labels) == label) & 1; // GC_FGD is 1, GC_BGD 0
  grab_cut(bgr(color), states, rest_, own_, 0, cv::GC_INIT_WITH_MASK);
}

Mask ColorMixtures::cut(const ColorImage& color, const Image<Belonging>& known) const {
  Mask mask(known.width(), known.height());
  std::ranges::transform(known.values(), mask.data(), [](Belonging b) { return static_cast<std::uint8_t>(b); });
  Model rest = rest_;
  Model own = own_;
  grab_cut(bgr(color), view_of(mask), rest, own, 1, cv::GC_EVAL_FREEZE_MODEL);
  for (std::uint8_t& state : mask.values()) state &= 1; // kOwn and kPerhapsOwn are odd
  return mask;
}

void sharpen_borders(const ColorImage& color, int radius, LabelImage& labels) {
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  const cv::Mat image = bgr(color);
  const std::vector<std::uint8_t> present = labels_in(labels);
  cv::Mat after = view_of(labels);
  const cv::Mat before = after.clone();
  // A pixel that no label claims is background where there is some; one that keeps its claim keeps its label.
  cv::Mat near_background;
  cv::dilate(before == 0, near_background, disc);
  after.setTo(0, near_background);
  for (const std::uint8_t label : present) {
    const cv::Mat own = before == label;
    cv::Mat inner, outer;
    cv::erode(own, inner, disc);
    cv::dilate(own, outer, disc);
    cv::Mat states(own.size(), CV_8U, cv::Scalar(cv::GC_BGD));
    states.setTo(cv::GC_PR_BGD, outer);
    states.setTo(cv::GC_PR_FGD, own);
    states.setTo(cv::GC_FGD, inner);
    // Only what lies around the label is cut: that is faster, and the colours beside it are those that count.
    const cv::Rect surroundings = grown(cv::boundingRect(outer), kSurroundings) & cv::Rect({}, own.size());
    cv::Mat part = states(surroundings);
    if (cv::countNonZero(part == cv::GC_FGD) > 0 && cv::countNonZero(part == cv::GC_BGD) > 0) {
      std::array<double, ColorMixtures::kSize> others{}, mixture{};
      grab_cut(image(surroundings), part, others, mixture, 1, cv::GC_INIT_WITH_MASK);
    }
    const cv::Mat claimed = (states & 1) != 0;
    after.setTo(label, claimed & ((before == label) | (after == 0)));
  }
}

} // namespace kinora::ingest
