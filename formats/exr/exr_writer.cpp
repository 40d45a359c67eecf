#include "exr/exr_writer.h"

#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "common/files.h"
#include "common/pictures.h"

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

void add_labels(const KinoraPicture& given, ExrPicture& picture) {
  const Image<std::uint8_t> labels = labels_of(given.labels);
  picture.require_size(labels.width(), labels.height());
  picture.add("id", std::vector<std::uint32_t>(labels.data(), labels.data() + labels.pixel_count()));
  std::string meanings;
  for (std::size_t i = 0; i < given.label_count; ++i) {
    const KinoraLabel& label = given.label_meanings[i];
    meanings += (meanings.empty() ? "" : ", ") + std::to_string(label.label) + " " + label.name;
  }
  picture.header().insert("labels", Imf::StringAttribute(meanings));
}

} // namespace

void ExrWriter::write(const KinoraPicture& given) {
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const std::filesystem::path path = files_.next(given.name);
  const ColorImage color = color_of(given.color);
  ExrPicture picture(color.width(), color.height(), compression_);
  picture.add_colors(color);
  if (given.metric_depth.data != nullptr) {
    const Image<float> depth = metric_depth_of(given.metric_depth);
    picture.require_size(depth.width(), depth.height());
    picture.add("Z", std::vector<float>(depth.data(), depth.data() + depth.pixel_count()));
  }
  if (given.normal.data != nullptr) add_normals(normal_of(given.normal), picture);
  if (given.confidence.data != nullptr) picture.add_confidence(confidence_of(given.confidence));
  if (given.labels.data != nullptr) add_labels(given, picture);
  if (given.has_camera != 0) {
    picture.add_intrinsics(given.camera);
    picture.add_pose(SE3(RowMajor(Eigen::Map<const RowMajor>(given.camera_to_world))));
  }
  picture.header().insert("time", Imf::DoubleAttribute(given.time));
  picture.header().insert("software", Imf::StringAttribute("Kinora"));
  write_file(path, picture.bytes(path.string()));
}

} // namespace kinora::formats
