#include "rgbd_folder/formats.h"

#include "common/boundary.h"
#include "rgbd_folder/folder_reader.h"
#include "rgbd_folder/listing.h"

/// What the interface calls a reader is, for these formats, a FolderReader.
struct KinoraReader {
  kinora::formats::FolderReader reader;
};

namespace kinora::formats {

void answer_probe(KinoraProbe* answer, int confidence, const std::string& reason) {
  answer->confidence = confidence;
  std::snprintf(answer->reason, sizeof answer->reason, "%s", reason.c_str());
}

namespace {

template <Listing (*list)(const std::filesystem::path&)>
KinoraStatus open_folder(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraReader** reader,
                         KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto masks = given.find("masks");
    *reader = new KinoraReader{FolderReader(list(path), path, masks == given.end() || masks->second != "false")};
    return KINORA_OK;
  });
}

KinoraStatus folder_info(KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message) {
  return guarded(message, [&] {
    reader->reader.fill_info(*info);
    return KINORA_OK;
  });
}

KinoraStatus folder_next(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  const KinoraStatus status = guarded(message, [&] { return reader->reader.next(*frame); });
  return status == KINORA_CORRUPT ? KINORA_BAD_FRAME : status;
}

KinoraStatus folder_seek(KinoraReader* reader, int64_t index, KinoraMessage* message) {
  return guarded(message, [&] {
    reader->reader.seek(index);
    return KINORA_OK;
  });
}

void folder_close(KinoraReader* reader) { delete reader; }

const KinoraOption kOptions[] = {{"masks", "bool", "true", "Read the masks of mask/ where there are any.", nullptr}};

/// A probe reads folders, and folders may vanish or be forbidden: then it is no folder of ours.
template <void (*probe)(const char*, KinoraProbe*)> void safe_probe(const char* path, KinoraProbe* answer) {
  try {
    probe(path, answer);
  } catch (const std::exception& error) {
    answer_probe(answer, 0, error.what());
  } catch (...) {
    answer_probe(answer, 0, "an unknown exception");
  }
}

template <Listing (*list)(const std::filesystem::path&), void (*probe)(const char*, KinoraProbe*)>
constexpr KinoraFormat folder_format(const char* name, const char* description, std::uint64_t besides) {
  auto format = make_struct<KinoraFormat>();
  format.name = name;
  format.description = description;
  format.extensions = "";
  format.capabilities = KINORA_READS_FRAMES | KINORA_SEEKS | besides;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe>;
  format.open_reader = open_folder<list>;
  format.reader_info = folder_info;
  format.reader_next = folder_next;
  format.reader_seek = folder_seek;
  format.reader_close = folder_close;
  return format;
}

} // namespace

constinit const KinoraFormat kTumFormat = folder_format<list_tum, probe_tum>(
    "tum-rgbd", "TUM RGB-D folder: associations.txt, or rgb.txt and depth.txt; groundtruth.txt gives camera poses",
    KINORA_READS_POSES | KINORA_READS_MASKS);
constinit const KinoraFormat kNumberedFormat = folder_format<list_numbered, probe_numbered>(
    "numbered-folder", "folder of numbered images: color/ (or rgb/) and depth/, optionally mask/", KINORA_READS_MASKS);
constinit const KinoraFormat kThreeDMatchFormat = folder_format<list_3dmatch, probe_3dmatch>(
    "3dmatch", "3DMatch or 7-Scenes folder: frame-NNNNNN.color.*, .depth.png and .pose.txt",
    KINORA_READS_POSES | KINORA_READS_MASKS);

constinit const KinoraFormat kM3tFormat = folder_format<list_m3t, probe_m3t>(
    "m3t", "M3T sequence: a colour and a depth camera, each with a .yaml calibration beside its numbered images",
    KINORA_READS_MASKS);

constinit const KinoraFormat kTransformsFormat = folder_format<list_transforms, probe_transforms>(
    "transforms", "transforms.json with depth: data sets of nerfstudio and instant-ngp",
    KINORA_READS_POSES | KINORA_READS_MASKS);

} // namespace kinora::formats
