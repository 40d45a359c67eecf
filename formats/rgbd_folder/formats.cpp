#include "rgbd_folder/formats.h"

#include <iterator>

#include "common/captures.h"
#include "rgbd_folder/folder_reader.h"
#include "rgbd_folder/folder_writer.h"
#include "rgbd_folder/listing.h"

namespace kinora::formats {
namespace {

template <Listing (*list)(const std::filesystem::path&)>
std::unique_ptr<FolderReader> open_folder(const char* path, const OptionMap& options) {
  return std::make_unique<FolderReader>(list(path), path, option_is_set(options, "masks", true));
}

template <FolderLayout layout>
std::unique_ptr<FolderWriter> open_folder_writer(const char* path, const OptionMap& options) {
  return std::make_unique<FolderWriter>(path, layout, option_is_set(options, "still", false));
}

constexpr KinoraOption kMasks = {"masks", "bool", "true", "Read the masks of mask/ where there are any.", nullptr};
constexpr KinoraOption kOptions[] = {kMasks};
constexpr KinoraOption kTransformsOptions[] = {
    kMasks, {"still", "bool", "false", "Write a capture without poses as one whose camera kept still.", nullptr}};

template <Listing (*list)(const std::filesystem::path&), void (*probe)(const char*, KinoraProbe*)>
constexpr KinoraFormat folder_format(const char* name, const char* description, std::uint64_t besides) {
  auto format = make_struct<KinoraFormat>();
  format.name = name;
  format.description = description;
  format.extensions = "";
  format.capabilities = besides;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe>;
  set_reader<FolderReader, open_folder<list>>(format);
  return format;
}

constexpr KinoraFormat tum_format() {
  KinoraFormat format = folder_format<list_tum, probe_tum>(
      "tum-rgbd", "TUM RGB-D folder: associations.txt, or rgb.txt and depth.txt; groundtruth.txt gives camera poses",
      KINORA_READS_POSES | KINORA_READS_MASKS | KINORA_WRITES_TIMES | KINORA_WRITES_POSES | KINORA_WRITES_MASKS);
  set_writer<FolderWriter, open_folder_writer<FolderLayout::kTum>>(format);
  return format;
}

constexpr KinoraFormat numbered_format() {
  KinoraFormat format = folder_format<list_numbered, probe_numbered>(
      "numbered-folder",
      "folder of numbered images: color/ (or rgb/) and depth/, optionally mask/; Open3D's trajectory.log gives poses",
      KINORA_READS_POSES | KINORA_READS_MASKS | KINORA_WRITES_MASKS);
  set_writer<FolderWriter, open_folder_writer<FolderLayout::kNumbered>>(format);
  return format;
}

constexpr KinoraFormat transforms_format() {
  KinoraFormat format = folder_format<list_transforms, probe_transforms>(
      "transforms", "transforms.json with depth: data sets of nerfstudio and instant-ngp",
      KINORA_READS_POSES | KINORA_READS_MASKS | KINORA_WRITES_TIMES | KINORA_WRITES_POSES);
  format.options = kTransformsOptions;
  format.option_count = std::size(kTransformsOptions);
  set_writer<FolderWriter, open_folder_writer<FolderLayout::kTransforms>>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kTumFormat = tum_format();
constinit const KinoraFormat kNumberedFormat = numbered_format();
constinit const KinoraFormat kTransformsFormat = transforms_format();

constinit const KinoraFormat kThreeDMatchFormat = folder_format<list_3dmatch, probe_3dmatch>(
    "3dmatch", "3DMatch or 7-Scenes folder: frame-NNNNNN.color.*, .depth.png and .pose.txt",
    KINORA_READS_POSES | KINORA_READS_MASKS);

constinit const KinoraFormat kM3tFormat = folder_format<list_m3t, probe_m3t>(
    "m3t", "M3T sequence: a colour and a depth camera, each with a .yaml calibration beside its numbered images",
    KINORA_READS_MASKS);

} // namespace kinora::formats
