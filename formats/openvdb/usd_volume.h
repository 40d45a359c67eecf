// A sequence of OpenVDB files as one USD volume.
// Source: Pixar, UsdVol: "Volume" and "OpenVDBAsset".
#pragma once

#include <filesystem>

#include "kinora/plugin.h"
#include "openvdb/vdb_writer.h"

namespace kinora::formats {

/// USD text with a Volume that has a field for each grid that VdbWriter writes with these settings; time samples of
/// each field's filePath show one file after another. Throws Error(kUnwritableOutput).
void write_usd_volume(const std::filesystem::path& path, const KinoraVolumeSequence& sequence,
                      const VdbSettings& settings);

} // namespace kinora::formats
