#include "common/label_file.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <nlohmann/json.hpp>

#include "common/files.h"
#include "core/error.h"

namespace kinora::formats {
namespace fs = std::filesystem;

LabelTable LabelTable::read(const fs::path& folder) {
  LabelTable table;
  const fs::path path = folder / "labels.json";
  if (!fs::exists(path)) return table;
  const auto fail = [&path](const std::string& problem) {
    throw Error(ErrorCode::kCorruptInput,
                path.string() + ": " + problem + R"(; write {"3": {"name": "anna", "kind": "deforming|rigid|still"}})");
  };
  const nlohmann::json json = nlohmann::json::parse(read_text(path), nullptr, false);
  if (!json.is_object()) fail("not a JSON object");
  for (const auto& item : json.items()) {
    const std::string& key = item.key();
    const nlohmann::json& value = item.value();
    const std::optional<double> label = parse_number(key);
    if (!label || *label < 0 || *label > 255 || *label != std::floor(*label))
      fail("\"" + key + "\" is not a label from 0 to 255");
    if (!value.is_object()) fail("\"" + key + "\" has no object with name and kind");
    const auto text_of = [&](const char* name) {
      if (!value.contains(name)) return std::string();
      if (!value[name].is_string()) fail("\"" + std::string(name) + "\" of \"" + key + "\" is not text");
      return value[name].get<std::string>();
    };
    const std::string kind = text_of("kind");
    if (!kind.empty() && kind != "deforming" && kind != "rigid" && kind != "still") fail("\"" + kind + "\" is no kind");
    table.add(static_cast<int>(*label), text_of("name"), kind);
  }
  return table;
}

LabelTable LabelTable::of(const KinoraCaptureInfo& info) {
  LabelTable table;
  for (std::size_t i = 0; i < info.label_count; ++i)
    table.add(info.labels[i].label, info.labels[i].name, info.labels[i].kind);
  return table;
}

void LabelTable::add(int label, std::string name, std::string kind) {
  const auto after = std::ranges::upper_bound(labels_, label, {}, &Label::label);
  labels_.insert(after, {label, std::move(name), std::move(kind)});
}

void LabelTable::fill(KinoraCaptureInfo& info) const {
  views_.clear();
  for (const Label& label : labels_) views_.push_back({label.label, label.name.c_str(), label.kind.c_str()});
  info.labels = views_.data();
  info.label_count = views_.size();
}

void LabelTable::write(const fs::path& folder) const {
  if (labels_.empty()) return;
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Label& label : labels_) {
    nlohmann::ordered_json entry = {{"name", label.name}};
    if (!label.kind.empty()) entry["kind"] = label.kind;
    json[std::to_string(label.label)] = std::move(entry);
  }
  const std::string text = json.dump(2) + "\n";
  write_file(folder / "labels.json", std::as_bytes(std::span(text)));
}

} // namespace kinora::formats
