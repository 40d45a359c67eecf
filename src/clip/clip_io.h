// Clips to and from Matroska files. docs/container.md specifies the payloads.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "clip/clip.h"
#include "clip/payloads/field_codec.h"
#include "container/byte_source.h"
#include "core/progress.h"

namespace kinora::clip {

/// Bytes of each part of a clip file, for `info` and reports; they add up to the file's size.
struct ByteAccount {
  struct Entry {
    std::string name; ///< "field background", "motion object", "calibration", "metadata", "container"
    std::size_t bytes;
  };
  std::vector<Entry> entries;
  std::size_t total = 0;
};

/// The clip as a reader of its file will see it, up to Clip::times, which a file keeps to the nanosecond: fields and
/// motions are quantised (field_codec.h, pose_codec.h, deformation_codec.h). Throws Error(kFailure) if the clip cannot
/// be stored.
Clip as_stored(const Clip& clip);

struct StorageOptions {
  std::vector<FieldRounding> fields = {}; ///< one for each layer; empty: usual_rounding
};

/// Writes to `path` (the caller gives a .part name and renames). The same clip gives the same bytes.
/// Throws Error(kUnwritableOutput) naming the path, also when the disk is full; kFailure if the clip contradicts itself
/// (sizes, times that do not increase, two layers of one name, numbers that are not finite).
void write_clip(const Clip& clip, const std::filesystem::path& path, const StorageOptions& options = {});

/// Reads and checks everything: sizes, ranges, checksums. The file is not trusted.
/// Throws Error: kNotRecognised (not Matroska, or no clip of ours), kCorruptInput (naming file and place).
Clip read_clip(const std::filesystem::path& path, ByteAccount* account = nullptr);
/// The same out of memory or from elsewhere.
Clip read_clip(std::unique_ptr<container::ByteSource> source, ByteAccount* account = nullptr);

/// The same of a file that may be cut or damaged: what is whole. `missing` gets one phrase for each thing that is not
/// there (missing_parts.h); it is empty if nothing is missing. Nothing comes from a payload without its checksum.
/// Layers without a field or without any motion are left out; frames behind the last that a cut file has are, too; a
/// frame without its pose or deformation gets that of the nearest one before it that has one (else after it) and is
/// lost (motion::Health). Where no motion is there, the first frame shows what keeps still. Throws as above if there is
/// nothing to show: no timeline, no camera or no layer.
Clip read_whole_parts(std::unique_ptr<container::ByteSource> source, std::vector<std::string>& missing,
                      ByteAccount* account = nullptr);

} // namespace kinora::clip
