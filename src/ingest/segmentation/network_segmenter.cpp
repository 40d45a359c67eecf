#include "ingest/segmentation/network_segmenter.h"

#include <fmt/format.h>
#include <opencv2/dnn.hpp>

#include "ingest/onnx/onnx_network.h"

namespace kinora::ingest {
namespace {

constexpr int kSideMultiple = 32;
constexpr int kMaxClasses = 256;
constexpr float kForeground = 0.5F;

int network_side(int side) { return side < kSideMultiple ? side : side / kSideMultiple * kSideMultiple; }

class NetworkSegmenter final : public Segmenter {
public:
  explicit NetworkSegmenter(const std::filesystem::path& path) : path_(path), network_(read_onnx_network(path)) {
    const std::string why = "the network " + path.filename().string() + " says so";
    labels_ = {{0, {"background", "still", why}}, {1, {"person", "deforming", why}}};
  }

  void prepare(const CaptureFactory& open, const FrameRange& range, Progress& /*progress*/) override {
    if (auto frame = open(range)->next()) label(*frame); // an output of a wrong form is known before the work begins
  }

  void label(Frame& frame) override {
    const cv::Mat scores = run(frame.color);
    const int classes = scores.size[1];
    const int height = scores.size[2];
    const int width = scores.size[3];
    add_labels(classes);
    frame.labels = LabelImage(frame.color.width(), frame.color.height());
    const auto* data = scores.ptr<float>();
    const std::size_t plane = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    for (int v = 0; v < frame.labels.height(); ++v) {
      for (int u = 0; u < frame.labels.width(); ++u) {
        const int x = (2 * u + 1) * width / (2 * frame.labels.width());
        const int y = (2 * v + 1) * height / (2 * frame.labels.height());
        const float* at = data + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + x;
        frame.labels.at(u, v) = classes == 1 ? (*at > kForeground ? 1 : 0) : best_class(at, plane, classes);
      }
    }
  }

  const std::map<int, LabelInfo>& labels() const override { return labels_; }

private:
  cv::Mat run(const ColorImage& color) {
    cv::Mat scores;
    try {
      // OpenCV has no read-only header; blobFromImage copies.
      const cv::Mat image(color.height(), color.width(), CV_8UC3, const_cast<std::uint8_t*>(color.data()));
      network_.setInput(cv::dnn::blobFromImage(
          image, 1.0 / 255, cv::Size(network_side(color.width()), network_side(color.height())), cv::Scalar(), false));
      scores = network_.forward();
    } catch (const cv::Exception& error) {
      refuse_network(path_, fmt::format("cannot be run on {}x{} pixels: {}", color.width(), color.height(), error.err));
    }
    if (scores.dims != 4 || scores.size[0] != 1 || scores.size[1] < 1 || scores.size[1] > kMaxClasses ||
        scores.size[2] < 1 || scores.size[3] < 1 || scores.type() != CV_32F)
      refuse_network(path_, "gives no map of 1 x classes x height x width scores; export one without post-processing");
    return scores;
  }

  static std::uint8_t best_class(const float* at, std::size_t plane, int classes) {
    int best = 0;
    for (int c = 1; c < classes; ++c)
      if (at[static_cast<std::size_t>(c) * plane] > at[static_cast<std::size_t>(best) * plane]) best = c;
    return static_cast<std::uint8_t>(best);
  }

  void add_labels(int classes) {
    for (int label = static_cast<int>(labels_.size()); label < classes; ++label)
      labels_[label] = {label == 2 ? "object" : fmt::format("object{}", label - 1), "rigid", labels_[0].why};
  }

  std::filesystem::path path_;
  cv::dnn::Net network_;
  std::map<int, LabelInfo> labels_;
};

} // namespace

std::unique_ptr<Segmenter> opencv::make_network_segmenter(const std::filesystem::path& network) {
  return std::make_unique<NetworkSegmenter>(network);
}

} // namespace kinora::ingest
