#include "recording/lossless_video.h"

#include "core/module.h"

namespace kinora::recording {

static const LosslessModule& opened_module() {
  using Entry = const LosslessModule* (*)();
  static const LosslessModule* const opened =
      reinterpret_cast<Entry>(module_symbol("ffv1", "kinora_functions", "to write and read recordings"))();
  return *opened;
}

std::unique_ptr<LosslessEncoder> make_ffv1_encoder(const PictureShape& shape) {
  return opened_module().make_encoder(shape);
}

std::unique_ptr<LosslessDecoder> make_ffv1_decoder(const PictureShape& shape, std::span<const std::byte> private_data) {
  return opened_module().make_decoder(shape, private_data);
}

} // namespace kinora::recording
