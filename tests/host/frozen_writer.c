/* The source of frozen_writer_abi1_x86_64.so, which stays as it is: a plugin in plain C that was compiled with the
 * interface as it was when pictures had no labels and writers no frames and no facts (cc -std=c99 -O2 -shared -fPIC
 * -s). It writes a line of text for each picture. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kinora/plugin.h"

struct KinoraWriter {
  FILE* file;
};

static KinoraStatus open_writer(const char* path, const KinoraOptionValue* options, size_t option_count,
                                KinoraWriter** writer, KinoraMessage* message) {
  (void)options, (void)option_count;
  *writer = calloc(1, sizeof **writer);
  if (*writer != NULL && ((*writer)->file = fopen(path, "w")) != NULL) return KINORA_OK;
  free(*writer);
  strcpy(message->text, "the text cannot be written");
  return KINORA_UNWRITABLE;
}

static KinoraStatus write_picture(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
  const uint8_t* first = picture->color.data;
  if (picture->struct_size < sizeof *picture) {
    strcpy(message->text, "the host is older than the plugin");
    return KINORA_FAILURE;
  }
  fprintf(writer->file, "%s %dx%d %d\n", picture->name, picture->color.width, picture->color.height, first[0]);
  return KINORA_OK;
}

static KinoraStatus finish(KinoraWriter* writer, KinoraMessage* message) {
  const int failed = fclose(writer->file);
  free(writer);
  if (!failed) return KINORA_OK;
  strcpy(message->text, "the text cannot be written to its end");
  return KINORA_UNWRITABLE;
}

static void abandon(KinoraWriter* writer) {
  fclose(writer->file);
  free(writer);
}

static const KinoraFormat format = {.struct_size = sizeof(KinoraFormat),
                                    .abi_version = KINORA_PLUGIN_ABI,
                                    .name = "lines",
                                    .description = "a line for each picture",
                                    .extensions = ".lines",
                                    .capabilities = KINORA_WRITES_PICTURES,
                                    .open_writer = open_writer,
                                    .writer_write = write_picture,
                                    .writer_finish = finish,
                                    .writer_abandon = abandon};
static const KinoraFormat* const formats[] = {&format};
static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "lines", "1.0", formats, 1};

const KinoraPlugin* kinora_plugin(uint32_t host_abi_version);
const KinoraPlugin* kinora_plugin(uint32_t host_abi_version) {
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : NULL;
}
