#include "exr/exr_writer.h"

#include <array>
#include <cstring>
#include <list>

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "common/files.h"
#include "common/pictures.h"
#include "core/error.h"
#include "core/linear_light.h"
#include "core/se3.h"

namespace kinora::formats {
namespace {

class MemoryStream : public Imf::OStream {
public:
  explicit MemoryStream(const std::string& name) : Imf::OStream(name.c_str()) {}
  void write(const char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (position_ + size > bytes_.size()) bytes_.resize(position_ + size);
    std::memcpy(bytes_.data() + position_, bytes, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  const std::vector<std::byte>& bytes() const { return bytes_; }

private:
  std::vector<std::byte> bytes_;
  std::size_t position_ = 0;
};

/// Of sRGB, 0 to 255.
std::array<float, 256> linear_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>(linear_light(static_cast<double>(i) / 255));
  }
  return table;
}

/// A picture's channels and header, built up one group after another.
class ExrPicture {
public:
  ExrPicture(int width, int height, Imf::Compression compression) : header_(width, height) {
    header_.compression() = compression;
  }

  void add(const char* name, std::vector<half> values) {
    halves_.push_back(std::move(values));
    add_slice(name, Imf::HALF, reinterpret_cast<char*>(halves_.back().data()), sizeof(half));
  }
  void add(const char* name, std::vector<float> values) {
    floats_.push_back(std::move(values));
    add_slice(name, Imf::FLOAT, reinterpret_cast<char*>(floats_.back().data()), sizeof(float));
  }
  void add(const char* name, std::vector<std::uint32_t> values) {
    numbers_.push_back(std::move(values));
    add_slice(name, Imf::UINT, reinterpret_cast<char*>(numbers_.back().data()), sizeof(std::uint32_t));
  }

  Imf::Header& header() { return header_; }
  /// Throws Error(kUsage) if an image is of another size than the picture.
  void require_size(int width, int height) const {
    const Imath::Box2i& window = header_.dataWindow();
    if (width != window.max.x + 1 || height != window.max.y + 1)
      throw Error(ErrorCode::kUsage, "the images of one picture have different sizes");
  }

  std::vector<std::byte> bytes(const std::string& name) {
    MemoryStream stream(name);
    {
      Imf::OutputFile file(stream, header_);
      file.setFrameBuffer(slices_);
      file.writePixels(header_.dataWindow().max.y + 1);
    }
    return stream.bytes();
  }

private:
  void add_slice(const char* name, Imf::PixelType type, char* values, std::size_t size) {
    header_.channels().insert(name, Imf::Channel(type));
    slices_.insert(name,
                   Imf::Slice(type, values, size, size * static_cast<std::size_t>(header_.dataWindow().max.x + 1)));
  }

  Imf::Header header_;
  Imf::FrameBuffer slices_;
  std::list<std::vector<half>> halves_;
  std::list<std::vector<float>> floats_;
  std::list<std::vector<std::uint32_t>> numbers_;
};

void add_colors(const ColorImage& color, ExrPicture& picture) {
  static const std::array<float, 256> linear = linear_table();
  const std::size_t channels = static_cast<std::size_t>(color.channels());
  const char* const names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<half> values(color.pixel_count());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::uint8_t* pixel = color.data() + channels * i;
      const float alpha = channels == 4 ? static_cast<float>(pixel[3]) / 255 : 1;
      values[i] = linear[pixel[c]] * alpha;
    }
    picture.add(names[c], std::move(values));
  }
  std::vector<half> alpha(color.pixel_count(), half(1));
  for (std::size_t i = 0; i < alpha.size() && channels == 4; ++i)
    alpha[i] = static_cast<float>(color.data()[4 * i + 3]) / 255;
  picture.add("A", std::move(alpha));
}

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

void add_camera(const KinoraPicture& given, Imf::Header& header) {
  Eigen::Matrix4d pose;
  for (int i = 0; i < 16; ++i) pose(i / 4, i % 4) = given.camera_to_world[i];
  const Eigen::Vector4d axes(1, -1, -1, 1);
  const Eigen::Matrix4d world_to_camera = axes.asDiagonal() * pose.inverse() * axes.asDiagonal();
  Imath::M44f rows; // Imath's vectors are rows
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) rows[c][r] = static_cast<float>(world_to_camera(r, c));
  }
  Imf::addWorldToCamera(header, rows);
  header.insert("fl_x", Imf::DoubleAttribute(given.camera.fx));
  header.insert("fl_y", Imf::DoubleAttribute(given.camera.fy));
  header.insert("cx", Imf::DoubleAttribute(given.camera.cx + 0.5));
  header.insert("cy", Imf::DoubleAttribute(given.camera.cy + 0.5));
}

Imf::Compression compression_of(ExrCompression compression) {
  switch (compression) {
  case ExrCompression::kNone:
    return Imf::NO_COMPRESSION;
  case ExrCompression::kPiz:
    return Imf::PIZ_COMPRESSION;
  default:
    return Imf::ZIP_COMPRESSION;
  }
}

} // namespace

void ExrWriter::write(const KinoraPicture& given) {
  const std::filesystem::path path = files_.next(given.name);
  const ColorImage color = color_of(given.color);
  ExrPicture picture(color.width(), color.height(), compression_of(compression_));
  add_colors(color, picture);
  if (given.metric_depth.data != nullptr) {
    const Image<float> depth = metric_depth_of(given.metric_depth);
    picture.require_size(depth.width(), depth.height());
    picture.add("Z", std::vector<float>(depth.data(), depth.data() + depth.pixel_count()));
  }
  if (given.normal.data != nullptr) add_normals(normal_of(given.normal), picture);
  if (given.confidence.data != nullptr) {
    const Image<std::uint8_t> confidence = confidence_of(given.confidence);
    picture.require_size(confidence.width(), confidence.height());
    std::vector<half> values(confidence.pixel_count());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(confidence.data()[i]) / 255;
    picture.add("confidence", std::move(values));
  }
  if (given.labels.data != nullptr) add_labels(given, picture);
  if (given.has_camera != 0) add_camera(given, picture.header());
  picture.header().insert("time", Imf::DoubleAttribute(given.time));
  picture.header().insert("software", Imf::StringAttribute("Kinora"));
  write_file(path, picture.bytes(path.string()));
}

} // namespace kinora::formats
