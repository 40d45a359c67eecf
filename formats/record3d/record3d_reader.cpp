#include "record3d/record3d_reader.h"

#include <cstring>

#include <zip.h>

#include "common/float_depth.h"
#include "core/error.h"
#include "core/image_codec.h"
#include "core/jpeg_decoder.h"
#include "record3d/lzfse.h"

namespace kinora::formats {
namespace {

constexpr std::uint64_t kMaxEntryBytes = std::uint64_t{256} << 20;

std::string frame_file(std::size_t frame, const char* extension) { return "rgbd/" + std::to_string(frame) + extension; }

} // namespace

void Record3dReader::CloseArchive::operator()(zip* archive) const { zip_discard(archive); }

Record3dReader::Record3dReader(const std::filesystem::path& path)
    : name_(path.string()), archive_(zip_open(path.c_str(), ZIP_RDONLY, nullptr)) {
  if (!archive_)
    throw Error(ErrorCode::kNotRecognised, name_ + ": not an archive that can be read; it is truncated or no .r3d");
  if (!has("metadata")) throw Error(ErrorCode::kNotRecognised, name_ + ": an archive, but without Record3D's metadata");
  metadata_ = read_record3d_metadata(read("metadata"), name_ + ", metadata");
  count_frames();
  warning_table_.set(warnings_);
}

void Record3dReader::count_frames() {
  while (has(frame_file(frames_, ".jpg"))) ++frames_;
  if (frames_ == 0) throw Error(ErrorCode::kCorruptInput, name_ + ": holds no frame rgbd/0.jpg");
  if (!metadata_.poses.empty() && metadata_.poses.size() < frames_) {
    warnings_.push_back(name_ + ": has poses for only " + std::to_string(metadata_.poses.size()) + " of " +
                        std::to_string(frames_) + " frames; no pose is used");
    metadata_.poses.clear();
  }
  const std::vector<double>& times = metadata_.times;
  if (times.empty()) return;
  if (times.size() >= frames_ && std::is_sorted(times.begin(), times.end())) return;
  warnings_.push_back(name_ + ": the times are incomplete or out of order; frames follow at the nominal rate");
  metadata_.times.clear();
}

double Record3dReader::time_of(std::size_t frame) const {
  return metadata_.times.empty() ? static_cast<double>(frame) / metadata_.frames_per_second : metadata_.times[frame];
}

bool Record3dReader::has(const std::string& name) const {
  return zip_name_locate(archive_.get(), name.c_str(), 0) >= 0;
}

std::vector<std::byte> Record3dReader::read(const std::string& name) const {
  const auto fail = [&](const char* problem) {
    throw Error(ErrorCode::kCorruptInput, name_ + ": " + name + " " + problem);
  };
  zip_stat_t status;
  zip_stat_init(&status);
  if (zip_stat(archive_.get(), name.c_str(), 0, &status) != 0 || (status.valid & ZIP_STAT_SIZE) == 0)
    fail("is missing");
  if (status.size > kMaxEntryBytes) fail("is absurdly large");
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen(archive_.get(), name.c_str(), 0), &zip_fclose);
  if (!file) fail("cannot be read");
  std::vector<std::byte> bytes;
  std::byte piece[1 << 16];
  while (bytes.size() < status.size) { // grows with what is there, whatever the archive says
    const zip_int64_t got = zip_fread(file.get(), piece, sizeof piece);
    if (got <= 0) fail("is damaged");
    bytes.insert(bytes.end(), piece, piece + got);
  }
  return bytes;
}

std::vector<std::byte> Record3dReader::read_packed(const std::string& name, std::size_t bytes_per_pixel) const {
  const std::size_t pixels =
      static_cast<std::size_t>(metadata_.depth_width) * static_cast<std::size_t>(metadata_.depth_height);
  const std::vector<std::byte> packed = read(name);
  constexpr std::size_t kMaxRatio = 4096; // no packing of depth is better
  if (pixels * bytes_per_pixel > (packed.size() + 64) * kMaxRatio)
    throw Error(ErrorCode::kCorruptInput, name_ + ": " + name + " is far too short for its size in pixels");
  return unpack_lzfse(packed, pixels * bytes_per_pixel, name_ + ": " + name);
}

void Record3dReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(frames_);
  info.start_time = time_of(0);
  info.frames_per_second = metadata_.frames_per_second;
  info.camera = camera_of(metadata_.color, {});
  info.has_poses = metadata_.poses.empty() ? 0 : 1;
  warning_table_.fill(info);
  // Depth sees what colour sees, in fewer pixels.
  set_depth_camera(info, camera_of(metadata_.color.resized(metadata_.depth_width, metadata_.depth_height), {}),
                   SE3::Identity());
}

KinoraStatus Record3dReader::next(KinoraFrame& frame) {
  if (next_ >= frames_) return KINORA_END;
  const std::size_t index = next_++;
  frame.index = static_cast<std::int64_t>(index);
  frame.time = time_of(index);
  color_bytes_ = read(frame_file(index, ".jpg"));
  color_ = decode_color(color_bytes_, name_ + ": " + frame_file(index, ".jpg"));
  if (color_.width() != metadata_.color.width || color_.height() != metadata_.color.height)
    throw Error(ErrorCode::kCorruptInput,
                name_ + ": " + frame_file(index, ".jpg") + " has another size than the metadata says");
  const std::vector<std::byte> metres = read_packed(frame_file(index, ".depth"), sizeof(float));
  depth_ = DepthImage16(metadata_.depth_width, metadata_.depth_height);
  for (std::size_t i = 0; i < depth_.pixel_count(); ++i) {
    float value = 0;
    std::memcpy(&value, metres.data() + sizeof value * i, sizeof value);
    depth_.data()[i] = depth_units(value);
  }
  confidence_ = Image<std::uint8_t>();
  if (const std::string name = frame_file(index, ".conf"); has(name)) {
    const std::vector<std::byte> levels = read_packed(name, 1);
    confidence_ = Image<std::uint8_t>(metadata_.depth_width, metadata_.depth_height);
    std::memcpy(confidence_.data(), levels.data(), levels.size());
  }
  if (!metadata_.poses.empty()) set_pose(frame, metadata_.poses[index]);
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = kFloatDepthUnit;
  frame.confidence = view_of(confidence_, KINORA_PIXEL_U8);
  if (!is_jpeg(color_bytes_) || frame.struct_size < sizeof(KinoraFrame)) return KINORA_OK;
  frame.color_jpeg = color_bytes_.data();
  frame.color_jpeg_bytes = color_bytes_.size();
  return KINORA_OK;
}

void Record3dReader::seek(std::int64_t index) { next_ = checked_seek(index, frames_); }

} // namespace kinora::formats
