#include "exr/exr_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include "common/float_depth.h"
#include "core/error.h"
#include "core/linear_light.h"
#include "exr/channel_names.h"
#include "exr/sequence_probe.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr int kMaxSide = 16384;

/// The library looks at these when it has read a header, before it allocates anything for pixels.
void limit_sizes() {
  static std::once_flag once;
  std::call_once(once, [] {
    Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
    Imf::Header::setMaxTileSize(kMaxSide, kMaxSide);
  });
}

/// Calls, and names the file in what the library throws.
template <class Call> auto named(const fs::path& path, const Call& call) {
  limit_sizes();
  try {
    return call();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    const std::string why = error.what();
    throw Error(ErrorCode::kCorruptInput,
                path.string() + ": cannot be read as OpenEXR (" + why.substr(0, why.find('\n')) + ")");
  }
}

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

std::optional<double> number_in(const Imf::Header& header, const char* name) {
  const auto* attribute = header.findTypedAttribute<Imf::DoubleAttribute>(name);
  if (attribute == nullptr || !std::isfinite(attribute->value())) return std::nullopt;
  return attribute->value();
}

/// A pose of its own in double goes before OpenEXR's, which is of floats and the other way round.
std::optional<SE3> pose_in(const Imf::Header& header, const fs::path& path) {
  Eigen::Matrix4d pose;
  const std::string what = path.string() + ": the camera's pose";
  if (const auto* exact = header.findTypedAttribute<Imf::M44dAttribute>("camera_to_world"); exact != nullptr) {
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) pose(r, c) = exact->value()[r][c];
    return rigid_from_matrix(pose, what.c_str());
  }
  if (!Imf::hasWorldToCamera(header)) return std::nullopt;
  const Imath::M44f& rows = Imf::worldToCamera(header); // Imath's vectors are rows
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) pose(r, c) = static_cast<double>(rows[c][r]);
  const Eigen::Vector4d axes(1, -1, -1, 1);
  pose = axes.asDiagonal() * pose * axes.asDiagonal();
  return rigid_from_matrix(pose, what.c_str()).inverse();
}

std::optional<Intrinsics> intrinsics_in(const Imf::Header& header, int width, int height) {
  const auto fx = number_in(header, "fl_x"), fy = number_in(header, "fl_y");
  const auto cx = number_in(header, "cx"), cy = number_in(header, "cy");
  if (!fx || !fy || !cx || !cy) return std::nullopt;
  return Intrinsics{width, height, *fx, *fy, *cx - 0.5, *cy - 0.5};
}

/// The nearest code of sRGB for each half, by its bits; 0 for what is no number.
const std::array<std::uint8_t, 65536>& srgb_codes() {
  static const std::array<std::uint8_t, 65536> codes = [] {
    std::array<std::uint8_t, 65536> made{};
    for (std::size_t bits = 0; bits < made.size(); ++bits) {
      const auto value =
          static_cast<double>(static_cast<float>(half(half::FromBits, static_cast<std::uint16_t>(bits))));
      if (!(value > 0)) continue;
      made[bits] = static_cast<std::uint8_t>(std::lround(255 * srgb_of_linear(std::min(value, 1.0))));
    }
    return made;
  }();
  return codes;
}

/// One channel after another out of a file, as large as the picture.
class ExrPixels {
public:
  ExrPixels(Imf::InputFile& file, const fs::path& path, int width, int height)
      : file_(file), path_(path), width_(width), height_(height), window_(file.header().dataWindow()),
        shown_(file.header().displayWindow()) {}

  bool has(const std::string& name) const { return file_.header().channels().findChannel(name) != nullptr; }

  /// Gives every pixel's value to `put`(index, value).
  template <class T, class Put> void read(const std::string& name, Imf::PixelType type, const Put& put) {
    const Imf::Channel& channel = *file_.header().channels().findChannel(name);
    if (channel.xSampling != 1 || channel.ySampling != 1)
      fail(path_, "the channel " + name + " has fewer pixels than the picture; write all channels in full size");
    const int columns = window_.max.x - window_.min.x + 1;
    const int rows = window_.max.y - window_.min.y + 1;
    std::vector<T> values(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    Imf::FrameBuffer buffer;
    buffer.insert(name, Imf::Slice::Make(type, values.data(), window_));
    file_.setFrameBuffer(buffer);
    file_.readPixels(window_.min.y, window_.max.y);
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const int column = u + shown_.min.x - window_.min.x;
        const int row = v + shown_.min.y - window_.min.y;
        if (column < 0 || column >= columns || row < 0 || row >= rows) continue;
        put(static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u),
            values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                   static_cast<std::size_t>(column)]);
      }
    }
  }

private:
  Imf::InputFile& file_;
  const fs::path& path_;
  int width_;
  int height_;
  Imath::Box2i window_;
  Imath::Box2i shown_;
};

