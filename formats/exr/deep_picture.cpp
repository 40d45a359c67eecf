#include "exr/deep_picture.h"

#include <algorithm>

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfPartType.h>

#include "common/pictures.h"
#include "core/error.h"
#include "exr/exr_picture.h"

namespace kinora::formats {
namespace {

struct Sample {
  float depth;
  std::array<half, 4> color; // R G B A
  std::uint32_t label;
};

/// Mean of the depths that are at most two pixels away; 0 if there are none.
float depth_beside(const Image<float>& depth, int u, int v) {
  constexpr int kReach = 2;
  float sum = 0;
  int count = 0;
  for (int y = std::max(0, v - kReach); y <= std::min(depth.height() - 1, v + kReach); ++y) {
    for (int x = std::max(0, u - kReach); x <= std::min(depth.width() - 1, u + kReach); ++x) {
      if (!(depth.at(x, y) > 0)) continue;
      sum += depth.at(x, y);
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<float>(count) : 0;
}

void add_layer(const KinoraPicture& layer, int width, std::vector<std::vector<Sample>>& pixels) {
  const ColorImage color = color_of(layer.color);
  const Image<float> depth = metric_depth_of(layer.metric_depth);
  if (color.width() != width || color.pixel_count() != pixels.size() || color.channels() != 4 ||
      depth.width() != width || depth.pixel_count() != pixels.size())
    throw Error(ErrorCode::kUsage, "the layers of one picture have different sizes or no opacity");
  const std::uint32_t label = layer.label_count > 0 ? static_cast<std::uint32_t>(layer.label_meanings[0].label) : 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint8_t* pixel = color.data() + 4 * i;
    if (pixel[3] == 0) continue;
    const int u = static_cast<int>(i % static_cast<std::size_t>(width));
    const int v = static_cast<int>(i / static_cast<std::size_t>(width));
    const float z = depth.at(u, v) > 0 ? depth.at(u, v) : depth_beside(depth, u, v);
    if (!(z > 0)) continue;
    const float alpha = static_cast<float>(pixel[3]) / 255;
    Sample sample{z, {}, label};
    for (std::size_t c = 0; c < 3; ++c) sample.color[c] = linear_codes()[pixel[c]] * alpha;
    sample.color[3] = alpha;
    pixels[i].push_back(sample);
  }
}

/// One number of all samples, in the order of pixels, and where those of each pixel begin.
template <class T> class DeepChannel {
public:
  template <class Get> DeepChannel(const std::vector<std::vector<Sample>>& pixels, const Get& get) {
    for (const auto& samples : pixels)
      for (const Sample& sample : samples) values_.push_back(get(sample));
    T* at = values_.data();
    for (const auto& samples : pixels) {
      begins_.push_back(at);
      at += samples.size();
    }
  }
  void add_to(Imf::DeepFrameBuffer& buffer, Imf::Header& header, const char* name, Imf::PixelType type) {
    const auto width = static_cast<std::size_t>(header.dataWindow().max.x) + 1;
    header.channels().insert(name, Imf::Channel(type));
    buffer.insert(
        name, Imf::DeepSlice(type, reinterpret_cast<char*>(begins_.data()), sizeof(T*), sizeof(T*) * width, sizeof(T)));
  }

private:
  std::vector<T> values_;
  std::vector<T*> begins_;
};

} // namespace

std::vector<std::byte> deep_bytes(std::span<const KinoraPicture> layers, const Imf::Header& described,
                                  const std::string& name) {
  const int width = described.dataWindow().max.x + 1;
  const int height = described.dataWindow().max.y + 1;
  std::vector<std::vector<Sample>> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (const KinoraPicture& layer : layers) add_layer(layer, width, pixels);
  std::vector<unsigned> counts;
  for (auto& samples : pixels) {
    std::ranges::stable_sort(samples, {}, &Sample::depth);
    counts.push_back(static_cast<unsigned>(samples.size()));
  }
  Imf::Header header = described;
  header.setType(Imf::DEEPSCANLINE);
  header.compression() = Imf::ZIPS_COMPRESSION; // of those that deep images may have
  Imf::DeepFrameBuffer buffer;
  buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), sizeof(unsigned),
                                           sizeof(unsigned) * static_cast<std::size_t>(width)));
  const auto color = [&](std::size_t c) {
    return DeepChannel<half>(pixels, [c](const Sample& sample) { return sample.color[c]; });
  };
  std::array<DeepChannel<half>, 4> colors{color(0), color(1), color(2), color(3)};
  const char* const names[] = {"R", "G", "B", "A"};
  for (std::size_t c = 0; c < colors.size(); ++c) colors[c].add_to(buffer, header, names[c], Imf::HALF);
  DeepChannel<float> depths(pixels, [](const Sample& sample) { return sample.depth; });
  depths.add_to(buffer, header, "Z", Imf::FLOAT);
  DeepChannel<std::uint32_t> labels(pixels, [](const Sample& sample) { return sample.label; });
  labels.add_to(buffer, header, "id", Imf::UINT);
  return bytes_written(name, [&](Imf::OStream& stream) {
    Imf::DeepScanLineOutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  });
}

} // namespace kinora::formats
