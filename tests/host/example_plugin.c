/* An external plugin in plain C: reads files that begin with "flat" as captures of grey frames, with infrared, and with
 * no confidence in the first column of depth. Variants for tests of bad plugins are chosen when it is compiled. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kinora/plugin.h"

#ifndef EXAMPLE_NAME
#define EXAMPLE_NAME "flat"
#endif
#ifndef EXAMPLE_ABI
#define EXAMPLE_ABI KINORA_PLUGIN_ABI
#endif

#ifdef EXAMPLE_HOSTED
static const KinoraHost* host;
void kinora_plugin_host(const KinoraHost* given);
void kinora_plugin_host(const KinoraHost* given) { host = given; }
#endif

enum { WIDTH = 8, HEIGHT = 6, FRAMES = 4 };

struct KinoraReader {
  int64_t next;
  uint8_t color[WIDTH * HEIGHT * 3];
  uint16_t depth[WIDTH * HEIGHT];
  uint16_t infrared[WIDTH * HEIGHT];
  uint8_t confidence[WIDTH * HEIGHT];
};

static void probe(const char* path, KinoraProbe* answer) {
#ifdef EXAMPLE_CRASHES
  abort();
#endif
#ifdef EXAMPLE_HANGS
  for (;;) {
  }
#endif
  char head[4] = {0};
  FILE* file = fopen(path, "rb");
  if (file != NULL) {
    if (fread(head, 1, sizeof head, file) == sizeof head && memcmp(head, "flat", 4) == 0) answer->confidence = 100;
    fclose(file);
  }
  strcpy(answer->reason, answer->confidence > 0 ? "begins with \"flat\"" : "does not begin with \"flat\"");
}

#ifdef EXAMPLE_HOSTED
/* With the host's files, memory, log and progress. */
static KinoraStatus open_reader(const char* path, const KinoraOptionValue* options, size_t option_count,
                                KinoraReader** reader, KinoraMessage* message) {
  char head[4];
  uint64_t bytes = 0;
  KinoraFile* file = host->open_file(path, &bytes, message);
  (void)options, (void)option_count;
  if (file == NULL) return KINORA_FAILURE;
  KinoraStatus status = host->read_file(file, 0, head, sizeof head, message);
  if (status == KINORA_OK) status = host->read_file(file, bytes - 4, head, sizeof head, message);
  host->close_file(file);
  if (status != KINORA_OK) return status;
  host->log("the world is flat", 1);
  host->log("it has four corners", 0);
  for (uint64_t step = 0; step < 3; ++step) {
    if (host->progress(step, 3) == 0) continue;
    strcpy(message->text, "stopped as asked");
    return KINORA_FAILURE;
  }
  *reader = host->allocate(sizeof **reader);
  if (*reader == NULL) return KINORA_FAILURE;
  memset(*reader, 0, sizeof **reader);
  return KINORA_OK;
}
static void reader_close(KinoraReader* reader) { host->release(reader); }
#else
static KinoraStatus open_reader(const char* path, const KinoraOptionValue* options, size_t option_count,
                                KinoraReader** reader, KinoraMessage* message) {
  (void)path, (void)options, (void)option_count;
  *reader = calloc(1, sizeof **reader);
  if (*reader != NULL) return KINORA_OK;
  strcpy(message->text, "out of memory");
  return KINORA_FAILURE;
}
static void reader_close(KinoraReader* reader) { free(reader); }
#endif

static KinoraStatus reader_info(KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message) {
  (void)reader, (void)message;
  info->frame_count = FRAMES;
  info->frames_per_second = 10;
  info->camera.width = WIDTH;
  info->camera.height = HEIGHT;
  info->camera.fx = info->camera.fy = 10;
  info->camera.cx = 3.5;
  info->camera.cy = 2.5;
  return KINORA_OK;
}

static KinoraStatus reader_next(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  if (reader->next == FRAMES) return KINORA_END;
  frame->index = reader->next++;
  if (frame->index == 2) {
    strcpy(message->text, "frame 2 of the flat world has a dent");
    return KINORA_BAD_FRAME;
  }
  memset(reader->color, (int)(100 + frame->index), sizeof reader->color);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    reader->depth[i] = 500;
    reader->infrared[i] = 1000;
    reader->confidence[i] = i % WIDTH == 0 ? 0 : 2;
  }
  frame->time = 0.1 * (double)frame->index;
  frame->color.width = frame->depth.width = WIDTH;
  frame->color.height = frame->depth.height = HEIGHT;
  frame->color.channels = 3;
  frame->color.pixel_type = KINORA_PIXEL_U8;
  frame->color.row_bytes = WIDTH * 3;
  frame->color.data = reader->color;
  frame->depth.channels = 1;
  frame->depth.pixel_type = KINORA_PIXEL_U16;
  frame->depth.row_bytes = WIDTH * 2;
  frame->depth.data = reader->depth;
  frame->infrared = frame->confidence = frame->depth;
  frame->infrared.data = reader->infrared;
  frame->confidence.pixel_type = KINORA_PIXEL_U8;
  frame->confidence.row_bytes = WIDTH;
  frame->confidence.data = reader->confidence;
  frame->depth_unit = 0.002;
  return KINORA_OK;
}

static const KinoraFormat format = {.struct_size = sizeof(KinoraFormat),
                                    .abi_version = KINORA_PLUGIN_ABI,
                                    .name = EXAMPLE_NAME,
                                    .description = "a flat world",
                                    .extensions = "",
                                    .capabilities =
                                        KINORA_READS_FRAMES | KINORA_READS_CONFIDENCE | KINORA_READS_INFRARED,
                                    .probe = probe,
                                    .open_reader = open_reader,
                                    .reader_info = reader_info,
                                    .reader_next = reader_next,
                                    .reader_close = reader_close};
static const KinoraFormat* const formats[] = {&format};
static const KinoraPlugin plugin = {sizeof(KinoraPlugin), EXAMPLE_ABI, "example", "1.0", formats, 1};

const KinoraPlugin* kinora_plugin(uint32_t host_abi_version);
const KinoraPlugin* kinora_plugin(uint32_t host_abi_version) {
#ifdef EXAMPLE_STILLBORN
  abort();
#endif
  return host_abi_version == EXAMPLE_ABI || EXAMPLE_ABI != KINORA_PLUGIN_ABI ? &plugin : NULL;
}
