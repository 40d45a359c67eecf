// A capture with its truth as a folder: samples/README.md says what lies where.
#pragma once

#include <filesystem>

#include "scene.h"

namespace kinora::simulator {

/// Plays the first `frames` frames of the scene before its sensor and writes them, with their truth, to `folder`, which
/// is made. The same scene gives the same bytes. Throws Error(kUnwritableOutput).
void write_capture(const Scene& scene, const std::filesystem::path& folder, int frames);

} // namespace kinora::simulator
