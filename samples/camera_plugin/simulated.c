/* No camera: five frames of a flat grey world, to try the plugin without hardware. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"

enum { WIDTH = 32, HEIGHT = 24, FRAMES = 5 };

struct Camera {
  int next;
  uint8_t color[3 * WIDTH * HEIGHT];
  uint16_t depth[WIDTH * HEIGHT];
};

Camera* camera_open(const char* device, KinoraCamera* color, double* depth_unit, double* frames_per_second,
                    char* problem, size_t size) {
  if (device[0] != '\0' && strcmp(device, "0") != 0) {
    snprintf(problem, size, "there is no such camera, but 0");
    return NULL;
  }
  color->width = WIDTH;
  color->height = HEIGHT;
  color->fx = color->fy = 30;
  color->cx = (WIDTH - 1) / 2.0;
  color->cy = (HEIGHT - 1) / 2.0;
  *depth_unit = 0.001;
  *frames_per_second = 30;
  return calloc(1, sizeof(Camera));
}

int camera_wait(Camera* camera, CameraFrame* frame) {
  if (camera->next == FRAMES) return 0;
  memset(camera->color, 100 + camera->next, sizeof camera->color);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) camera->depth[i] = (uint16_t)(1500 + camera->next);
  frame->time = 7 + camera->next++ / 30.0;
  frame->color = camera->color;
  frame->depth = camera->depth;
  return 1;
}

void camera_close(Camera* camera) { free(camera); }
