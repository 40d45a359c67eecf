/* libfreenect with one camera that is not there. It gives twelve frames, then none; its clock begins anew after three.
 * Of frame i, depth is 1000 + 10 i + pixel mod 7, and colour 20 i. */
#include <libfreenect.h>
#include <stdlib.h>
#include <unistd.h>

enum { WIDTH = 640, HEIGHT = 480, FRAMES = 12, TICKS = 2000000 /* of a thirtieth of a second */ };

static void* user;
static freenect_depth_cb depth_callback;
static freenect_video_cb video_callback;
static int sent; /* pictures: colour and depth in turn */

int freenect_init(freenect_context** context, freenect_usb_context* usb) {
  (void)usb;
  *context = (freenect_context*)&user;
  return 0;
}
int freenect_shutdown(freenect_context* context) { return context == NULL; }
void freenect_set_log_callback(freenect_context* context, freenect_log_cb callback) { (void)context, (void)callback; }
void freenect_select_subdevices(freenect_context* context, freenect_device_flags flags) { (void)context, (void)flags; }
int freenect_num_devices(freenect_context* context) { return context != NULL; }
int freenect_open_device(freenect_context* context, freenect_device** device, int index) {
  (void)context;
  *device = (freenect_device*)&sent;
  return index == 0 ? 0 : -1;
}
int freenect_close_device(freenect_device* device) { return device == NULL; }
void freenect_set_user(freenect_device* device, void* given) { (void)device, (void)(user = given); }
void* freenect_get_user(freenect_device* device) { return device == NULL ? NULL : user; }
void freenect_set_depth_callback(freenect_device* device, freenect_depth_cb callback) {
  (void)device, (void)(depth_callback = callback);
}
void freenect_set_video_callback(freenect_device* device, freenect_video_cb callback) {
  (void)device, (void)(video_callback = callback);
}
freenect_frame_mode freenect_find_video_mode(freenect_resolution resolution, freenect_video_format format) {
  freenect_frame_mode mode = {0};
  mode.is_valid = resolution == FREENECT_RESOLUTION_MEDIUM && format == FREENECT_VIDEO_RGB;
  return mode;
}
freenect_frame_mode freenect_find_depth_mode(freenect_resolution resolution, freenect_depth_format format) {
  freenect_frame_mode mode = {0};
  mode.is_valid = resolution == FREENECT_RESOLUTION_MEDIUM && format == FREENECT_DEPTH_REGISTERED;
  return mode;
}
int freenect_set_video_mode(freenect_device* device, freenect_frame_mode mode) {
  return device != NULL && mode.is_valid ? 0 : -1;
}
int freenect_set_depth_mode(freenect_device* device, const freenect_frame_mode mode) {
  return freenect_set_video_mode(device, mode);
}
int freenect_start_depth(freenect_device* device) { return device == NULL; }
int freenect_start_video(freenect_device* device) { return device == NULL; }
int freenect_stop_depth(freenect_device* device) { return device == NULL; }
int freenect_stop_video(freenect_device* device) { return device == NULL; }

int freenect_process_events_timeout(freenect_context* context, struct timeval* timeout) {
  static uint16_t depth[WIDTH * HEIGHT];
  static uint8_t color[3 * WIDTH * HEIGHT];
  const int frame = sent / 2;
  const uint32_t ticks = (uint32_t)(frame - 3) * TICKS;
  usleep(2000);
  if (context == NULL || timeout == NULL) return -1;
  if (frame == FRAMES) return 0;
  if (sent++ % 2 == 0) {
    for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i) color[i] = (uint8_t)(20 * frame);
    video_callback((freenect_device*)&sent, color, ticks);
  } else {
    for (int i = 0; i < WIDTH * HEIGHT; ++i) depth[i] = (uint16_t)(1000 + 10 * frame + i % 7);
    depth_callback((freenect_device*)&sent, depth, ticks + 1000);
  }
  return 0;
}
