// A network in an ONNX file, run by OpenCV.
#pragma once

#include <filesystem>
#include <string>

#include <opencv2/dnn.hpp>

namespace kinora::ingest {

/// Runs on the CPU. Throws Error(kCorruptInput) if the file is missing or is no network that OpenCV can run.
cv::dnn::Net read_onnx_network(const std::filesystem::path& path);

/// Throws Error(kCorruptInput): the file's path, then the problem.
[[noreturn]] void refuse_network(const std::filesystem::path& path, const std::string& problem);

} // namespace kinora::ingest
