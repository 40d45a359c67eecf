#include "rgbd_folder/folder_reader.h"

#include "common/capture_info.h"
#include "common/files.h"
#include "core/error.h"
#include "core/image_codec.h"
#include "core/jpeg_decoder.h"
#include "rgbd_folder/trajectory.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr int kFramesToAgreeOnSize = 3;

template <class T> std::string size_of(const Image<T>& image) {
  return std::to_string(image.width()) + "x" + std::to_string(image.height());
}

ColorImage read_color(const fs::path& path) { return decode_color(read_file(path), path.string()); }
DepthImage16 read_depth(const fs::path& path) { return decode_depth16(read_file(path), path.string()); }

} // namespace

FolderReader::FolderReader(Listing listing, const fs::path& folder, bool read_masks)
    : listing_(std::move(listing)), read_masks_(read_masks) {
  has_masks_ = read_masks_ && std::any_of(listing_.frames.begin(), listing_.frames.end(),
                                          [](const FrameFiles& frame) { return !frame.masks.empty(); });
  find_image_size();
  labels_ = LabelTable::read(folder);
  warnings_.set(listing_.warnings);
}

/// Settles the camera's image size: from the calibration where it says so, else from images that agree.
void FolderReader::find_image_size() {
  std::string first_problem;
  std::map<std::pair<int, int>, int> votes; // width and height of pairs of the same size
  int pairs = 0;
  std::string mismatch;
  for (const FrameFiles& frame : listing_.frames) {
    if (pairs == kFramesToAgreeOnSize) break;
    try {
      if (!frame.problem.empty()) throw Error(ErrorCode::kCorruptInput, frame.problem);
      const ColorImage color = read_color(frame.color);
      const DepthImage16 depth = read_depth(frame.depth);
      ++pairs;
      if (listing_.depth_camera || color.same_size(depth))
        ++votes[{color.width(), color.height()}];
      else
        mismatch = frame.depth.string() + ": is " + size_of(depth) + " but its colour image is " + size_of(color) +
                   "; register depth to colour first (one depth pixel per colour pixel)";
    } catch (const Error& error) {
      if (first_problem.empty()) first_problem = error.what();
    }
  }
  if (pairs == 0)
    throw Error(
        ErrorCode::kCorruptInput,
        (first_problem.empty() ? listing_.calibration.source.string() + ": no frames beside it" : first_problem) +
            "; no frame of this capture can be read");
  if (votes.empty()) throw Error(ErrorCode::kCorruptInput, mismatch);
  const auto [width, height] = std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
                                 return a.second < b.second;
                               })->first;
  Intrinsics& intrinsics = listing_.calibration.intrinsics;
  const std::string source = listing_.calibration.source.string();
  if ((intrinsics.width != 0 && intrinsics.width != width) || (intrinsics.height != 0 && intrinsics.height != height))
    throw Error(ErrorCode::kCorruptInput, source + ": is for images of " + std::to_string(intrinsics.width) + "x" +
                                              std::to_string(intrinsics.height) + " pixels, but the images have " +
                                              std::to_string(width) + "x" + std::to_string(height) +
                                              "; correct width, height and the intrinsics with them");
  intrinsics.width = width;
  intrinsics.height = height;
  intrinsics.validate(source);
}

void FolderReader::fill_info(KinoraCaptureInfo& info) const {
  const Calibration& calibration = listing_.calibration;
  info.frame_count = static_cast<std::int64_t>(listing_.frames.size());
  info.start_time = listing_.frames.front().time;
  info.frames_per_second = listing_.frames_per_second;
  info.camera = camera_of(calibration.intrinsics, calibration.distortion);
  info.has_poses = listing_.has_poses ? 1 : 0;
  info.has_masks = has_masks_ ? 1 : 0;
  labels_.fill(info);
  warnings_.fill(info);
  if (!listing_.depth_camera) return;
  const DepthCamera& depth = *listing_.depth_camera;
  set_depth_camera(info, camera_of(depth.intrinsics, depth.distortion), depth.depth_to_color);
}

void FolderReader::read_images(const FrameFiles& files) {
  const Intrinsics& color = listing_.calibration.intrinsics;
  const auto check_size = [&](const auto& image, const Intrinsics& expected, const fs::path& path) {
    if (image.width() != expected.width || image.height() != expected.height)
      throw Error(ErrorCode::kCorruptInput, path.string() + ": is " + size_of(image) + ", not " +
                                                std::to_string(expected.width) + "x" + std::to_string(expected.height) +
                                                " as the others");
  };
  color_bytes_ = read_file(files.color);
  color_ = decode_color(color_bytes_, files.color.string());
  check_size(color_, color, files.color);
  depth_ = read_depth(files.depth);
  check_size(depth_, listing_.depth_camera ? listing_.depth_camera->intrinsics : color, files.depth);
  mask_ = LabelImage();
  if (!read_masks_ || files.masks.empty()) return;
  mask_ = read_masks(files);
  check_size(mask_, color, files.masks.front());
}

/// Several masks of one frame, one per thing, become one: the first that has a label at a pixel gives it.
LabelImage FolderReader::read_masks(const FrameFiles& files) const {
  LabelImage merged;
  for (const fs::path& path : files.masks) {
    LabelImage mask = decode_labels(read_file(path), path.string());
    if (merged.empty()) {
      merged = std::move(mask);
      continue;
    }
    if (!merged.same_size(mask))
      throw Error(ErrorCode::kCorruptInput,
                  path.string() + ": is " + size_of(mask) + ", not " + size_of(merged) + " as the frame's other mask");
    for (std::size_t i = 0; i < merged.pixel_count(); ++i)
      if (merged.data()[i] == 0) merged.data()[i] = mask.data()[i];
  }
  return merged;
}

KinoraStatus FolderReader::next(KinoraFrame& frame) {
  if (next_ >= listing_.frames.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const FrameFiles& files = listing_.frames[next_++];
  frame.time = files.time;
  if (!files.problem.empty()) throw Error(ErrorCode::kCorruptInput, files.problem);
  if (!files.pose_file.empty())
    set_pose(frame, read_pose_file(files.pose_file));
  else if (files.camera_to_world)
    set_pose(frame, *files.camera_to_world);
  read_images(files);
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  if (frame.struct_size >= sizeof(KinoraFrame) && is_jpeg(color_bytes_)) {
    frame.color_jpeg = color_bytes_.data();
    frame.color_jpeg_bytes = color_bytes_.size();
  }
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = listing_.calibration.depth_unit.value_or(0.001);
  frame.labels = view_of(mask_, KINORA_PIXEL_U8);
  return KINORA_OK;
}

void FolderReader::seek(std::int64_t index) { next_ = checked_seek(index, listing_.frames.size()); }

} // namespace kinora::formats
