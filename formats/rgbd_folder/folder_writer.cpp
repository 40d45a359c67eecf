#include "rgbd_folder/folder_writer.h"

#include <charconv>

#include <nlohmann/json.hpp>

#include "common/calibration.h"
#include "common/files.h"
#include "common/pictures.h"
#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

std::string six_digits(std::size_t number) {
  const std::string digits = std::to_string(number);
  return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

/// The shortest text that reads back as the same number.
std::string exact_text(double value) {
  char text[32];
  const auto [end, error] = std::to_chars(std::begin(text), std::end(text), value);
  return {text, end};
}

const char* color_folder(FolderLayout layout) { return layout == FolderLayout::kTum ? "rgb" : "color"; }

} // namespace

FolderWriter::FolderWriter(fs::path folder, FolderLayout layout, bool still_camera)
    : folder_(std::move(folder)), layout_(layout), still_camera_(still_camera) {}

void FolderWriter::set_capture(const KinoraCaptureInfo& info) {
  if (layout_ == FolderLayout::kTransforms && info.has_poses == 0 && !still_camera_)
    throw Error(ErrorCode::kUsage, "transforms.json needs a pose for every frame, and the capture has none; if the "
                                   "camera kept still, add -O still=true");
  camera_ = info.camera;
  frames_per_second_ = info.frames_per_second;
  start_time_ = info.start_time;
  has_poses_ = info.has_poses != 0;
  labels_ = LabelTable::of(info);
  std::error_code error;
  for (const char* name : {color_folder(layout_), "depth"}) {
    fs::create_directories(folder_ / name, error);
    if (error)
      throw Error(ErrorCode::kUnwritableOutput, (folder_ / name).string() + ": cannot be made: " + error.message());
  }
}

std::string FolderWriter::misfit(const KinoraFrame& frame) const {
  const std::string number = "frame " + std::to_string(frame.index) + " is left out: ";
  for (const KinoraImage* image : {&frame.color, &frame.depth})
    if (image->width != camera_.width || image->height != camera_.height)
      return number + "a picture of it has another size than the camera";
  if (written_.empty()) return {};
  if (frame.depth_unit != depth_unit_) return number + "its unit of depth is not that of the first frame";
  if (layout_ == FolderLayout::kTum && frame.time <= written_.back().time)
    return number + "its time is not after that of the frame before";
  return {};
}

void FolderWriter::write_images(const KinoraFrame& frame, Written& written) const {
  const std::string stem = six_digits(written_.size());
  const bool jpeg = frame.struct_size >= sizeof(KinoraFrame) && frame.color_jpeg != nullptr;
  written.color = std::string(color_folder(layout_)) + "/" + stem + (jpeg ? ".jpg" : ".png");
  written.depth = "depth/" + stem + ".png";
  if (jpeg)
    write_file(folder_ / written.color, {static_cast<const std::byte*>(frame.color_jpeg), frame.color_jpeg_bytes});
  else
    write_file(folder_ / written.color, encode_png(color_of(frame.color)));
  write_file(folder_ / written.depth, encode_png16(depth_of(frame.depth)));
  if (frame.labels.data == nullptr) return;
  std::error_code ignored; // writing tells
  fs::create_directories(folder_ / "mask", ignored);
  write_file(folder_ / "mask" / (stem + ".png"), encode_png(confidence_of(frame.labels)));
}

std::string FolderWriter::write(const KinoraFrame& frame) {
  if (std::string why = misfit(frame); !why.empty()) return why;
  if (written_.empty()) depth_unit_ = frame.depth_unit;
  Written written;
  written.time = frame.time;
  if (frame.has_pose != 0) written.camera_to_world = SE3(RowMajor(Eigen::Map<const RowMajor>(frame.camera_to_world)));
  write_images(frame, written);
  written_.push_back(std::move(written));
  return {};
}

void FolderWriter::write_text(const char* name, const std::string& text) const {
  write_file(folder_ / name, std::as_bytes(std::span(text)));
}

void FolderWriter::write_tum_lists() const {
  std::string pairs = "# time colour time depth\n";
  std::string colors = "# time file\n";
  std::string depths = colors;
  std::string poses = "# time tx ty tz qx qy qz qw\n";
  for (const Written& frame : written_) {
    const std::string time = exact_text(frame.time) + " ";
    pairs.append(time).append(frame.color).append(" ").append(time).append(frame.depth).append("\n");
    colors.append(time).append(frame.color).append("\n");
    depths.append(time).append(frame.depth).append("\n");
    if (!frame.camera_to_world) continue;
    const Eigen::Vector3d t = frame.camera_to_world->translation();
    const Eigen::Quaterniond q(frame.camera_to_world->linear());
    poses += exact_text(frame.time);
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
      poses.append(" ").append(exact_text(value));
    poses += "\n";
  }
  write_text("associations.txt", pairs);
  write_text("rgb.txt", colors);
  write_text("depth.txt", depths);
  if (has_poses_) write_text("groundtruth.txt", poses);
}

void FolderWriter::write_transforms() const {
  const double* k = camera_.distortion;
  Json json = {{"w", camera_.width},     {"h", camera_.height},       {"fl_x", camera_.fx},
               {"fl_y", camera_.fy},     {"cx", camera_.cx + 0.5}, // there, pixel (0,0) has its centre at (0.5, 0.5)
               {"cy", camera_.cy + 0.5}, {"fps", frames_per_second_}, {"integer_depth_scale", depth_unit_}};
  if (!is_lens_straight(camera_))
    json.update({{"camera_model", "OPENCV"}, {"k1", k[0]}, {"k2", k[1]}, {"p1", k[2]}, {"p2", k[3]}, {"k3", k[4]}});
  json["frames"] = Json::array();
  for (const Written& frame : written_) {
    RowMajor pose = frame.camera_to_world.value_or(SE3::Identity()).matrix();
    pose.col(1) = -pose.col(1); // axes there: x right, y up, z back
    pose.col(2) = -pose.col(2);
    Json rows = Json::array();
    for (int row = 0; row < 4; ++row) rows.push_back({pose(row, 0), pose(row, 1), pose(row, 2), pose(row, 3)});
    json["frames"].push_back({{"file_path", frame.color},
                              {"depth_file_path", frame.depth},
                              {"time", frame.time - start_time_},
                              {"transform_matrix", std::move(rows)}});
  }
  write_text("transforms.json", json.dump(1) + "\n");
}

void FolderWriter::finish() const {
  if (written_.empty()) throw Error(ErrorCode::kFailure, folder_.string() + ": a capture needs at least one frame");
  if (layout_ == FolderLayout::kTransforms) return write_transforms();
  write_calibration(folder_, camera_, frames_per_second_, depth_unit_);
  labels_.write(folder_);
  if (layout_ == FolderLayout::kTum) write_tum_lists();
}

} // namespace kinora::formats
