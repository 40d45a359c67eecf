#include "cli/file_check.h"

#include <fmt/format.h>

#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "container/reader.h"
#include "core/error.h"
#include "recording/recording_file.h"

namespace kinora::cli {

FileCheck check_file(const std::filesystem::path& path, Progress& progress) {
  FileCheck check;
  container::Reader reader(path, container::Reading::kSalvage);
  check.kind = reader.tag(container::kKindTag).value_or("");
  container::StoredBlock block;
  while (reader.next_block(block)) progress.check();
  for (const container::Damage& damage : reader.damage().entries()) check.damage.push_back(damage.why);
  if (!reader.finished()) check.damage.push_back(fmt::format("{}: was not finished or is cut short", path.string()));
  const auto note = [&check](const auto& action) {
    try {
      action();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput) throw;
      check.damage.emplace_back(error.what());
    }
  };
  for (const container::StoredAttachment& attachment : reader.attachments())
    note([&] { reader.read_attachment(attachment); });
  if (check.kind == clip::kClipKind || check.kind == clip::kLiveClipKind) note([&] { clip::read_clip(path); });
  if (check.kind == recording::kRecordingKind || reader.find_attachment(recording::kDescriptionName) != nullptr) {
    note([&] {
      recording::RecordingFile file(path);
      for (std::string& sentence : recording::check_recording(file, [&](std::size_t) { progress.check(); }))
        check.damage.push_back(std::move(sentence));
    });
  }
  return check;
}

void throw_if_damaged(const FileCheck& check, const std::filesystem::path& path) {
  if (check.damage.empty()) return;
  throw Error(ErrorCode::kCorruptInput,
              fmt::format("{}: damaged in {} places, the first: {}; kinora recover saves what "
                          "is sound",
                          path.string(), check.damage.size(), check.damage.front()));
}

} // namespace kinora::cli
