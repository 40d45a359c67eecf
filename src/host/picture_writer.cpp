#include "host/picture_writer.h"

#include "host/image_view.h"
#include "host/interface_struct.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

ColorImage on_black(const ColorImage& rgba) {
  ColorImage rgb(rgba.width(), rgba.height(), 3);
  for (std::size_t i = 0; i < rgba.pixel_count(); ++i) {
    const std::uint8_t* from = rgba.data() + 4 * i;
    for (std::size_t c = 0; c < 3; ++c)
      rgb.data()[3 * i + c] = static_cast<std::uint8_t>((from[c] * from[3] + 127) / 255);
  }
  return rgb;
}

KinoraCamera camera_of(const Intrinsics& from) {
  KinoraCamera camera{};
  camera.width = from.width;
  camera.height = from.height;
  camera.fx = from.fx;
  camera.fy = from.fy;
  camera.cx = from.cx;
  camera.cy = from.cy;
  return camera;
}

std::vector<KinoraLabel> labels_of(std::span<const LabelMeaning> meanings) {
  std::vector<KinoraLabel> labels;
  labels.reserve(meanings.size());
  for (const LabelMeaning& meaning : meanings)
    labels.push_back({meaning.label, meaning.name.c_str(), meaning.kind.c_str()});
  return labels;
}

KinoraPicture layer_of(const Picture& layer, const std::vector<KinoraLabel>& labels) {
  auto given = make_struct<KinoraPicture>();
  given.name = layer.name.c_str();
  given.time = layer.time;
  given.color = view_of(layer.color, KINORA_PIXEL_U8);
  given.metric_depth = view_of(layer.metric_depth, KINORA_PIXEL_F32);
  given.label_meanings = labels.data();
  given.label_count = labels.size();
  return given;
}

} // namespace

PictureWriter::PictureWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                             const Facts& facts)
    : format_(&format), writer_(open_writer(format, KINORA_WRITES_PICTURES, "pictures", path, options)) {
  describe_output(format, writer_, facts);
}

void PictureWriter::write(const Picture& picture) {
  const bool flatten = picture.color.channels() == 4 && !supports(*format_, KINORA_WRITES_ALPHA);
  const ColorImage flat = flatten ? on_black(picture.color) : ColorImage();
  auto given = make_struct<KinoraPicture>();
  given.name = picture.name.c_str();
  given.time = picture.time;
  given.color = view_of(flatten ? flat : picture.color, KINORA_PIXEL_U8);
  if (supports(*format_, KINORA_WRITES_DEPTH)) given.depth = view_of(picture.depth, KINORA_PIXEL_U16);
  if (supports(*format_, KINORA_WRITES_NORMALS)) given.normal = view_of(picture.normal, KINORA_PIXEL_F32);
  if (supports(*format_, KINORA_WRITES_CONFIDENCE)) given.confidence = view_of(picture.confidence, KINORA_PIXEL_U8);
  if (supports(*format_, KINORA_WRITES_METRIC_DEPTH))
    given.metric_depth = view_of(picture.metric_depth, KINORA_PIXEL_F32);
  const std::vector<KinoraLabel> labels = labels_of(picture.label_meanings);
  if (supports(*format_, KINORA_WRITES_LABELS) && !picture.labels.empty()) {
    given.labels = view_of(picture.labels, KINORA_PIXEL_U8);
    given.label_meanings = labels.data();
    given.label_count = labels.size();
  }
  if (supports(*format_, KINORA_WRITES_CAMERAS) && picture.camera) {
    given.has_camera = 1;
    given.camera = camera_of(picture.camera->intrinsics);
    for (int i = 0; i < 16; ++i) given.camera_to_world[i] = picture.camera->camera_to_world.matrix()(i / 4, i % 4);
  }
  std::vector<KinoraPicture> layers;
  std::vector<std::vector<KinoraLabel>> layer_labels;
  if (supports(*format_, KINORA_WRITES_PICTURE_LAYERS)) {
    for (const Picture& layer : picture.layers) {
      layer_labels.push_back(labels_of(layer.label_meanings));
      layers.push_back(layer_of(layer, layer_labels.back()));
    }
  }
  given.layers = layers.empty() ? nullptr : layers.data();
  given.layer_count = layers.size();
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_write(writer_.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
}

void PictureWriter::finish() { finish_writer(*format_, writer_); }

} // namespace kinora::host
