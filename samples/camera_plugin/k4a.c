/* Azure Kinect through Microsoft's SDK (1.4), depth carried to the colour camera by the SDK. What k4arecorder writes
 * Kinora reads by itself, with lenses straightened exactly; here their rational model becomes a series. */
#include <k4a/k4a.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"

enum { WIDTH = 1280, HEIGHT = 720, PATIENCE_MS = 2000 };

struct Camera {
  k4a_device_t device;
  k4a_transformation_t transformation;
  k4a_image_t depth; /* as the colour camera sees it */
  int running;
  uint8_t color[3 * WIDTH * HEIGHT];
};

static KinoraCamera camera_of(const k4a_calibration_camera_t* seen) {
  const k4a_calibration_intrinsic_parameters_t* k = &seen->intrinsics.parameters;
  const double k1 = (double)k->param.k1, k2 = (double)k->param.k2, k3 = (double)k->param.k3;
  const double k4 = (double)k->param.k4, k5 = (double)k->param.k5, k6 = (double)k->param.k6;
  KinoraCamera camera;
  memset(&camera, 0, sizeof camera);
  camera.width = seen->resolution_width;
  camera.height = seen->resolution_height;
  camera.fx = (double)k->param.fx;
  camera.fy = (double)k->param.fy;
  camera.cx = (double)k->param.cx;
  camera.cy = (double)k->param.cy;
  camera.distortion[0] = k1 - k4; /* of (1 + k1 r2 + k2 r4 + k3 r6) / (1 + k4 r2 + k5 r4 + k6 r6) */
  camera.distortion[1] = k2 - k5 - k4 * camera.distortion[0];
  camera.distortion[2] = (double)k->param.p1;
  camera.distortion[3] = (double)k->param.p2;
  camera.distortion[4] = k3 - k6 - k5 * camera.distortion[0] - k4 * camera.distortion[1];
  return camera;
}

Camera* camera_open(const char* device, KinoraCamera* color, double* depth_unit, double* frames_per_second,
                    char* problem, size_t size) {
  k4a_device_configuration_t how = K4A_DEVICE_CONFIG_INIT_DISABLE_ALL;
  k4a_calibration_t calibration;
  Camera* camera = calloc(1, sizeof *camera);
  if (camera == NULL) return NULL;
  how.color_format = K4A_IMAGE_FORMAT_COLOR_BGRA32;
  how.color_resolution = K4A_COLOR_RESOLUTION_720P;
  how.depth_mode = K4A_DEPTH_MODE_NFOV_UNBINNED;
  how.camera_fps = K4A_FRAMES_PER_SECOND_30;
  how.synchronized_images_only = true;
  if (k4a_device_open((uint32_t)strtoul(device, NULL, 10), &camera->device) == K4A_RESULT_SUCCEEDED &&
      k4a_device_get_calibration(camera->device, how.depth_mode, how.color_resolution, &calibration) ==
          K4A_RESULT_SUCCEEDED &&
      k4a_image_create(K4A_IMAGE_FORMAT_DEPTH16, WIDTH, HEIGHT, 2 * WIDTH, &camera->depth) == K4A_RESULT_SUCCEEDED &&
      k4a_device_start_cameras(camera->device, &how) == K4A_RESULT_SUCCEEDED) {
    camera->running = 1;
    camera->transformation = k4a_transformation_create(&calibration);
    *color = camera_of(&calibration.color_camera_calibration);
    *depth_unit = 0.001;
    *frames_per_second = 30;
    return camera;
  }
  camera_close(camera);
  snprintf(problem, size, "there is no Azure Kinect with this number, or it is in use");
  return NULL;
}

static int take(Camera* camera, k4a_image_t color, k4a_image_t depth, CameraFrame* frame) {
  if (color == NULL || depth == NULL ||
      k4a_transformation_depth_image_to_color_camera(camera->transformation, depth, camera->depth) !=
          K4A_RESULT_SUCCEEDED)
    return 0;
  const uint8_t* bgra = k4a_image_get_buffer(color);
  for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; ++i)
    for (size_t c = 0; c < 3; ++c) camera->color[3 * i + c] = bgra[4 * i + 2 - c];
  frame->time = 1e-6 * (double)k4a_image_get_device_timestamp_usec(color);
  frame->color = camera->color;
  frame->depth = (const uint16_t*)(const void*)k4a_image_get_buffer(camera->depth);
  return 1;
}

int camera_wait(Camera* camera, CameraFrame* frame) {
  k4a_capture_t capture;
  if (k4a_device_get_capture(camera->device, &capture, PATIENCE_MS) != K4A_WAIT_RESULT_SUCCEEDED) return 0;
  k4a_image_t color = k4a_capture_get_color_image(capture);
  k4a_image_t depth = k4a_capture_get_depth_image(capture);
  const int taken = take(camera, color, depth, frame);
  if (color != NULL) k4a_image_release(color);
  if (depth != NULL) k4a_image_release(depth);
  k4a_capture_release(capture);
  return taken;
}

void camera_close(Camera* camera) {
  if (camera->running) k4a_device_stop_cameras(camera->device);
  if (camera->transformation != NULL) k4a_transformation_destroy(camera->transformation);
  if (camera->depth != NULL) k4a_image_release(camera->depth);
  if (camera->device != NULL) k4a_device_close(camera->device);
  free(camera);
}
