// The module sound: libav* behind sound_codec.h.
#include "sound/libav_decoder.h"
#include "sound/libav_opus.h"
#include "sound/libav_source.h"

namespace kinora::sound {

static const SoundModule kModule = {[](const std::filesystem::path& path) -> std::unique_ptr<SoundSource> {
                                      return std::make_unique<LibavSource>(path);
                                    },
                                    to_opus,
                                    [](const container::Track& track) -> std::unique_ptr<SoundDecoder> {
                                      return std::make_unique<LibavDecoder>(track);
                                    }};

} // namespace kinora::sound

extern "C" const kinora::sound::SoundModule* kinora_functions() { return &kinora::sound::kModule; }
