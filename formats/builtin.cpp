// The table of the formats that come with Kinora: a new format is one line here.
#include <iterator>

#include "azure_kinect/format.h"
#include "data_set/format.h"
#include "exr/format.h"
#include "freenect/format.h"
#include "gltf/format.h"
#include "gltf_scene/format.h"
#include "kinora/plugin.h"
#include "kinora_clip/format.h"
#include "kinora_recording/format.h"
#include "mp4/format.h"
#include "obj/format.h"
#include "openni/format.h"
#include "openvdb/format.h"
#include "ply/format.h"
#include "png/format.h"
#include "record3d/format.h"
#include "rgbd_folder/formats.h"
#include "ros/format.h"
#include "stray_scanner/format.h"
#include "usd/format.h"
#include "video_pair/format.h"

const KinoraPlugin* kinora_builtin_plugin() {
  using namespace kinora::formats;
  static const KinoraFormat* const formats[] = {
      &kTumFormat,       &kNumberedFormat,     &kThreeDMatchFormat, &kM3tFormat,       &kTransformsFormat,
      &kRecordingFormat, &kClipFormat,         &kStrayFormat,       &kVideoPairFormat, &kAzureKinectFormat,
      &kRecord3dFormat,  &kRosBagFormat,       &kMcapFormat,        &kPngFormat,       &exr_sequence_format(),
      &kOniFormat,       &gltf_scene_format(), &freenect_format(),  &openni_format(),  &exr_format(),
      &mp4_format(),     &kGltfFormat,         &kUsdFormat,         &kPlyFormat,       &kObjFormat,
      &openvdb_format(), &kDataSetFormat};
  static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "built-in", "", formats,
                                      std::size(formats)};
  return &plugin;
}
