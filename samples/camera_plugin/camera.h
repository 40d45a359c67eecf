/* What a maker's SDK has to give: five things about one camera that is running. plugin.c makes Kinora's format of it;
 * realsense.c, k4a.c and simulated.c give it. For another SDK write a sixth file like these. */
#ifndef CAMERA_H
#define CAMERA_H

#include <kinora/plugin.h>

typedef struct Camera Camera;

typedef struct CameraFrame {
  double time;          /* seconds on the camera's clock */
  const uint8_t* color; /* RGB, without gaps between rows */
  const uint16_t* depth;
} CameraFrame;

/* Starts the camera with this number or serial number ("" or "0": the first). Fills in width, height, fx, fy, cx, cy
 * and distortion of colour (depth is registered to it), the metres of one unit of depth and the rate. NULL: there is
 * none, and `problem` (of `size` bytes) says in a sentence why. */
Camera* camera_open(const char* device, KinoraCamera* color, double* depth_unit, double* frames_per_second,
                    char* problem, size_t size);

/* Waits for the next frame; what it points to stays until the next call. 0: none came within two seconds. */
int camera_wait(Camera* camera, CameraFrame* frame);

void camera_close(Camera* camera);

#endif
