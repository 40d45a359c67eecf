/* A live camera as a format of Kinora: `kinora record NAME:DEVICE OUT.mkv`. NAME is CAMERA_NAME. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"

#if defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

struct KinoraReader {
  Camera* camera;
  KinoraCamera color;
  double depth_unit, frames_per_second, seconds, first_time;
  int64_t next;
};

static KinoraImage image_of(const KinoraCamera* camera, int32_t channels, KinoraPixelType type, size_t bytes,
                            const void* data) {
  KinoraImage image = {0};
  image.width = camera->width;
  image.height = camera->height;
  image.channels = channels;
  image.pixel_type = type;
  image.row_bytes = (size_t)camera->width * bytes;
  image.data = data;
  return image;
}

static void probe(const char* path, KinoraProbe* answer) {
  (void)path;
  answer->confidence = 0;
  strcpy(answer->reason, "no file, but a camera: name it " CAMERA_NAME ":0");
}

static void reader_close(KinoraReader* reader) {
  if (reader->camera != NULL) camera_close(reader->camera);
  free(reader);
}

static KinoraStatus open_reader(const char* path, const KinoraOptionValue* options, size_t option_count,
                                KinoraReader** opened, KinoraMessage* message) {
  const char* colon = strchr(path, ':');
  char problem[512] = "";
  KinoraReader* reader = calloc(1, sizeof *reader);
  if (reader == NULL) return strcpy(message->text, "out of memory"), KINORA_FAILURE;
  reader->seconds = 60;
  for (size_t i = 0; i < option_count; ++i)
    if (strcmp(options[i].name, "seconds") == 0) reader->seconds = atof(options[i].value);
  if (!(reader->seconds > 0 && reader->seconds < 1e6)) {
    reader_close(reader);
    return strcpy(message->text, "seconds must lie between 0 and a million"), KINORA_USAGE;
  }
  reader->camera = camera_open(colon == NULL ? "" : colon + 1, &reader->color, &reader->depth_unit,
                               &reader->frames_per_second, problem, sizeof problem);
  if (reader->camera == NULL) {
    reader_close(reader);
    snprintf(message->text, sizeof message->text, "%s: %s", path, problem);
    return KINORA_MISSING;
  }
  *opened = reader;
  return KINORA_OK;
}

static KinoraStatus reader_info(KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message) {
  (void)message;
  info->frame_count = (int64_t)(reader->seconds * reader->frames_per_second + 0.5);
  if (info->frame_count < 1) info->frame_count = 1;
  info->frames_per_second = reader->frames_per_second;
  info->camera = reader->color;
  return KINORA_OK;
}

static KinoraStatus reader_next(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  CameraFrame seen;
  if (!camera_wait(reader->camera, &seen))
    return strcpy(message->text, "the camera gives no frames any more; is it still plugged in?"), KINORA_FAILURE;
  if (reader->next == 0) reader->first_time = seen.time;
  if (seen.time - reader->first_time > reader->seconds) return KINORA_END;
  frame->index = reader->next++;
  frame->time = seen.time - reader->first_time;
  frame->color = image_of(&reader->color, 3, KINORA_PIXEL_U8, 3, seen.color);
  frame->depth = image_of(&reader->color, 1, KINORA_PIXEL_U16, 2, seen.depth);
  frame->depth_unit = reader->depth_unit;
  return KINORA_OK;
}

/* The same as plugin.json says. */
static const KinoraOption options[] = {{"seconds", "number", "60", "How long frames come.", NULL}};
static const KinoraFormat format = {.struct_size = sizeof(KinoraFormat),
                                    .abi_version = KINORA_PLUGIN_ABI,
                                    .name = CAMERA_NAME,
                                    .description = "live camera, as " CAMERA_NAME ":0 or " CAMERA_NAME ":SERIAL",
                                    .extensions = "",
                                    .capabilities = KINORA_READS_FRAMES | KINORA_READS_DEVICE,
                                    .options = options,
                                    .option_count = 1,
                                    .probe = probe,
                                    .open_reader = open_reader,
                                    .reader_info = reader_info,
                                    .reader_next = reader_next,
                                    .reader_close = reader_close};
static const KinoraFormat* const formats[] = {&format};
static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, CAMERA_NAME, "1.0", formats, 1};

EXPORT const KinoraPlugin* kinora_plugin(uint32_t host_abi_version);
EXPORT const KinoraPlugin* kinora_plugin(uint32_t host_abi_version) {
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : NULL;
}
