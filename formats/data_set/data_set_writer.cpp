#include "data_set/data_set_writer.h"

#include <algorithm>
#include <cmath>

#include "common/files.h"
#include "common/picture_files.h"
#include "common/pictures.h"
#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr double kMillimetre = 0.001;

DepthImage16 millimetres_of(const Image<float>& metres) {
  DepthImage16 depth(metres.width(), metres.height());
  for (std::size_t i = 0; i < metres.pixel_count(); ++i) {
    const double units = std::round(metres.data()[i] / kMillimetre);
    depth.data()[i] = static_cast<std::uint16_t>(units <= 65535 ? std::max(units, 0.0) : 0.0);
  }
  return depth;
}

/// Camera axes there: x right, y up, z back.
Json matrix_of(const KinoraPicture& picture) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 4; ++c) row.push_back((c == 1 || c == 2 ? -1 : 1) * picture.camera_to_world[4 * r + c]);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Pixel (0,0) has its centre there at (0.5, 0.5).
Json numbers_of(const KinoraCamera& camera) {
  return {{"w", camera.width}, {"h", camera.height},    {"fl_x", camera.fx},
          {"fl_y", camera.fy}, {"cx", camera.cx + 0.5}, {"cy", camera.cy + 0.5}};
}

} // namespace

DataSetWriter::DataSetWriter(fs::path folder) : folder_(std::move(folder)) { make_folder(folder_); }

void DataSetWriter::write(const KinoraPicture& picture) {
  if (picture.has_camera == 0 || picture.metric_depth.data == nullptr)
    throw Error(ErrorCode::kUsage, std::string("the picture \"") + picture.name + "\" has no camera or no depth");
  const auto put = [&](const std::string& kind, std::span<const std::byte> bytes) {
    std::string name = kind + "/" + picture.name + ".png";
    const fs::path path = path_inside(folder_ / kind, picture.name + std::string(".png"));
    make_folder(path.parent_path());
    write_file(path, bytes);
    return name;
  };
  Json frame = numbers_of(picture.camera);
  frame["file_path"] = put("images", encode_png(color_of(picture.color)));
  frame["depth_file_path"] = put("depth", encode_png16(millimetres_of(metric_depth_of(picture.metric_depth))));
  if (picture.labels.data != nullptr) frame["label_file_path"] = put("mask", encode_png(labels_of(picture.labels)));
  frame["transform_matrix"] = matrix_of(picture);
  frame["time"] = picture.time;
  for (std::size_t i = 0; i < picture.label_count; ++i) {
    const KinoraLabel& label = picture.label_meanings[i];
    label_meanings_[std::to_string(label.label)] = {{"name", label.name}, {"kind", label.kind}};
  }
  frames_.push_back(std::move(frame));
}

void DataSetWriter::finish() const {
  if (frames_.empty()) throw Error(ErrorCode::kFailure, folder_.string() + ": no picture was written");
  // What all frames share stands above them.
  Json json = {{"camera_model", "OPENCV"}, {"depth_unit_scale_factor", kMillimetre}};
  json["kinora"] = {{"software", "Kinora"},
                    {"axes", "metres; cameras: x right, y up, z backward; world: x right, y down, z forward"}};
  for (const auto& [name, value] : facts_) json["kinora"][name] = value;
  const double first = frames_.front()["time"];
  const double last = frames_.back()["time"];
  std::size_t times = 1; // of one time there may be several views
  for (std::size_t i = 1; i < frames_.size(); ++i) times += frames_[i]["time"] > frames_[i - 1]["time"] ? 1U : 0U;
  if (last > first) json["fps"] = static_cast<double>(times - 1) / (last - first);
  Json frames = frames_;
  for (const char* key : {"w", "h", "fl_x", "fl_y", "cx", "cy"}) {
    const bool shared =
        std::ranges::all_of(frames_, [&](const Json& frame) { return frame[key] == frames_.front()[key]; });
    if (!shared) continue;
    json[key] = frames_.front()[key];
    for (Json& frame : frames) frame.erase(key);
  }
  json["frames"] = std::move(frames);
  const auto write = [&](const char* name, const Json& content) {
    const std::string text = content.dump(1) + "\n";
    write_file(folder_ / name, std::as_bytes(std::span(text)));
  };
  if (!label_meanings_.empty()) write("labels.json", label_meanings_);
  write("transforms.json", json);
}

} // namespace kinora::formats
