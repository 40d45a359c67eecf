#include "freenect/freenect_reader.h"

#include <charconv>
#include <cstring>

#include <libfreenect.h>

#include "common/capture_info.h"
#include "core/error.h"

namespace kinora::formats {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kFramesPerSecond = 30;
constexpr double kTicksPerSecond = 60e6; // of the camera's clock, whose 32 bits begin anew after 71 s

/// The number in "freenect:N".
int number_in(const std::string& address) {
  const std::size_t colon = address.find(':');
  if (colon == std::string::npos || colon + 1 == address.size()) return 0;
  int number = 0;
  const char* const end = address.data() + address.size();
  const auto [stopped, error] = std::from_chars(address.data() + colon + 1, end, number);
  if (error != std::errc() || stopped != end || number < 0)
    throw Error(ErrorCode::kUsage, address + ": no camera is called so; write freenect:0 for the first one");
  return number;
}

/// Between two readings of a clock that begins anew; forwards or back.
double seconds_between(std::uint32_t from, std::uint32_t to) {
  return static_cast<double>(static_cast<std::int32_t>(to - from)) / kTicksPerSecond;
}

} // namespace

FreenectReader::FreenectReader(const std::string& address, double seconds, double focal_length)
    : address_(address), focal_length_(focal_length), frames_(address, seconds) {
  if (!(focal_length > 0 && focal_length < 1e5)) throw Error(ErrorCode::kUsage, "focal must be a number of pixels");
  try {
    open(number_in(address));
  } catch (...) {
    close();
    throw;
  }
  listener_ = std::thread([this] { listen(); });
}

FreenectReader::~FreenectReader() {
  stopping_ = true;
  if (listener_.joinable()) listener_.join();
  close();
}

void FreenectReader::open(int number) {
  const auto missing = [this](const std::string& why) {
    throw Error(ErrorCode::kMissingComponent, address_ + ": " + why);
  };
  if (freenect_init(&context_, nullptr) < 0) missing("USB cannot be used; is it allowed for you?");
  freenect_set_log_callback(context_, [](freenect_context*, freenect_loglevel, const char*) {});
  freenect_select_subdevices(context_, FREENECT_DEVICE_CAMERA);
  const int count = freenect_num_devices(context_);
  if (number >= count)
    missing("there is no such camera, but " + std::to_string(std::max(count, 0)) + "; plug it in, or give its number");
  if (freenect_open_device(context_, &device_, number) < 0) missing("the camera cannot be opened; is it in use?");
  freenect_set_user(device_, this);
  freenect_set_depth_callback(device_, [](freenect_device* device, void* pixels, std::uint32_t ticks) {
    static_cast<FreenectReader*>(freenect_get_user(device))->take_depth(pixels, ticks);
  });
  freenect_set_video_callback(device_, [](freenect_device* device, void* pixels, std::uint32_t ticks) {
    static_cast<FreenectReader*>(freenect_get_user(device))->take_color(pixels, ticks);
  });
  const bool started =
      freenect_set_video_mode(device_, freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB)) >= 0 &&
      freenect_set_depth_mode(device_,
                              freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_DEPTH_REGISTERED)) >= 0 &&
      freenect_start_depth(device_) >= 0 && freenect_start_video(device_) >= 0;
  if (!started) missing("the camera does not start; unplug it, and plug it in again");
}

void FreenectReader::close() {
  if (device_ != nullptr) {
    freenect_stop_depth(device_);
    freenect_stop_video(device_);
    freenect_close_device(device_);
  }
  if (context_ != nullptr) freenect_shutdown(context_);
}

void FreenectReader::listen() {
  while (!stopping_) {
    timeval timeout{0, 100'000};
    if (freenect_process_events_timeout(context_, &timeout) < 0) return; // next() waits in vain, and says so
  }
}

double FreenectReader::seconds_at(std::uint32_t ticks) {
  if (last_ticks_) clock_ += seconds_between(*last_ticks_, ticks);
  last_ticks_ = ticks;
  return clock_;
}

void FreenectReader::take_depth(const void* pixels, std::uint32_t ticks) {
  DepthImage16 depth(kWidth, kHeight);
  std::memcpy(depth.data(), pixels, depth.values().size_bytes());
  frames_.add(seconds_at(ticks), std::move(depth));
}

void FreenectReader::take_color(const void* pixels, std::uint32_t ticks) {
  ColorImage color(kWidth, kHeight, 3);
  std::memcpy(color.data(), pixels, color.values().size_bytes());
  frames_.add(seconds_at(ticks), std::move(color));
}

void FreenectReader::fill_info(KinoraCaptureInfo& info) const {
  frames_.fill_info(info, kFramesPerSecond);
  info.camera = camera_of({kWidth, kHeight, focal_length_, focal_length_, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0}, {});
}

KinoraStatus FreenectReader::next(KinoraFrame& frame) {
  frame.depth_unit = 0.001;
  return frames_.next(frame);
}

} // namespace kinora::formats
