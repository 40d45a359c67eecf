#include "exr/sequence_writer.h"

#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "common/calibration.h"
#include "common/files.h"
#include "common/pictures.h"
#include "core/error.h"

namespace kinora::formats {
namespace {

std::string six_digits(std::size_t number) {
  const std::string digits = std::to_string(number);
  return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

template <class T> std::vector<std::uint32_t> numbers_of(const Image<T>& image) {
  return {image.data(), image.data() + image.pixel_count()};
}

void add_exact_pose(const KinoraFrame& frame, ExrPicture& picture) {
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  picture.add_pose(SE3(RowMajor(Eigen::Map<const RowMajor>(frame.camera_to_world))));
  Imath::M44d matrix;
  std::copy(std::begin(frame.camera_to_world), std::end(frame.camera_to_world), &matrix[0][0]);
  picture.header().insert("camera_to_world", Imf::M44dAttribute(matrix));
}

} // namespace

void ExrSequenceWriter::set_capture(const KinoraCaptureInfo& info) {
  camera_ = info.camera;
  frames_per_second_ = info.frames_per_second;
  labels_ = LabelTable::of(info);
}

std::string ExrSequenceWriter::write(const KinoraFrame& frame) {
  for (const KinoraImage* image : {&frame.color, &frame.depth})
    if (image->width != camera_.width || image->height != camera_.height)
      return "frame " + std::to_string(frame.index) + " is left out: a picture of it has another size than the camera";
  if (written_ == 0) depth_unit_ = frame.depth_unit;
  ExrPicture picture(camera_.width, camera_.height, compression_);
  picture.add_colors(color_of(frame.color));
  const DepthImage16 depth = depth_of(frame.depth);
  std::vector<float> metres(depth.pixel_count());
  for (std::size_t i = 0; i < metres.size(); ++i) metres[i] = static_cast<float>(depth.data()[i] * frame.depth_unit);
  picture.add("Z", std::move(metres));
  if (frame.confidence.data != nullptr) picture.add_confidence(confidence_of(frame.confidence));
  const auto add_numbers = [&](const char* name, const auto& image) {
    picture.require_size(image.width(), image.height());
    picture.add(name, numbers_of(image));
  };
  if (frame.infrared.data != nullptr) add_numbers("infrared", depth_of(frame.infrared));
  if (frame.labels.data != nullptr) add_numbers("id", labels_of(frame.labels));
  picture.add_intrinsics(camera_);
  if (frame.has_pose != 0) add_exact_pose(frame, picture);
  picture.header().insert("depth_unit", Imf::DoubleAttribute(frame.depth_unit));
  picture.header().insert("time", Imf::DoubleAttribute(frame.time));
  picture.header().insert("software", Imf::StringAttribute("Kinora"));
  const std::filesystem::path path = folder_ / (six_digits(written_) + ".exr");
  write_file(path, picture.bytes(path.string()));
  ++written_;
  return {};
}

void ExrSequenceWriter::finish() const {
  if (written_ == 0) throw Error(ErrorCode::kFailure, folder_.string() + ": a capture needs at least one frame");
  write_calibration(folder_, camera_, frames_per_second_, depth_unit_);
  labels_.write(folder_);
}

} // namespace kinora::formats
