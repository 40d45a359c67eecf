#include "exr/exr_picture.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include "core/error.h"
#include "core/linear_light.h"

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

Imf::Compression library_name(ExrCompression compression) {
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

const std::array<float, 256>& linear_codes() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> made{};
    for (std::size_t i = 0; i < made.size(); ++i)
      made[i] = static_cast<float>(linear_light(static_cast<double>(i) / 255));
    return made;
  }();
  return table;
}

std::vector<std::byte> bytes_written(const std::string& name, const std::function<void(Imf::OStream&)>& write) {
  MemoryStream stream(name);
  write(stream);
  return stream.bytes();
}

ExrCompression compression_called(const std::string& name) {
  if (name == "piz") return ExrCompression::kPiz;
  return name == "none" ? ExrCompression::kNone : ExrCompression::kZip;
}

ExrPicture::ExrPicture(int width, int height, ExrCompression compression) : header_(width, height) {
  header_.compression() = library_name(compression);
}

void ExrPicture::add(const char* name, std::vector<half> values) {
  halves_.push_back(std::move(values));
  add_slice(name, Imf::HALF, reinterpret_cast<char*>(halves_.back().data()), sizeof(half));
}

void ExrPicture::add(const char* name, std::vector<float> values) {
  floats_.push_back(std::move(values));
  add_slice(name, Imf::FLOAT, reinterpret_cast<char*>(floats_.back().data()), sizeof(float));
}

void ExrPicture::add(const char* name, std::vector<std::uint32_t> values) {
  numbers_.push_back(std::move(values));
  add_slice(name, Imf::UINT, reinterpret_cast<char*>(numbers_.back().data()), sizeof(std::uint32_t));
}

void ExrPicture::add_slice(const char* name, Imf::PixelType type, char* values, std::size_t size) {
  header_.channels().insert(name, Imf::Channel(type));
  slices_.insert(name, Imf::Slice(type, values, size, size * static_cast<std::size_t>(header_.dataWindow().max.x + 1)));
}

void ExrPicture::add_colors(const ColorImage& color) {
  const std::array<float, 256>& linear = linear_codes();
  static const std::array<half, 256> opaque = [&linear] {
    std::array<half, 256> codes;
    std::ranges::copy(linear, codes.begin());
    return codes;
  }();
  const std::size_t channels = static_cast<std::size_t>(color.channels());
  const char* const names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<half> values(color.pixel_count());
    if (channels == 3) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = opaque[color.data()[3 * i + c]];
      add(names[c], std::move(values));
      continue;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::uint8_t* pixel = color.data() + channels * i;
      values[i] = linear[pixel[c]] * (static_cast<float>(pixel[3]) / 255);
    }
    add(names[c], std::move(values));
  }
  std::vector<half> alpha(color.pixel_count(), half(1));
  for (std::size_t i = 0; i < alpha.size() && channels == 4; ++i)
    alpha[i] = static_cast<float>(color.data()[4 * i + 3]) / 255;
  add("A", std::move(alpha));
}

void ExrPicture::add_confidence(const Image<std::uint8_t>& confidence) {
  require_size(confidence.width(), confidence.height());
  std::vector<half> values(confidence.pixel_count());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(confidence.data()[i]) / 255;
  add("confidence", std::move(values));
}

void ExrPicture::add_intrinsics(const KinoraCamera& camera) {
  header_.insert("fl_x", Imf::DoubleAttribute(camera.fx));
  header_.insert("fl_y", Imf::DoubleAttribute(camera.fy));
  header_.insert("cx", Imf::DoubleAttribute(camera.cx + 0.5));
  header_.insert("cy", Imf::DoubleAttribute(camera.cy + 0.5));
}

void ExrPicture::add_pose(const SE3& camera_to_world) {
  const Eigen::Vector4d axes(1, -1, -1, 1);
  const Eigen::Matrix4d world_to_camera = axes.asDiagonal() * camera_to_world.matrix().inverse() * axes.asDiagonal();
  Imath::M44f rows; // Imath's vectors are rows
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) rows[c][r] = static_cast<float>(world_to_camera(r, c));
  }
  Imf::addWorldToCamera(header_, rows);
}

void ExrPicture::require_size(int width, int height) const {
  const Imath::Box2i& window = header_.dataWindow();
  if (width != window.max.x + 1 || height != window.max.y + 1)
    throw Error(ErrorCode::kUsage, "the images of one picture have different sizes");
}

std::vector<std::byte> ExrPicture::bytes(const std::string& name) const {
  return bytes_written(name, [this](Imf::OStream& stream) {
    Imf::OutputFile file(stream, header_);
    file.setFrameBuffer(slices_);
    file.writePixels(header_.dataWindow().max.y + 1);
  });
}

std::vector<std::byte> ExrPicture::bytes_of_views(std::vector<ExrPicture>& pictures,
                                                  const std::vector<std::string>& views, const std::string& name) {
  std::vector<Imf::Header> headers;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Imath::Box2i& window = pictures.front().header_.dataWindow();
    pictures[i].require_size(window.max.x + 1, window.max.y + 1);
    headers.push_back(pictures[i].header_);
    headers.back().setName(views[i]);
    headers.back().setView(views[i]);
    headers.back().setType(Imf::SCANLINEIMAGE);
  }
  return bytes_written(name, [&](Imf::OStream& stream) {
    Imf::MultiPartOutputFile file(stream, headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      Imf::OutputPart part(file, static_cast<int>(i));
      part.setFrameBuffer(pictures[i].slices_);
      part.writePixels(headers[i].dataWindow().max.y + 1);
    }
  });
}

} // namespace kinora::formats
