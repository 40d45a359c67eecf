#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "ingest/opencv/opencv_functions.h"
#include "ingest/opencv/opencv_images.h"

namespace kinora::ingest::opencv {
namespace {

constexpr int kSurroundings = 16; ///< pixels

cv::Mat bgr(const ColorImage& color) {
  cv::Mat out;
  cv::cvtColor(view_of(color), out, cv::COLOR_RGB2BGR);
  return out;
}

cv::Mat view_of_floats(const Image<float>& image) {
  return {image.height(), image.width(), CV_32FC(image.channels()), const_cast<float*>(image.data())};
}

cv::Rect grown(const cv::Rect& rect, int by) {
  return {rect.x - by, rect.y - by, rect.width + 2 * by, rect.height + 2 * by};
}

cv::Mat disc_of(int radius) { return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}); }

/// `states`: as of cut(), as bytes.
void grab_cut(const cv::Mat& image, cv::Mat states, ColorMixture& own, ColorMixture& rest, int iterations, int mode) {
  cv::Mat rest_view(1, static_cast<int>(rest.size()), CV_64F, rest.data());
  cv::Mat own_view(1, static_cast<int>(own.size()), CV_64F, own.data());
  cv::theRNG().state = 1; // it begins with random clusters
  cv::grabCut(image, states, {}, rest_view, own_view, iterations, mode);
}

} // namespace

Image<float> optical_flow(const ColorImage& to, const ColorImage& from) {
  cv::Mat gray[2];
  cv::cvtColor(view_of(to), gray[0], cv::COLOR_RGB2GRAY);
  cv::cvtColor(view_of(from), gray[1], cv::COLOR_RGB2GRAY);
  Image<float> flow(to.width(), to.height(), 2);
  cv::Mat out = view_of_floats(flow);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1); // with each number of threads it gives other bits
  cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM)->calc(gray[0], gray[1], out);
  cv::setNumThreads(threads);
  return flow;
}

Image<float> gaussian_blur(const Image<float>& image, double sigma) {
  Image<float> blurred(image.width(), image.height());
  cv::Mat out = view_of_floats(blurred);
  cv::GaussianBlur(view_of_floats(image), out, {}, sigma, sigma, cv::BORDER_REPLICATE);
  return blurred;
}

PixelRegions connected_regions(const Image<std::uint8_t>& mask) {
  PixelRegions regions{Image<std::int32_t>(mask.width(), mask.height()), 0};
  cv::Mat map(mask.height(), mask.width(), CV_32S, regions.map.data());
  regions.count = cv::connectedComponents(view_of(mask), map);
  return regions;
}

Image<std::uint8_t> inner_pixels(const LabelImage& labels, int radius) {
  const cv::Mat disc = disc_of(radius);
  cv::Mat least, most;
  cv::erode(view_of(labels), least, disc);
  cv::dilate(view_of(labels), most, disc);
  Image<std::uint8_t> inner(labels.width(), labels.height());
  for (std::size_t i = 0; i < inner.pixel_count(); ++i) inner.data()[i] = least.data[i] == most.data[i] ? 1 : 0;
  return inner;
}

void learn_mixtures(const ColorImage& color, const LabelImage& labels, std::uint8_t label, ColorMixture& own,
                    ColorMixture& rest) {
  const cv::Mat states = (view_of(labels) == label) & 1; // GC_FGD is 1, GC_BGD 0
  grab_cut(bgr(color), states, own, rest, 0, cv::GC_INIT_WITH_MASK);
}

void cut(const ColorImage& color, const ColorMixture& own, const ColorMixture& rest, Image<std::uint8_t>& states) {
  ColorMixture own_copy = own;
  ColorMixture rest_copy = rest;
  grab_cut(bgr(color), view_of(states), own_copy, rest_copy, 1, cv::GC_EVAL_FREEZE_MODEL);
}

void sharpen_borders(const ColorImage& color, int radius, std::span<const std::uint8_t> present, LabelImage& labels) {
  const cv::Mat disc = disc_of(radius);
  const cv::Mat image = bgr(color);
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
      ColorMixture mixture{}, others{};
      grab_cut(image(surroundings), part, mixture, others, 1, cv::GC_INIT_WITH_MASK);
    }
    const cv::Mat claimed = (states & 1) != 0;
    after.setTo(label, claimed & ((before == label) | (after == 0)));
  }
}

} // namespace kinora::ingest::opencv
