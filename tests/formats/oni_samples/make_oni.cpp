// Records the simulated camera with OpenNI's own recorder: lossless.oni and jpeg.oni beside this file were made so by
// Debian's libopenni2 2.2.0.33, as the test of live cameras does too.
// usage: make_oni FILE.oni lossless|jpeg    with simulated_camera.cpp as a driver of the library
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

#include <OpenNI.h>

int main(int count, char** words) {
  if (count != 3) return 2;
  const bool jpeg = std::strcmp(words[2], "jpeg") == 0;
  if (openni::OpenNI::initialize() != openni::STATUS_OK) return 1;
  bool good = false;
  {
    openni::Device device;
    openni::VideoStream depth;
    openni::VideoStream color;
    openni::Recorder recorder;
    good = device.open("simulated") == openni::STATUS_OK &&
           depth.create(device, openni::SENSOR_DEPTH) == openni::STATUS_OK &&
           color.create(device, openni::SENSOR_COLOR) == openni::STATUS_OK &&
           recorder.create(words[1]) == openni::STATUS_OK && recorder.attach(depth) == openni::STATUS_OK &&
           recorder.attach(color, jpeg) == openni::STATUS_OK && recorder.start() == openni::STATUS_OK;
    std::this_thread::sleep_for(std::chrono::milliseconds(300)); // its own thread begins then
    good = good && depth.start() == openni::STATUS_OK && color.start() == openni::STATUS_OK;
    std::this_thread::sleep_for(std::chrono::seconds(1)); // all frames
    if (!good) std::fprintf(stderr, "%s\n", openni::OpenNI::getExtendedError());
    recorder.stop();
    recorder.destroy();
    for (openni::VideoStream* stream : {&depth, &color}) {
      stream->stop();
      stream->destroy();
    }
    device.close();
  }
  openni::OpenNI::shutdown();
  return good ? 0 : 1;
}
