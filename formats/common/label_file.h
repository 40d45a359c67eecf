// labels.json: what the labels of a capture's masks mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinora/plugin.h"

namespace kinora::formats {

/// Labels in order, each once.
class LabelTable {
public:
  LabelTable() = default;
  /// Reads labels.json of the folder, if there is one: {"3": {"name": "anna", "kind": "deforming"}}.
  /// Throws Error(kCorruptInput), naming it and what to write.
  static LabelTable read(const std::filesystem::path& folder);
  /// A copy of what a capture says.
  static LabelTable of(const KinoraCaptureInfo& info);

  void add(int label, std::string name, std::string kind);
  bool empty() const { return labels_.empty(); }
  /// The table must stay where it is, and as it is, as long as `info` is used.
  void fill(KinoraCaptureInfo& info) const;
  /// Writes labels.json, unless there is no label. Throws Error(kUnwritableOutput).
  void write(const std::filesystem::path& folder) const;

private:
  struct Label {
    int label;
    std::string name;
    std::string kind;
  };
  std::vector<Label> labels_;
  mutable std::vector<KinoraLabel> views_; ///< of labels_, made by fill
};

} // namespace kinora::formats
