// A driver of OpenNI 2 for one camera that is not there; what it sees is in pattern.h. As PrimeSense's cameras do, it
// changes right and left over unless told not to. When it has given all frames it falls silent.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

#include "formats/oni_samples/pattern.h"

namespace {

using namespace kinora::test::oni;

OniVideoMode mode_of(OniSensorType sensor) {
  const bool depth = sensor == ONI_SENSOR_DEPTH;
  return {depth ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888, kWidth, kHeight,
          static_cast<int>(kFramesPerSecond)};
}

template <class Value> OniStatus answer(const Value& value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  return ONI_STATUS_OK;
}

class Stream final : public oni::driver::StreamBase {
public:
  explicit Stream(OniSensorType sensor) : sensor_(sensor) {}

  OniStatus start() override {
    started = true;
    return ONI_STATUS_OK;
  }
  void stop() override { started = false; }
  OniBool isPropertySupported(int property) override {
    return property <= ONI_STREAM_PROPERTY_VIDEO_MODE || property == ONI_STREAM_PROPERTY_MIRRORING ||
           property == ONI_STREAM_PROPERTY_MAX_VALUE;
  }
  OniStatus getProperty(int property, void* data, int* size) override {
    switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:
      return answer(OniCropping{FALSE, 0, 0, kWidth, kHeight}, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return answer(kHorizontalView, data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return answer(kVerticalView, data, size);
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return answer(mode_of(sensor_), data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return answer(10000, data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return answer(static_cast<OniBool>(mirrored_ ? TRUE : FALSE), data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
    }
  }
  OniStatus setProperty(int property, const void* data, int size) override {
    if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) return ONI_STATUS_OK; // there is one
    if (property != ONI_STREAM_PROPERTY_MIRRORING || size != static_cast<int>(sizeof(OniBool)))
      return ONI_STATUS_NOT_SUPPORTED;
    mirrored_ = *static_cast<const OniBool*>(data) != FALSE;
    return ONI_STATUS_OK;
  }

  void give(int number) {
    OniFrame* const frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    fill(*frame, number);
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }
  std::atomic<bool> started = false;

private:
  void fill(OniFrame& frame, int number) const {
    const bool depth = sensor_ == ONI_SENSOR_DEPTH;
    frame.sensorType = sensor_;
    frame.videoMode = mode_of(sensor_);
    frame.width = kWidth;
    frame.height = kHeight;
    frame.croppingEnabled = FALSE;
    frame.cropOriginX = frame.cropOriginY = 0;
    frame.stride = kWidth * (depth ? 2 : 3);
    frame.dataSize = frame.stride * kHeight;
    frame.frameIndex = number + 1;
    frame.timestamp = static_cast<std::uint64_t>(5'000'000 + std::lround(1e6 * number / kFramesPerSecond));
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const int seen = mirrored_ ? kWidth - 1 - u : u;
        const int pixel = v * kWidth + u;
        if (depth) {
          static_cast<std::uint16_t*>(frame.data)[pixel] = depth_at(seen, v, number);
        } else {
          for (int c = 0; c < 3; ++c)
            static_cast<std::uint8_t*>(frame.data)[3 * pixel + c] = color_at(seen, v, c, number);
        }
      }
    }
  }

  OniSensorType sensor_;
  std::atomic<bool> mirrored_ = true;
};

class Device final : public oni::driver::DeviceBase {
public:
  Device() : giver_([this] { give_frames(); }) {}
  ~Device() override {
    closing_ = true;
    giver_.join();
  }

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_.data();
    *count = static_cast<int>(sensors_.size());
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    auto& stream = sensor == ONI_SENSOR_DEPTH ? depth_ : color_;
    return stream = new Stream(sensor);
  }
  void destroyStream(oni::driver::StreamBase* stream) override {
    (stream == depth_.load() ? depth_ : color_) = nullptr;
    delete stream;
  }
  OniStatus setProperty(int property, const void* /*data*/, int /*size*/) override {
    return property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode /*mode*/) override { return TRUE; }

private:
  /// From when both streams are started, so that none misses a frame.
  void give_frames() {
    for (int number = 0; number < kFrames && !closing_;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      Stream* const depth = depth_;
      Stream* const color = color_;
      if (depth == nullptr || color == nullptr || !depth->started || !color->started) continue;
      depth->give(number);
      color->give(number++);
    }
  }

  std::array<OniVideoMode, 2> modes_ = {mode_of(ONI_SENSOR_DEPTH), mode_of(ONI_SENSOR_COLOR)};
  std::array<OniSensorInfo, 2> sensors_ = {OniSensorInfo{ONI_SENSOR_DEPTH, 1, &modes_[0]},
                                           OniSensorInfo{ONI_SENSOR_COLOR, 1, &modes_[1]}};
  std::atomic<Stream*> depth_ = nullptr;
  std::atomic<Stream*> color_ = nullptr;
  std::atomic<bool> closing_ = false;
  std::thread giver_;
};

class Driver final : public oni::driver::DriverBase {
public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {
    std::strcpy(info_.uri, "simulated");
    std::strcpy(info_.vendor, "nobody");
    std::strcpy(info_.name, "simulated camera");
  }
  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    deviceConnected(&info_);
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char* /*mode*/) override {
    return std::strcmp(uri, info_.uri) == 0 ? new Device : nullptr;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}

private:
  OniDeviceInfo info_{};
};

} // namespace

ONI_EXPORT_DRIVER(Driver)
