#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "ingest/joints/joint_detector.h"
#include "ingest/onnx/onnx_input.h"
#include "ingest/onnx/onnx_network.h"
#include "ingest/opencv/opencv_images.h"

namespace kinora::ingest {
namespace {

constexpr int kMinPixels = 200;  // of a person
constexpr double kMargin = 1.25; // of the crop about the person's box
constexpr std::array<float, 3> kMean = {0.485F, 0.456F, 0.406F};
constexpr std::array<float, 3> kDeviation = {0.229F, 0.224F, 0.225F};

/// Where the network's input lies on the picture: pixel = origin + scale · pixel of the network.
struct Crop {
  Eigen::Vector2d origin;
  double scale;
};

// Nothing if the frame hardly shows the label.
std::optional<Crop> crop_about(const LabelImage& labels, int label, const cv::Size& input) {
  int pixels = 0;
  Eigen::Vector2i low(labels.width(), labels.height());
  Eigen::Vector2i high(-1, -1);
  for (int v = 0; v < labels.height(); ++v) {
    for (int u = 0; u < labels.width(); ++u) {
      if (labels.at(u, v) != label) continue;
      ++pixels;
      low = low.cwiseMin(Eigen::Vector2i(u, v));
      high = high.cwiseMax(Eigen::Vector2i(u, v));
    }
  }
  if (pixels < kMinPixels) return std::nullopt;
  const Eigen::Vector2d size = (high - low + Eigen::Vector2i::Ones()).cast<double>();
  const double scale = kMargin * std::max(size.x() / input.width, size.y() / input.height);
  const Eigen::Vector2d centre = (low + high).cast<double>() / 2;
  return Crop{centre - scale * Eigen::Vector2d(input.width - 1, input.height - 1) / 2, scale};
}

// 1 × 3 × height × width; what lies outside the picture is black.
cv::Mat blob_of(const ColorImage& color, const Crop& crop, const cv::Size& input) {
  const cv::Matx23d to_picture(crop.scale, 0, crop.origin.x(), 0, crop.scale, crop.origin.y());
  cv::Mat cut;
  cv::warpAffine(view_of(color), cut, to_picture, input, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  cv::Mat blob({1, 3, input.height, input.width}, CV_32F);
  for (int c = 0; c < 3; ++c) {
    for (int v = 0; v < input.height; ++v) {
      const std::uint8_t* in = cut.ptr<std::uint8_t>(v);
      auto* out = blob.ptr<float>(0, c, v);
      const auto channel = static_cast<std::size_t>(c);
      for (int u = 0; u < input.width; ++u) {
        out[u] = (static_cast<float>(in[3 * u + c]) / 255 - kMean[channel]) / kDeviation[channel];
      }
    }
  }
  return blob;
}

// The largest value of a heat map, in its cells; a value that is no number is never the largest.
DetectedJoint peak_of(const float* map, int width, int height) {
  DetectedJoint joint;
  int best = -1;
  for (int i = 0; i < width * height; ++i) {
    if (map[i] > (best < 0 ? 0.0F : map[best])) best = i;
  }
  if (best < 0) return joint;
  const int x = best % width;
  const int y = best / width;
  const auto towards = [](float before, float after) { return after > before ? 0.25 : after < before ? -0.25 : 0.0; };
  joint.pixel = Eigen::Vector2d(x, y);
  if (x > 0 && x + 1 < width) joint.pixel.x() += towards(map[best - 1], map[best + 1]);
  if (y > 0 && y + 1 < height) joint.pixel.y() += towards(map[best - width], map[best + width]);
  joint.score = std::min(1.0F, map[best]);
  return joint;
}

class NetworkDetector final : public JointDetector {
public:
  explicit NetworkDetector(const std::filesystem::path& path) : path_(path), network_(read_onnx_network(path)) {
    find_input();
    run(cv::Mat({1, 3, input_.height, input_.width}, CV_32F, cv::Scalar(0))); // another output is known at once
  }

  DetectedPerson detect(const Frame& frame, int label) override {
    DetectedPerson person{label, {}};
    const std::optional<Crop> crop = crop_about(frame.labels, label, input_);
    if (!crop) return person;
    const cv::Mat maps = run(blob_of(frame.color, *crop, input_));
    const int height = maps.size[2];
    const int width = maps.size[3];
    const Eigen::Vector2d cell(static_cast<double>(input_.width) / width, static_cast<double>(input_.height) / height);
    for (std::size_t i = 0; i < kDetectedJoints; ++i) {
      person.joints[i] = peak_of(maps.ptr<float>(0, static_cast<int>(i)), width, height);
      person.joints[i].pixel = crop->origin + crop->scale * cell.cwiseProduct(person.joints[i].pixel);
    }
    return person;
  }

private:
  void find_input() {
    std::ifstream file(path_, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const std::optional<PictureSize> size = onnx_picture_input(bytes);
    if (!size) {
      refuse_network(path_, "takes no 1 x 3 x height x width picture of a fixed size; export a network of one person's "
                            "crop, such as HRNet for 256 x 192 pixels, with fixed sizes");
    }
    input_ = cv::Size(size->width, size->height);
  }

  cv::Mat run(const cv::Mat& blob) {
    cv::Mat maps;
    try {
      network_.setInput(blob);
      maps = network_.forward();
    } catch (const cv::Exception& error) {
      refuse_network(path_, fmt::format("cannot be run on {}x{} pixels: {}", input_.width, input_.height, error.err));
    }
    if (maps.dims != 4 || maps.size[0] != 1 || maps.size[1] != static_cast<int>(kDetectedJoints) || maps.size[2] < 2 ||
        maps.size[3] < 2 || maps.type() != CV_32F) {
      refuse_network(path_, "gives no 1 x 17 x h x w heat maps of COCO's joints; export a network such as HRNet, "
                            "SimpleBaseline or ViTPose without its decoding");
    }
    return maps;
  }

  std::filesystem::path path_;
  cv::dnn::Net network_;
  cv::Size input_;
};

} // namespace

std::unique_ptr<JointDetector> opencv::make_network_detector(const std::filesystem::path& network) {
  return std::make_unique<NetworkDetector>(network);
}

} // namespace kinora::ingest
