// Data sets of nerfstudio and instant-ngp from pictures: images, depth, labels, and transforms.json with their cameras.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "common/facts.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// FOLDER/images/<name>.png (sRGB on black), depth/<name>.png (16 bits, millimetres, 0 = nothing), mask/<name>.png
/// (the label of what is in front), labels.json (what labels mean, as capture folders have it) and transforms.json,
/// written by finish(). The format transforms reads it as a capture.
class DataSetWriter {
public:
  /// Makes the folder. Throws Error(kUnwritableOutput).
  explicit DataSetWriter(std::filesystem::path folder);

  /// "kinora" of transforms.json.
  void describe(Facts facts) { facts_ = std::move(facts); }
  /// Throws Error: kUnwritableOutput; kUsage for a picture without depth or camera, or a name that leaves the folder.
  void write(const KinoraPicture& picture);
  /// Throws Error: kFailure if there was no picture; kUnwritableOutput.
  void finish() const;

private:
  std::filesystem::path folder_;
  Facts facts_;
  nlohmann::json frames_ = nlohmann::json::array();
  nlohmann::json label_meanings_ = nlohmann::json::object();
};

} // namespace kinora::formats