void check_window(const Imath::Box2i& window, const fs::path& path) {
  const auto side = [](int from, int to) { return static_cast<std::int64_t>(to) - from + 1; };
  const std::int64_t width = side(window.min.x, window.max.x);
  const std::int64_t height = side(window.min.y, window.max.y);
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    fail(path, "its size is absurd; pictures have 1 to 16384 pixels on a side");
  if (std::abs(static_cast<std::int64_t>(window.min.x)) > kMaxSide ||
      std::abs(static_cast<std::int64_t>(window.min.y)) > kMaxSide)
    fail(path, "its window is absurdly far from the picture");
}

/// Before anything is allocated: the library believes every size.
void check_bytes(const Imf::Header& header, const fs::path& path) {
  constexpr std::uint64_t kMaxPixelsPerByte = 512;                  // as for JPEG; of a packed picture of one colour
  constexpr std::uint64_t kMaxEmptyPixels = std::uint64_t{1} << 24; // around a small window
  const auto pixels = [](const Imath::Box2i& window) {
    return static_cast<std::uint64_t>(window.max.x - window.min.x + 1) *
           static_cast<std::uint64_t>(window.max.y - window.min.y + 1);
  };
  const std::uint64_t stored = pixels(header.dataWindow());
  if (stored / kMaxPixelsPerByte > fs::file_size(path) ||
      pixels(header.displayWindow()) > std::max(stored, kMaxEmptyPixels))
    fail(path, "has far fewer bytes than a picture of its size");
}

std::uint16_t units_of(float metres, std::optional<double> unit) {
  if (!unit) return depth_units(static_cast<double>(metres));
  const double units = std::round(static_cast<double>(metres) / *unit);
  return units > 0 && units <= 65535 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
}

LabelImage read_bytes(ExrPixels& pixels, const std::string& name, int width, int height) {
  LabelImage image(width, height, 1, 0);
  pixels.read<std::uint32_t>(name, Imf::UINT, [&](std::size_t i, std::uint32_t value) {
    image.data()[i] = static_cast<std::uint8_t>(std::min(value, 255U));
  });
  return image;
}

} // namespace

ExrHead read_exr_head(const fs::path& path) {
  (void)exr_channel_names(path);
  return named(path, [&] {
    const Imf::InputFile file(path.c_str());
    const Imf::Header& header = file.header();
    check_window(header.displayWindow(), path);
    check_window(header.dataWindow(), path);
    check_bytes(header, path);
    ExrHead head;
    head.width = header.displayWindow().max.x - header.displayWindow().min.x + 1;
    head.height = header.displayWindow().max.y - header.displayWindow().min.y + 1;
    head.time = number_in(header, "time");
    if (Imf::hasFramesPerSecond(header) && Imf::framesPerSecond(header).d != 0)
      head.frames_per_second = static_cast<double>(Imf::framesPerSecond(header));
    head.camera_to_world = pose_in(header, path);
    head.intrinsics = intrinsics_in(header, head.width, head.height);
    head.has_labels = header.channels().findChannel("id") != nullptr;
    head.depth_unit = number_in(header, "depth_unit");
    if (head.depth_unit && !(*head.depth_unit > 1e-9 && *head.depth_unit <= 1)) fail(path, "\"depth_unit\" is absurd");
    return head;
  });
}

ExrFrame read_exr_frame(const fs::path& path, const ExrHead& head) {
  return named(path, [&] {
    Imf::InputFile file(path.c_str());
    std::vector<std::string> names;
    for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it)
      names.emplace_back(it.name());
    const ExrChannels chosen = choose_channels(names);
    if (!chosen.has_color) fail(path, "has no colour; write channels R, G and B");
    if (chosen.depth.empty()) fail(path, "has no depth; write a channel Z");
    ExrPixels pixels(file, path, head.width, head.height);
    ExrFrame frame;
    frame.color = ColorImage(head.width, head.height, 3, 0);
    const std::array<std::uint8_t, 65536>& codes = srgb_codes();
    for (std::size_t c = 0; c < 3; ++c)
      pixels.read<half>(chosen.color + "RGB"[c], Imf::HALF,
                        [&](std::size_t i, half value) { frame.color.data()[3 * i + c] = codes[value.bits()]; });
    frame.depth_unit = head.depth_unit.value_or(kFloatDepthUnit);
    frame.depth = DepthImage16(head.width, head.height, 1, 0);
    pixels.read<float>(chosen.depth, Imf::FLOAT,
                       [&](std::size_t i, float metres) { frame.depth.data()[i] = units_of(metres, head.depth_unit); });
    if (pixels.has("id")) frame.labels = read_bytes(pixels, "id", head.width, head.height);
    if (pixels.has("confidence")) {
      frame.confidence = LabelImage(head.width, head.height, 1, 0);
      pixels.read<float>("confidence", Imf::FLOAT, [&](std::size_t i, float share) {
        frame.confidence.data()[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0F, 1.0F)));
      });
    }
    if (pixels.has("infrared")) {
      frame.infrared = DepthImage16(head.width, head.height, 1, 0);
      pixels.read<std::uint32_t>("infrared", Imf::UINT, [&](std::size_t i, std::uint32_t value) {
        frame.infrared.data()[i] = static_cast<std::uint16_t>(std::min(value, 65535U));
      });
    }
    return frame;
  });
}

} // namespace kinora::formats
