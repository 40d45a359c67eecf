#include "exr/exr_writer.h"

#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "common/files.h"
#include "common/pictures.h"
#include "common/world_axes.h"
#include "core/error.h"
#include "exr/deep_picture.h"

namespace kinora::formats {
namespace {

void add_normals(const Image<float>& normals, ExrPicture& picture) {
  picture.require_size(normals.width(), normals.height());
  const char* const names[] = {"N.X", "N.Y", "N.Z"};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<half> values(normals.pixel_count());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = normals.data()[3 * i + c] * (c == 0 ? 1.0F : -1.0F);
    picture.add(names[c], std::move(values));
  }
}

void add_labels(const LabelImage& labels, ExrPicture& picture) {
  picture.require_size(labels.width(), labels.height());
  picture.add("id", std::vector<std::uint32_t>(labels.data(), labels.data() + labels.pixel_count()));
}

std::string meanings_of(const KinoraPicture& given) {
  std::string meanings;
  for (std::size_t i = 0; i < given.label_count; ++i) {
    const KinoraLabel& label = given.label_meanings[i];
    meanings += (meanings.empty() ? "" : ", ") + std::to_string(label.label) + " " + label.name;
  }
  return meanings;
}

} // namespace

ExrPicture ExrWriter::described(const KinoraPicture& given, int width, int height) const {
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  ExrPicture picture(width, height, compression_);
  if (given.has_camera != 0) {
    picture.add_intrinsics(given.camera);
    picture.add_pose(SE3(RowMajor(Eigen::Map<const RowMajor>(given.camera_to_world))));
  }
  if (given.label_count > 0) picture.header().insert("labels", Imf::StringAttribute(meanings_of(given)));
  picture.header().insert("time", Imf::DoubleAttribute(given.time));
  picture.header().insert("software", Imf::StringAttribute("Kinora"));
  for (const auto& [name, value] : facts_) picture.header().insert(name, Imf::StringAttribute(value));
  picture.header().insert("axes", Imf::StringAttribute(WorldAxes().text()));
  return picture;
}

ExrPicture ExrWriter::picture_of(const KinoraPicture& given) const {
  const ColorImage color = color_of(given.color);
  ExrPicture picture = described(given, color.width(), color.height());
  picture.add_colors(color);
  if (given.metric_depth.data != nullptr) {
    const Image<float> depth = metric_depth_of(given.metric_depth);
    picture.require_size(depth.width(), depth.height());
    picture.add("Z", std::vector<float>(depth.data(), depth.data() + depth.pixel_count()));
  }
  if (given.normal.data != nullptr) add_normals(normal_of(given.normal), picture);
  if (given.confidence.data != nullptr) picture.add_confidence(confidence_of(given.confidence));
  if (given.labels.data != nullptr) add_labels(labels_of(given.labels), picture);
  return picture;
}

void ExrWriter::write(const KinoraPicture& given) {
  ExrPicture picture = picture_of(given);
  const std::filesystem::path path = files_.next(given.name);
  if (views_as_parts_) {
    hold(given, std::move(picture));
  } else {
    write_file(path, picture.bytes(path.string()));
  }
  if (given.layer_count == 0) return;
  const std::filesystem::path deep = path_beside(path, ".deep.exr");
  write_file(deep, deep_bytes(std::span(given.layers, given.layer_count),
                              described(given, given.color.width, given.color.height).header(), deep.string()));
}

void ExrWriter::hold(const KinoraPicture& given, ExrPicture picture) {
  if (time_ && given.time < *time_)
    throw Error(ErrorCode::kUsage, std::string("the view \"") + given.name +
                                       "\" follows one of a later time; give the cameras in order of time");
  if (time_ && given.time > *time_) write_views();
  time_ = given.time;
  waiting_.push_back(std::move(picture));
  names_.emplace_back(given.name);
}

void ExrWriter::write_views() {
  if (waiting_.empty()) return;
  constexpr std::size_t kDigits = 6;
  std::string number = std::to_string(written_++);
  if (number.size() < kDigits) number.insert(0, kDigits - number.size(), '0');
  const std::filesystem::path path = files_.next(number);
  write_file(path, ExrPicture::bytes_of_views(waiting_, names_, path.string()));
  waiting_.clear();
  names_.clear();
}

void ExrWriter::finish() {
  write_views();
  files_.finish();
}

} // namespace kinora::formats
