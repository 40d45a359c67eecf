/* RealSense cameras through librealsense 2 (2.45 or later), depth aligned to colour by the SDK. */
#include <librealsense2/h/rs_pipeline.h>
#include <librealsense2/rs.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"

enum { WIDTH = 640, HEIGHT = 480, RATE = 30, PATIENCE_MS = 2000 };

struct Camera {
  rs2_context* context;
  rs2_pipeline* pipeline;
  rs2_config* config;
  rs2_pipeline_profile* profile;
  rs2_processing_block* align;
  rs2_frame_queue* aligned;
  rs2_frame* frames; /* of the last call */
  rs2_frame *color, *depth;
};

/* Whether a call went wrong; its sentence goes to `problem`, unless that is NULL. */
static int failed(rs2_error** error, char* problem, size_t size) {
  if (*error == NULL) return 0;
  if (problem != NULL) snprintf(problem, size, "%s", rs2_get_error_message(*error));
  rs2_free_error(*error);
  *error = NULL;
  return 1;
}

static void release(Camera* camera) {
  if (camera->color != NULL) rs2_release_frame(camera->color);
  if (camera->depth != NULL) rs2_release_frame(camera->depth);
  if (camera->frames != NULL) rs2_release_frame(camera->frames);
  camera->color = camera->depth = camera->frames = NULL;
}

static void take_apart(Camera* camera, rs2_error** error) {
  const int count = rs2_embedded_frames_count(camera->frames, error);
  for (int i = 0; i < count && *error == NULL; ++i) {
    rs2_frame* frame = rs2_extract_frame(camera->frames, i, error);
    rs2_stream stream = RS2_STREAM_ANY;
    rs2_format format;
    int index, identifier, rate;
    if (*error != NULL) return;
    const rs2_stream_profile* profile = rs2_get_frame_stream_profile(frame, error);
    if (*error == NULL) rs2_get_stream_profile_data(profile, &stream, &format, &index, &identifier, &rate, error);
    if (stream == RS2_STREAM_COLOR && camera->color == NULL)
      camera->color = frame;
    else if (stream == RS2_STREAM_DEPTH && camera->depth == NULL)
      camera->depth = frame;
    else
      rs2_release_frame(frame);
  }
}

static int wait_for_frame(Camera* camera, rs2_error** error) {
  release(camera);
  rs2_frame* raw = rs2_pipeline_wait_for_frames(camera->pipeline, PATIENCE_MS, error);
  if (*error != NULL) return 0;
  rs2_process_frame(camera->align, raw, error); /* takes the frame */
  if (*error != NULL || !rs2_try_wait_for_frame(camera->aligned, PATIENCE_MS, &camera->frames, error)) return 0;
  take_apart(camera, error);
  return *error == NULL && camera->color != NULL && camera->depth != NULL;
}

static void start(Camera* camera, const char* device, rs2_error** error) {
  camera->context = rs2_create_context(RS2_API_VERSION, error);
  if (*error == NULL) camera->pipeline = rs2_create_pipeline(camera->context, error);
  if (*error == NULL) camera->config = rs2_create_config(error);
  if (*error == NULL && device[0] != '\0' && strcmp(device, "0") != 0)
    rs2_config_enable_device(camera->config, device, error);
  if (*error == NULL)
    rs2_config_enable_stream(camera->config, RS2_STREAM_COLOR, -1, WIDTH, HEIGHT, RS2_FORMAT_RGB8, RATE, error);
  if (*error == NULL)
    rs2_config_enable_stream(camera->config, RS2_STREAM_DEPTH, -1, WIDTH, HEIGHT, RS2_FORMAT_Z16, RATE, error);
  if (*error == NULL) camera->align = rs2_create_align(RS2_STREAM_COLOR, error);
  if (*error == NULL) camera->aligned = rs2_create_frame_queue(1, error);
  if (*error == NULL) rs2_start_processing_queue(camera->align, camera->aligned, error);
  if (*error == NULL) camera->profile = rs2_pipeline_start_with_config(camera->pipeline, camera->config, error);
}

Camera* camera_open(const char* device, KinoraCamera* color, double* depth_unit, double* frames_per_second,
                    char* problem, size_t size) {
  rs2_error* error = NULL;
  rs2_intrinsics lens;
  memset(&lens, 0, sizeof lens);
  Camera* camera = calloc(1, sizeof *camera);
  if (camera == NULL) return NULL;
  snprintf(problem, size, "the camera gives no frames; plug it in again");
  start(camera, device, &error);
  const int running = error == NULL && wait_for_frame(camera, &error);
  if (running) rs2_get_video_stream_intrinsics(rs2_get_frame_stream_profile(camera->color, &error), &lens, &error);
  if (running && error == NULL) *depth_unit = (double)rs2_depth_frame_get_units(camera->depth, &error);
  if (failed(&error, problem, size) || !running) {
    camera_close(camera);
    return NULL;
  }
  color->width = lens.width;
  color->height = lens.height;
  color->fx = (double)lens.fx;
  color->fy = (double)lens.fy;
  color->cx = (double)lens.ppx;
  color->cy = (double)lens.ppy;
  if (lens.model == RS2_DISTORTION_BROWN_CONRADY)
    for (int i = 0; i < 5; ++i) color->distortion[i] = (double)lens.coeffs[i];
  *frames_per_second = RATE;
  return camera;
}

int camera_wait(Camera* camera, CameraFrame* frame) {
  rs2_error* error = NULL;
  if (wait_for_frame(camera, &error)) {
    frame->time = 1e-3 * rs2_get_frame_timestamp(camera->color, &error);
    if (error == NULL) frame->color = rs2_get_frame_data(camera->color, &error);
    if (error == NULL) frame->depth = rs2_get_frame_data(camera->depth, &error);
    if (error == NULL) return 1;
  }
  failed(&error, NULL, 0);
  return 0;
}

void camera_close(Camera* camera) {
  rs2_error* error = NULL;
  release(camera);
  if (camera->profile != NULL) {
    rs2_pipeline_stop(camera->pipeline, &error);
    failed(&error, NULL, 0);
    rs2_delete_pipeline_profile(camera->profile);
  }
  if (camera->align != NULL) rs2_delete_processing_block(camera->align);
  if (camera->aligned != NULL) rs2_delete_frame_queue(camera->aligned);
  if (camera->config != NULL) rs2_delete_config(camera->config);
  if (camera->pipeline != NULL) rs2_delete_pipeline(camera->pipeline);
  if (camera->context != NULL) rs2_delete_context(camera->context);
  free(camera);
}
