#include "ingest/onnx/onnx_network.h"

#include <opencv2/core/utils/logger.hpp>

#include "core/error.h"

namespace kinora::ingest {

void refuse_network(const std::filesystem::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

cv::dnn::Net read_onnx_network(const std::filesystem::path& path) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  if (!std::filesystem::is_regular_file(path)) {
    refuse_network(path, "the network is missing; give the path of an ONNX file");
  }
  cv::dnn::Net network;
  try {
    network = cv::dnn::readNetFromONNX(path.string());
  } catch (const cv::Exception&) {
  }
  if (network.empty()) {
    refuse_network(path, "is no ONNX network that OpenCV can run; export it for opset 11 with fixed sizes");
  }
  network.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  network.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  return network;
}

} // namespace kinora::ingest
