#include "exr/sequence_reader.h"

#include <algorithm>

#include "common/frame_pairs.h"
#include "core/error.h"
#include "exr/sequence_probe.h"

namespace kinora::formats {
namespace fs = std::filesystem;

ExrSequenceReader::ExrSequenceReader(const fs::path& folder, bool read_masks) : read_masks_(read_masks) {
  for (const fs::path& path : exr_files(folder)) {
    File file{path, {}, {}, 0};
    try {
      file.head = read_exr_head(path);
    } catch (const Error& error) {
      file.problem = error.what();
    }
    files_.push_back(std::move(file));
  }
  if (files_.empty()) throw Error(ErrorCode::kNotRecognised, folder.string() + ": holds no OpenEXR files");
  settle_camera(folder);
  settle_times(folder);
  has_poses_ = std::ranges::all_of(
      files_, [](const File& file) { return !file.problem.empty() || file.head.camera_to_world.has_value(); });
  has_masks_ = read_masks && std::ranges::any_of(files_, [](const File& file) { return file.head.has_labels; });
  labels_ = LabelTable::read(folder);
  warning_table_.set(warnings_);
}

const ExrHead& ExrSequenceReader::first_head() const {
  const auto whole = std::ranges::find_if(files_, [](const File& file) { return file.problem.empty(); });
  if (whole == files_.end())
    throw Error(ErrorCode::kCorruptInput, files_.front().problem + "; no frame of this capture can be read");
  return whole->head;
}

void ExrSequenceReader::settle_camera(const fs::path& folder) {
  const ExrHead& head = first_head();
  if (fs::exists(folder / "intrinsics.json") || !head.intrinsics) {
    calibration_ = read_calibration({folder});
  } else {
    calibration_.intrinsics = *head.intrinsics;
    calibration_.source = folder;
  }
  Intrinsics& camera = calibration_.intrinsics;
  if (camera.width == 0) camera.width = head.width;
  if (camera.height == 0) camera.height = head.height;
  camera.validate(calibration_.source.string());
  for (File& file : files_) {
    if (file.problem.empty() && (file.head.width != camera.width || file.head.height != camera.height))
      file.problem = file.path.string() + ": is " + std::to_string(file.head.width) + "x" +
                     std::to_string(file.head.height) + ", not " + std::to_string(camera.width) + "x" +
                     std::to_string(camera.height) + " as the camera";
  }
}

/// Frames that cannot be read keep their places: after the frame before them.
void ExrSequenceReader::settle_times(const fs::path& folder) {
  const bool timed =
      std::ranges::all_of(files_, [](const File& file) { return !file.problem.empty() || file.head.time.has_value(); });
  double last = first_head().time.value_or(0);
  std::vector<double> times;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    File& file = files_[i];
    if (!timed || file.head.time) last = timed ? *file.head.time : static_cast<double>(i);
    file.time = last;
    if (file.problem.empty()) times.push_back(last);
  }
  if (!std::ranges::is_sorted(times)) {
    warnings_.push_back(folder.string() + ": the times are out of order; frames are taken in order of time");
    std::ranges::stable_sort(files_, {}, &File::time);
    std::ranges::sort(times);
  }
  const double nominal = first_head().frames_per_second.value_or(30);
  frames_per_second_ = calibration_.frames_per_second.value_or(timed ? median_rate(times) : nominal);
  if (timed) return;
  for (File& file : files_) file.time /= frames_per_second_;
}

void ExrSequenceReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(files_.size());
  info.start_time = files_.front().time;
  info.frames_per_second = frames_per_second_;
  info.camera = camera_of(calibration_.intrinsics, calibration_.distortion);
  info.has_poses = has_poses_ ? 1 : 0;
  info.has_masks = has_masks_ ? 1 : 0;
  labels_.fill(info);
  warning_table_.fill(info);
}

KinoraStatus ExrSequenceReader::next(KinoraFrame& frame) {
  if (next_ >= files_.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const File& file = files_[next_++];
  frame.time = file.time;
  if (!file.problem.empty()) throw Error(ErrorCode::kCorruptInput, file.problem);
  frame_ = read_exr_frame(file.path, file.head);
  frame.color = view_of(frame_.color, KINORA_PIXEL_U8);
  frame.depth = view_of(frame_.depth, KINORA_PIXEL_U16);
  frame.depth_unit = frame_.depth_unit;
  frame.confidence = view_of(frame_.confidence, KINORA_PIXEL_U8);
  frame.infrared = view_of(frame_.infrared, KINORA_PIXEL_U16);
  if (read_masks_) frame.labels = view_of(frame_.labels, KINORA_PIXEL_U8);
  if (has_poses_) set_pose(frame, *file.head.camera_to_world);
  return KINORA_OK;
}

void ExrSequenceReader::seek(std::int64_t index) { next_ = checked_seek(index, files_.size()); }

} // namespace kinora::formats
