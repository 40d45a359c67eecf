/* A format plugin to copy from. Its files: "RAWDEPTH", then width, height and frames (32 bits each, little endian), the
 * focal length in pixels (32-bit float), and for every frame width*height grey bytes and as many 16-bit millimetres. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <kinora/plugin.h>

#if defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

typedef struct Head {
  char magic[8];
  uint32_t width, height, frames;
  float focal_length;
} Head;

struct KinoraReader {
  FILE* file;
  Head head;
  double frames_per_second;
  int64_t next;
  uint8_t* grey;
  uint8_t* color;
  uint16_t* depth;
};

static KinoraStatus fail(KinoraMessage* message, KinoraStatus status, const char* path, const char* problem) {
  snprintf(message->text, sizeof message->text, "%s: %s", path, problem);
  return status;
}

/* Cheap and quiet: most files are not ours. */
static void probe(const char* path, KinoraProbe* answer) {
  char magic[8];
  FILE* file = fopen(path, "rb");
  answer->confidence = file != NULL && fread(magic, 1, 8, file) == 8 && memcmp(magic, "RAWDEPTH", 8) == 0 ? 100 : 0;
  strcpy(answer->reason, answer->confidence > 0 ? "begins with RAWDEPTH" : "does not begin with RAWDEPTH");
  if (file != NULL) fclose(file);
}

static void reader_close(KinoraReader* reader) {
  if (reader->file != NULL) fclose(reader->file);
  free(reader->grey);
  free(reader->color);
  free(reader->depth);
  free(reader);
}

/* Loud where the file is ours but broken; nothing is allocated before its numbers are believed. */
static KinoraStatus open_reader(const char* path, const KinoraOptionValue* options, size_t option_count,
                                KinoraReader** opened, KinoraMessage* message) {
  KinoraReader* reader = calloc(1, sizeof *reader);
  if (reader == NULL) return fail(message, KINORA_FAILURE, path, "out of memory");
  const Head* head = &reader->head;
  reader->frames_per_second = 30;
  for (size_t i = 0; i < option_count; ++i)
    if (strcmp(options[i].name, "fps") == 0) reader->frames_per_second = atof(options[i].value);
  reader->file = fopen(path, "rb");
  if (reader->file == NULL || fread(&reader->head, sizeof *head, 1, reader->file) != 1 ||
      memcmp(head->magic, "RAWDEPTH", 8) != 0) {
    reader_close(reader);
    return fail(message, KINORA_NOT_RECOGNISED, path, "does not begin with RAWDEPTH");
  }
  if (head->width == 0 || head->width > 16384 || head->height == 0 || head->height > 16384 || head->frames == 0 ||
      !(head->focal_length > 0) || !(reader->frames_per_second > 0)) {
    reader_close(reader);
    return fail(message, KINORA_CORRUPT, path, "its size, number of frames or focal length makes no sense");
  }
  const size_t pixels = (size_t)head->width * head->height;
  reader->grey = malloc(pixels);
  reader->color = malloc(3 * pixels);
  reader->depth = malloc(2 * pixels);
  if (reader->grey == NULL || reader->color == NULL || reader->depth == NULL) {
    reader_close(reader);
    return fail(message, KINORA_FAILURE, path, "out of memory");
  }
  *opened = reader;
  return KINORA_OK;
}

static KinoraStatus reader_info(KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message) {
  (void)message;
  const Head* head = &reader->head;
  info->frame_count = head->frames;
  info->frames_per_second = reader->frames_per_second;
  info->camera.width = (int32_t)head->width;
  info->camera.height = (int32_t)head->height;
  info->camera.fx = info->camera.fy = head->focal_length;
  info->camera.cx = 0.5 * (head->width - 1);
  info->camera.cy = 0.5 * (head->height - 1);
  return KINORA_OK;
}

static KinoraImage image_of(const Head* head, int32_t channels, KinoraPixelType type, size_t bytes, const void* data) {
  KinoraImage image = {0};
  image.width = (int32_t)head->width;
  image.height = (int32_t)head->height;
  image.channels = channels;
  image.pixel_type = type;
  image.row_bytes = head->width * bytes;
  image.data = data;
  return image;
}

static KinoraStatus reader_next(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  const Head* head = &reader->head;
  const size_t pixels = (size_t)head->width * head->height;
  if (reader->next == (int64_t)head->frames) return KINORA_END;
  frame->index = reader->next++;
  if (fread(reader->grey, 1, pixels, reader->file) != pixels ||
      fread(reader->depth, 2, pixels, reader->file) != pixels) {
    snprintf(message->text, sizeof message->text, "frame %lld: the file ends within it", (long long)frame->index);
    return KINORA_BAD_FRAME;
  }
  for (size_t i = 0; i < pixels; ++i) memset(reader->color + 3 * i, reader->grey[i], 3);
  frame->time = (double)frame->index / reader->frames_per_second;
  frame->color = image_of(head, 3, KINORA_PIXEL_U8, 3, reader->color);
  frame->depth = image_of(head, 1, KINORA_PIXEL_U16, 2, reader->depth);
  frame->depth_unit = 0.001;
  return KINORA_OK;
}

static KinoraStatus reader_seek(KinoraReader* reader, int64_t index, KinoraMessage* message) {
  const int64_t bytes = 3 * (int64_t)reader->head.width * reader->head.height;
  if (index < 0 || index > (int64_t)reader->head.frames)
    return fail(message, KINORA_USAGE, "raw-depth", "there is no such frame");
  if (fseek(reader->file, (long)((int64_t)sizeof(Head) + index * bytes), SEEK_SET) != 0)
    return fail(message, KINORA_FAILURE, "raw-depth", "the file cannot be wound");
  reader->next = index;
  return KINORA_OK;
}

/* The same as plugin.json says. */
static const KinoraOption options[] = {{"fps", "number", "30", "Frames per second; the file does not say.", NULL}};
static const KinoraFormat format = {.struct_size = sizeof(KinoraFormat),
                                    .abi_version = KINORA_PLUGIN_ABI,
                                    .name = "raw-depth",
                                    .description = "grey pictures beside 16-bit depth",
                                    .extensions = "",
                                    .capabilities = KINORA_READS_FRAMES | KINORA_SEEKS,
                                    .options = options,
                                    .option_count = 1,
                                    .probe = probe,
                                    .open_reader = open_reader,
                                    .reader_info = reader_info,
                                    .reader_next = reader_next,
                                    .reader_seek = reader_seek,
                                    .reader_close = reader_close};
static const KinoraFormat* const formats[] = {&format};
static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "raw-depth", "1.0", formats, 1};

EXPORT const KinoraPlugin* kinora_plugin(uint32_t host_abi_version);
EXPORT const KinoraPlugin* kinora_plugin(uint32_t host_abi_version) {
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : NULL;
}
