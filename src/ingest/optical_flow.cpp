#include "ingest/optical_flow.h"

#include <cmath>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "ingest/opencv_images.h"

namespace kinora::ingest {

Image<float> optical_flow(const ColorImage& to, const ColorImage& from) {
  cv::Mat gray[2];
  cv::cvtColor(view_of(to), gray[0], cv::COLOR_RGB2GRAY);
  cv::cvtColor(view_of(from), gray[1], cv::COLOR_RGB2GRAY);
  Image<float> flow(to.width(), to.height(), 2);
  cv::Mat out(to.height(), to.width(), CV_32FC2, flow.data());
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1); // with each number of threads it gives other bits
  cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM)->calc(gray[0], gray[1], out);
  cv::setNumThreads(threads);
  return flow;
}

Pixel origin_of(const Image<float>& flow, int u, int v) {
  return {static_cast<int>(std::lround(static_cast<float>(u) + flow.at(u, v, 0))),
          static_cast<int>(std::lround(static_cast<float>(v) + flow.at(u, v, 1)))};
}

} // namespace kinora::ingest
