// The table of the formats that come with Kinora: a new format is one line here.
#include <iterator>

#include "gltf/format.h"
#include "kinora/plugin.h"
#include "mp4/format.h"
#include "openvdb/format.h"
#include "ply/format.h"
#include "png/format.h"
#include "rgbd_folder/formats.h"

const KinoraPlugin* kinora_builtin_plugin() {
  using namespace kinora::formats;
  static const KinoraFormat* const formats[] = {&kTumFormat,  &kNumberedFormat,  &kThreeDMatchFormat,
                                                &kM3tFormat,  &kPngFormat,       &mp4_format(),
                                                &kGltfFormat, &openvdb_format(), &kPlyFormat};
  static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "built-in", "", formats,
                                      std::size(formats)};
  return &plugin;
}
