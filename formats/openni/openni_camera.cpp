#include "openni/openni_camera.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "core/error.h"
#include "openni/nominal_camera.h"

namespace kinora::formats {
namespace {

constexpr int kWidth = 640; ///< of the modes the one that is nearest
constexpr int kFramesPerSecond = 30;

int distance_of(const openni::VideoMode& mode) {
  return 100 * std::abs(mode.getResolutionX() - kWidth) + std::abs(mode.getFps() - kFramesPerSecond);
}

/// What the library says of its last failure, in parentheses.
std::string reason() {
  const std::string said = openni::OpenNI::getExtendedError();
  const std::size_t begin = said.find_first_not_of(" \t\n");
  if (begin == std::string::npos) return "";
  return " (" + said.substr(begin, said.find('\n', begin) - begin) + ")";
}

template <class T> Image<T> copy_of(const openni::VideoFrameRef& frame, int channels) {
  Image<T> copy(frame.getWidth(), frame.getHeight(), channels);
  const std::size_t row = sizeof(T) * static_cast<std::size_t>(frame.getWidth()) * static_cast<std::size_t>(channels);
  for (int v = 0; v < frame.getHeight(); ++v)
    std::memcpy(copy.pixel(0, v), static_cast<const std::byte*>(frame.getData()) + v * frame.getStrideInBytes(), row);
  return copy;
}

Intrinsics camera_of_stream(const openni::VideoStream& stream, double focal_length) {
  const openni::VideoMode mode = stream.getVideoMode();
  return nominal_camera(mode.getResolutionX(), mode.getResolutionY(),
                        static_cast<double>(stream.getHorizontalFieldOfView()),
                        static_cast<double>(stream.getVerticalFieldOfView()), focal_length);
}

} // namespace

OpenNiCamera::Library::Library(const std::string& address) {
  if (openni::OpenNI::initialize() == openni::STATUS_OK) return;
  const std::string why = reason();
  openni::OpenNI::shutdown();
  throw Error(ErrorCode::kMissingComponent, address + ": OpenNI cannot be used" + why);
}

OpenNiCamera::Library::~Library() { openni::OpenNI::shutdown(); }

OpenNiCamera::OpenNiCamera(const std::string& address, double seconds, double focal_length)
    : address_(address), frames_(address, seconds), library_(address) {
  if (!(focal_length >= 0 && focal_length < 1e5)) throw Error(ErrorCode::kUsage, "focal must be a number of pixels");
  open();
  color_camera_ = camera_of_stream(color_, focal_length);
  depth_camera_ = camera_of_stream(depth_, 0);
  registered_ = registered_ && depth_camera_.width == color_camera_.width;
  frames_per_second_ = std::max(color_.getVideoMode().getFps(), 1);
  if (focal_length == 0 && color_.getHorizontalFieldOfView() <= 0) warnings_.push_back(address_ + ": " + kUnknownView);
  if (!registered_)
    warnings_.push_back(address_ + ": the camera does not register depth to colour; the two are taken to stand in one "
                                   "place");
  warning_table_.set(warnings_);
  start(depth_, depth_listener_);
  start(color_, color_listener_);
}

OpenNiCamera::~OpenNiCamera() {
  depth_.removeNewFrameListener(&depth_listener_); // waits for a picture that is on its way
  color_.removeNewFrameListener(&color_listener_);
  depth_.destroy();
  color_.destroy();
  device_.close();
}

void OpenNiCamera::fail(const std::string& why) const {
  throw Error(ErrorCode::kMissingComponent, address_ + ": " + why);
}

std::string OpenNiCamera::uri() const {
  const std::size_t colon = address_.find(':');
  std::string name = colon == std::string::npos ? "" : address_.substr(colon + 1);
  int number = 0;
  const auto [stopped, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool is_number = error == std::errc() && stopped == name.data() + name.size();
  if (!name.empty() && !is_number) return name;
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  if (number < 0 || number >= devices.getSize())
    fail("there is no such camera, but " + std::to_string(devices.getSize()) + "; plug it in, or give its number");
  return devices[number].getUri();
}

void OpenNiCamera::open() {
  if (device_.open(uri().c_str()) != openni::STATUS_OK)
    fail("the camera cannot be opened; is it there, and not in use?" + reason());
  open_stream(depth_, openni::SENSOR_DEPTH, openni::PIXEL_FORMAT_DEPTH_1_MM);
  open_stream(color_, openni::SENSOR_COLOR, openni::PIXEL_FORMAT_RGB888);
  registered_ = device_.isImageRegistrationModeSupported(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR) &&
                device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR) == openni::STATUS_OK;
  (void)device_.setDepthColorSyncEnabled(true); // pictures that belong together come without it too, less often
}

void OpenNiCamera::open_stream(openni::VideoStream& stream, openni::SensorType sensor, openni::PixelFormat pixels) {
  const char* const kind = sensor == openni::SENSOR_DEPTH ? "depth" : "colour";
  if (!device_.hasSensor(sensor) || stream.create(device_, sensor) != openni::STATUS_OK)
    fail(std::string("the camera gives no ") + kind);
  (void)stream.setMirroringEnabled(false);
  const openni::Array<openni::VideoMode>& modes = stream.getSensorInfo().getSupportedVideoModes();
  const openni::VideoMode* best = nullptr;
  for (int i = 0; i < modes.getSize(); ++i)
    if (modes[i].getPixelFormat() == pixels && (best == nullptr || distance_of(modes[i]) < distance_of(*best)))
      best = &modes[i];
  if (best == nullptr)
    fail(std::string("the camera gives no ") + kind + (sensor == openni::SENSOR_DEPTH ? " in millimetres" : " as RGB"));
  (void)stream.setVideoMode(*best);
  if (stream.getVideoMode().getPixelFormat() != pixels)
    fail(std::string("the camera cannot change how it gives ") + kind);
}

void OpenNiCamera::start(openni::VideoStream& stream, Listener& listener) {
  if (stream.addNewFrameListener(&listener) != openni::STATUS_OK || stream.start() != openni::STATUS_OK)
    fail("the camera does not start; unplug it, and plug it in again" + reason());
}

void OpenNiCamera::Listener::onNewFrame(openni::VideoStream& stream) {
  openni::VideoFrameRef frame;
  if (stream.readFrame(&frame) != openni::STATUS_OK) return;
  const double time = 1e-6 * static_cast<double>(frame.getTimestamp());
  if (frame.getSensorType() == openni::SENSOR_DEPTH)
    frames_.add(time, copy_of<std::uint16_t>(frame, 1));
  else
    frames_.add(time, copy_of<std::uint8_t>(frame, 3));
}

void OpenNiCamera::fill_info(KinoraCaptureInfo& info) const {
  frames_.fill_info(info, frames_per_second_);
  info.camera = camera_of(color_camera_, {});
  warning_table_.fill(info);
  if (!registered_) set_depth_camera(info, camera_of(depth_camera_, {}), SE3::Identity());
}

KinoraStatus OpenNiCamera::next(KinoraFrame& frame) {
  frame.depth_unit = 0.001;
  return frames_.next(frame);
}

} // namespace kinora::formats
