/* Of the Azure Kinect SDK what samples/camera_plugin uses, so that it is compiled where the SDK is not installed. */
#ifndef STUB_K4A_H
#define STUB_K4A_H

#include <stdbool.h>
#include <stdint.h>

typedef struct k4a_device* k4a_device_t;
typedef struct k4a_capture* k4a_capture_t;
typedef struct k4a_image* k4a_image_t;
typedef struct k4a_transformation* k4a_transformation_t;
typedef enum { K4A_RESULT_SUCCEEDED, K4A_RESULT_FAILED } k4a_result_t;
typedef enum { K4A_WAIT_RESULT_SUCCEEDED, K4A_WAIT_RESULT_FAILED } k4a_wait_result_t;
typedef enum {
  K4A_IMAGE_FORMAT_COLOR_MJPG,
  K4A_IMAGE_FORMAT_COLOR_BGRA32,
  K4A_IMAGE_FORMAT_DEPTH16
} k4a_image_format_t;
typedef enum { K4A_COLOR_RESOLUTION_OFF, K4A_COLOR_RESOLUTION_720P } k4a_color_resolution_t;
typedef enum { K4A_DEPTH_MODE_OFF, K4A_DEPTH_MODE_NFOV_UNBINNED } k4a_depth_mode_t;
typedef enum { K4A_FRAMES_PER_SECOND_5, K4A_FRAMES_PER_SECOND_30 } k4a_fps_t;
typedef struct {
  k4a_image_format_t color_format;
  k4a_color_resolution_t color_resolution;
  k4a_depth_mode_t depth_mode;
  k4a_fps_t camera_fps;
  bool synchronized_images_only;
} k4a_device_configuration_t;
static const k4a_device_configuration_t K4A_DEVICE_CONFIG_INIT_DISABLE_ALL = {
    K4A_IMAGE_FORMAT_COLOR_MJPG, K4A_COLOR_RESOLUTION_OFF, K4A_DEPTH_MODE_OFF, K4A_FRAMES_PER_SECOND_30, false};
typedef union {
  struct {
    float cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, codx, cody, p2, p1, metric_radius;
  } param;
} k4a_calibration_intrinsic_parameters_t;
typedef struct {
  struct {
    k4a_calibration_intrinsic_parameters_t parameters;
  } intrinsics;
  int resolution_width, resolution_height;
} k4a_calibration_camera_t;
typedef struct {
  k4a_calibration_camera_t depth_camera_calibration, color_camera_calibration;
} k4a_calibration_t;

k4a_result_t k4a_device_open(uint32_t, k4a_device_t*);
void k4a_device_close(k4a_device_t);
k4a_result_t k4a_device_get_calibration(k4a_device_t, const k4a_depth_mode_t, const k4a_color_resolution_t,
                                        k4a_calibration_t*);
k4a_result_t k4a_device_start_cameras(k4a_device_t, const k4a_device_configuration_t*);
void k4a_device_stop_cameras(k4a_device_t);
k4a_wait_result_t k4a_device_get_capture(k4a_device_t, k4a_capture_t*, int32_t);
k4a_image_t k4a_capture_get_color_image(k4a_capture_t);
k4a_image_t k4a_capture_get_depth_image(k4a_capture_t);
void k4a_capture_release(k4a_capture_t);
k4a_result_t k4a_image_create(k4a_image_format_t, int, int, int, k4a_image_t*);
uint8_t* k4a_image_get_buffer(k4a_image_t);
uint64_t k4a_image_get_device_timestamp_usec(k4a_image_t);
void k4a_image_release(k4a_image_t);
k4a_transformation_t k4a_transformation_create(const k4a_calibration_t*);
void k4a_transformation_destroy(k4a_transformation_t);
k4a_result_t k4a_transformation_depth_image_to_color_camera(k4a_transformation_t, const k4a_image_t, k4a_image_t);

#endif
