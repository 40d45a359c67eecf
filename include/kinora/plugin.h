/* The C interface between Kinora and a format plugin.
 *
 * A plugin reads or writes one or more file formats. It exchanges plain things only: images with calibration, pose and
 * time. It never sees how Kinora models a scene. The formats that come with Kinora use this interface too.
 *
 * External plugins are shared libraries (*.so) in a folder of KINORA_PLUGIN_PATH (folders separated by ':'), of
 * --plugin-dir, or in the installation's lib/kinora/plugins. They export one function, kinora_plugin (below).
 *
 * Versions. Every struct that a plugin or the host fills begins with its own size and the version of this interface.
 * KINORA_PLUGIN_ABI changes only when old plugins can no longer work. Otherwise structs grow at their end, and a reader
 * of a struct looks at `struct_size` before it uses a member that came later. Structs marked "embedded" never grow.
 *
 * Memory. Who makes a thing keeps it. A string or an image that a reader hands out stays valid until the next call for
 * the same reader; what the host hands in is valid during the call alone. Descriptors live as long as the process.
 *
 * Threads. Calls for one reader or writer come one at a time, but may come from different threads. Different readers
 * and writers may be used at the same time. `probe` may be called from any thread at any time.
 *
 * Errors. A function returns a KinoraStatus and, unless that is KINORA_OK or KINORA_END, writes one sentence into the
 * KinoraMessage: what is wrong, the file and the place in it, and the remedy. No exception may leave a plugin; a plugin
 * never prints and never exits.
 *
 * Units: metres, seconds. Camera axes: x right, y down, z forward. Pixel centres lie at integer coordinates.
 * Matrices are 4x4, row by row. Text is UTF-8 and ends with a zero.
 */
#ifndef KINORA_PLUGIN_H
#define KINORA_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define KINORA_PLUGIN_ABI 1u

/* The first two members of every struct that may grow. */
#define KINORA_STRUCT_HEADER                                                                                           \
  uint32_t struct_size; /* sizeof the struct, as its maker was compiled */                                             \
  uint32_t abi_version  /* KINORA_PLUGIN_ABI, as its maker was compiled */

typedef int32_t KinoraStatus;
enum {
  KINORA_OK = 0,
  KINORA_END = 1,            /* a reader has no further frame */
  KINORA_BAD_FRAME = 2,      /* this frame cannot be read; the following call gives the one after it */
  KINORA_FAILURE = 3,        /* anything not named here */
  KINORA_USAGE = 4,          /* an option or a call makes no sense */
  KINORA_NOT_RECOGNISED = 5, /* not of this format */
  KINORA_CORRUPT = 6,        /* of this format, but damaged or absurd */
  KINORA_UNWRITABLE = 7,     /* the output cannot be created or written to its end */
  KINORA_MISSING = 8         /* something that the plugin needs is not installed */
};

/* One sentence for a person. The host provides it; `text` is cut to fit. */
typedef struct KinoraMessage {
  KINORA_STRUCT_HEADER;
  char text[1024];
} KinoraMessage;

/* ---- plain things */

typedef int32_t KinoraPixelType;
enum { KINORA_PIXEL_NONE = 0, KINORA_PIXEL_U8 = 1, KINORA_PIXEL_U16 = 2, KINORA_PIXEL_F32 = 3 };

/* An image, or none if `data` is NULL. Rows from the top, channels interleaved, machine byte order. Embedded. */
typedef struct KinoraImage {
  int32_t width;
  int32_t height;
  int32_t channels;
  KinoraPixelType pixel_type;
  size_t row_bytes; /* from one row to the next */
  const void* data;
  uint64_t reserved[2]; /* 0 */
} KinoraImage;

/* A pinhole camera: u = fx X/Z + cx, v = fy Y/Z + cy, after Brown-Conrady distortion k1 k2 p1 p2 k3. Embedded. */
typedef struct KinoraCamera {
  int32_t width;
  int32_t height;
  double fx, fy, cx, cy;
  double distortion[5];
  double reserved[8]; /* 0 */
} KinoraCamera;

/* What a label of the masks means. `kind` is "deforming", "rigid", "still" or "" (the host decides). Embedded. */
typedef struct KinoraLabel {
  int32_t label; /* 0 to 255 */
  const char* name;
  const char* kind;
} KinoraLabel;

typedef struct KinoraCaptureInfo {
  KINORA_STRUCT_HEADER;
  int64_t frame_count;      /* with the bad ones; at least 1 */
  double start_time;        /* of frame 0, on the clock of KinoraFrame.time */
  double frames_per_second; /* nominal */
  KinoraCamera camera;      /* of colour, and of depth unless has_depth_camera is set */
  int32_t has_poses;        /* every good frame brings a camera pose */
  int32_t has_masks;        /* some frames bring labels */
  const KinoraLabel* labels;
  size_t label_count;
  const char* const* warnings; /* sentences about the whole capture; reading goes on */
  size_t warning_count;
  int32_t has_depth_camera;  /* 0: depth is registered to colour, pixel by pixel; else the host registers it */
  KinoraCamera depth_camera; /* of depth, infrared and confidence, which then have its size */
  double depth_to_color[16]; /* carries points of the depth camera to the colour camera */
} KinoraCaptureInfo;

typedef struct KinoraFrame {
  KINORA_STRUCT_HEADER;
  int64_t index;          /* position in the capture, from 0; also set for KINORA_BAD_FRAME */
  double time;            /* seconds; any origin, the same for all frames */
  KinoraImage color;      /* U8, 3 channels, sRGB */
  KinoraImage depth;      /* U16, 1 channel; 0 = no measurement; along the optical axis */
  double depth_unit;      /* metres per unit of depth */
  KinoraImage infrared;   /* U16, 1 channel; may be absent. Not used: the host says so once and passes over it */
  KinoraImage confidence; /* U8, 1 channel, pixel by pixel as depth: 0 = that depth is not to be believed, and the host
                             takes it for no measurement; other values mean the same to it; may be absent */
  KinoraImage labels;     /* U8, 1 channel: 0 background, 1 person, 2 object, 3... further objects; may be absent */
  int32_t has_pose;
  double camera_to_world[16];
  const void* color_jpeg; /* the JPEG file that colour was decoded from, or NULL: a recording keeps these bytes */
  size_t color_jpeg_bytes;
} KinoraFrame;

/* What the packets of a capture's sound are. */
typedef struct KinoraSound {
  KINORA_STRUCT_HEADER;
  const char* codec;        /* Matroska's CodecID: "A_OPUS", "A_FLAC", "A_PCM/INT/LIT" and so on */
  const void* private_data; /* Matroska's CodecPrivate for this codec; NULL if there is none */
  size_t private_bytes;
  double sampling_rate; /* Hz, before anything is left out */
  int32_t channels;
  int32_t bits; /* of a sample; 0: not said */
  double delay; /* seconds at the beginning that are decoded and not heard (Matroska's CodecDelay) */
} KinoraSound;

/* A piece of sound that can be decoded behind those before it. */
typedef struct KinoraSoundPacket {
  KINORA_STRUCT_HEADER;
  double time; /* when its first sample is heard, plus the delay: seconds on the clock of KinoraFrame.time */
  const void* data;
  size_t bytes;
} KinoraSoundPacket;

/* One picture for a writer. */
typedef struct KinoraPicture {
  KINORA_STRUCT_HEADER;
  const char* name;       /* without extension; may hold '/' for folders; unique within one output */
  double time;            /* seconds from the start, never decreasing; in films increasing */
  KinoraImage color;      /* U8, 3 channels sRGB or 4 with straight alpha */
  KinoraImage depth;      /* U16, 1 channel, millimetres, 0 = nothing; may be absent */
  KinoraImage normal;     /* F32, 3 channels: unit vectors out of the surface along the camera's axes, 0 = nothing;
                             may be absent */
  KinoraImage confidence; /* U8, 1 channel: how well the surface was seen, 0 = never; may be absent */

  /* Formats that were made before these members existed end here. */

  KinoraImage metric_depth; /* F32, 1 channel, metres along the optical axis, 0 = nothing; may be absent */
  KinoraImage labels;       /* U8, 1 channel: the label of what is in front, as in KinoraFrame; 0 where nothing is; may
                               be absent */
  const KinoraLabel* label_meanings;
  size_t label_count;
  int32_t has_camera;
  KinoraCamera camera; /* of width and height as colour */
  double camera_to_world[16];

  /* Formats that were made before these members existed end here. */

  const struct KinoraPicture* layers; /* what colour was composited of, in no order: pictures of the same size with
                                         colour (4 channels), metric_depth (0 where opacity is a half or less) and one
                                         label meaning, their own; may be absent */
  size_t layer_count;
} KinoraPicture;

/* A surface, given to a writer once. A point p of the mesh (homogeneous) is in the world at
 * sum over its joints j of weight_j * joint_to_world_j * inverse_bind_j * p, where the poses that follow give
 * joint_to_world. */
typedef struct KinoraMesh {
  KINORA_STRUCT_HEADER;
  const char* name; /* unique within one output */
  size_t vertex_count;
  const float* positions; /* 3 per vertex, metres */
  const float* normals;   /* 3 per vertex, unit length, outwards; may be NULL */
  const uint8_t* colors;  /* 3 per vertex, sRGB, as the camera saw it: light is in it already; may be NULL */
  size_t face_count;
  const uint32_t* faces;         /* 3 vertex numbers per triangle, counterclockwise seen from outside */
  size_t joint_count;            /* 0: the mesh stays where it is, and no pose follows; at most 65536 */
  const float* inverse_bind;     /* a 4x4 matrix per joint */
  const uint16_t* joint_indices; /* 4 per vertex, different where the weight is not 0; NULL: all follow joint 0 */
  const float* joint_weights;    /* 4 per vertex, not negative, sum 1; those unused are 0; NULL as joint_indices */

  /* Formats that were made before these members existed end here. */

  const float* texture_coordinates; /* 2 per vertex: shares of the texture's width and height from its upper left
                                       corner; NULL if there is none */
  KinoraImage texture;              /* U8, 3 channels, sRGB, as the camera saw it; then colors is NULL */
} KinoraMesh;

/* Where a joint is. Embedded. */
typedef struct KinoraJoint {
  double rotation[4];    /* unit quaternion w x y z, joint to world */
  double translation[3]; /* metres */
} KinoraJoint;

/* All joints of one mesh at one time. */
typedef struct KinoraMeshPose {
  KINORA_STRUCT_HEADER;
  size_t mesh;        /* number of the mesh, in the order in which they were given, from 0 */
  double time;        /* seconds from the start, increasing for each mesh */
  size_t joint_count; /* as the mesh has */
  const KinoraJoint* joints;

  /* Formats that were made before this member existed end here. */

  int32_t hidden; /* the mesh is not to be seen from here to its next pose; needs KINORA_WRITES_HIDDEN, else 0 */
} KinoraMeshPose;

/* A quantity of a volume. Names are "density" (1 component: extinction per metre) and "color" (3 components: linear
 * light with the primaries of sRGB, as the camera saw it); writers pass over names that they do not know. Embedded. */
typedef struct KinoraVolumeChannel {
  const char* name;
  int32_t components;  /* 1 or 3 */
  const float* values; /* `components` per voxel */
} KinoraVolumeChannel;

/* A sparse volume at one time; voxels that are not listed are empty. */
typedef struct KinoraVolume {
  KINORA_STRUCT_HEADER;
  const char* name;
  int64_t frame;             /* number of the frame in the clip, from 0 */
  double time;               /* seconds from the start */
  double voxel_to_world[16]; /* carries a voxel's number (its centre) to metres */
  size_t voxel_count;
  const int32_t* voxels; /* 3 per voxel, each listed once */
  size_t channel_count;
  const KinoraVolumeChannel* channels;
} KinoraVolume;

/* Checked by the host against the list before it is handed over; options not given are absent. Embedded. */
typedef struct KinoraOptionValue {
  const char* name;
  const char* value;
} KinoraOptionValue;

/* One of the numbered outputs of a sequence of volumes. Embedded. */
typedef struct KinoraVolumeFile {
  const char* name; /* of the file, which is in the folder of the index */
  double time;      /* seconds from the start, increasing */
  double low[3];    /* the box around its voxels, metres in the world; low > high where it is not known or empty */
  double high[3];
} KinoraVolumeFile;

/* What an index of a sequence of volumes says. */
typedef struct KinoraVolumeSequence {
  KINORA_STRUCT_HEADER;
  double frames_per_second; /* nominal */
  size_t file_count;        /* at least 1 */
  const KinoraVolumeFile* files;
  size_t fact_count; /* as of writer_facts */
  const KinoraOptionValue* facts;
} KinoraVolumeSequence;

/* ---- a format */

enum { /* KinoraFormat.capabilities */
       KINORA_READS_FRAMES = 1u << 0,
       KINORA_SEEKS = 1u << 1,
       KINORA_READS_POSES = 1u << 2,
       KINORA_READS_MASKS = 1u << 3,
       KINORA_READS_CONFIDENCE = 1u << 4, /* of depth */
       KINORA_READS_INFRARED = 1u << 5,
       KINORA_READS_DEVICE = 1u << 6, /* a live camera, of which the path is "NAME:DEVICE" with the format's name */
       KINORA_READS_SOUND = 1u << 7,
       KINORA_WRITES_FRAMES = 1u << 8, /* captures: frames with colour, depth and calibration */
       KINORA_WRITES_TIMES = 1u << 9,  /* of frames; else they follow one another at the nominal rate */
       KINORA_WRITES_POSES = 1u << 10,
       KINORA_WRITES_MASKS = 1u << 11,
       KINORA_WRITES_INFRARED = 1u << 12,
       KINORA_WRITES_DEPTH_CAMERA = 1u << 13,   /* depth that is not registered; else the host gives no such capture */
       KINORA_WRITES_VOLUME_INDEX = 1u << 14,   /* a file that shows the volumes of a sequence one after another */
       KINORA_WRITES_PICTURE_LAYERS = 1u << 15, /* KinoraPicture.layers */
       KINORA_WRITES_PICTURES = 1u << 16,
       KINORA_WRITES_FILM = 1u << 17,  /* pictures of one size, shown one after another */
       KINORA_WRITES_ALPHA = 1u << 18, /* else the host composites on black */
       KINORA_WRITES_DEPTH = 1u << 19,
       KINORA_WRITES_MESHES = 1u << 20,       /* and their motion, if it writes skins */
       KINORA_WRITES_SKINS = 1u << 21,        /* else meshes stay as they are in their own space */
       KINORA_WRITES_VOLUMES = 1u << 22,      /* one in each output: the host numbers the files */
       KINORA_WRITES_NORMALS = 1u << 23,      /* of pictures */
       KINORA_WRITES_CONFIDENCE = 1u << 24,   /* of pictures, and of the depth of frames */
       KINORA_WRITES_TEXTURES = 1u << 25,     /* of meshes; else the host gives them colours in their vertices */
       KINORA_WRITES_MESH_FRAME = 1u << 26,   /* the meshes of one time in each output, where they are in the world, or
                                                 none if none is there then: the host numbers the files */
       KINORA_WRITES_METRIC_DEPTH = 1u << 27, /* of pictures: KinoraPicture.metric_depth */
       KINORA_WRITES_LABELS = 1u << 28,       /* of pictures, with what they mean */
       KINORA_WRITES_CAMERAS = 1u << 29,      /* of pictures */
       KINORA_WRITES_FILES_BESIDE = 1u << 30  /* of meshes: further files beside the output, such as textures; the host
                                                 gives a path of the output's name in a folder of its own, and moves
                                                 what is found there */
                                              /* All other bits are reserved and 0. */
};
#define KINORA_WRITES_SOUND ((uint64_t)1 << 31)  /* of captures; C's enumerators end before it */
#define KINORA_WRITES_HIDDEN ((uint64_t)1 << 32) /* of meshes: KinoraMeshPose.hidden; else they are always seen */

/* An option that a user may set with -O name=value. Embedded, for options stand in an array. */
typedef struct KinoraOption {
  const char* name;
  const char* type;          /* "int", "number", "bool" (true|false), "text", or words to choose from: "fast|small" */
  const char* default_value; /* as text */
  const char* help;          /* one sentence */
  const void* reserved;      /* NULL */
} KinoraOption;

/* The answer of `probe`. */
typedef struct KinoraProbe {
  KINORA_STRUCT_HEADER;
  int32_t confidence; /* 0 not mine, 50 looks like it, 100 certain */
  char reason[256];   /* what was found, or what is missing */
} KinoraProbe;

typedef struct KinoraReader KinoraReader; /* the plugin's own */
typedef struct KinoraWriter KinoraWriter; /* the plugin's own */

typedef struct KinoraFormat {
  KINORA_STRUCT_HEADER;
  const char* name;        /* lower case, digits and '-'; unique among all plugins */
  const char* description; /* one line */
  const char* extensions;  /* of what it writes, with dots, separated by spaces: ".png"; "" if none */
  uint64_t capabilities;
  const KinoraOption* options; /* may be NULL */
  size_t option_count;

  /* Says whether the file or folder is of this format, by its content. Cheap (no image is decoded), changes nothing,
   * never fails. NULL if the format is not read. */
  void (*probe)(const char* path, KinoraProbe* answer);

  /* Reading: needs KINORA_READS_FRAMES, else all NULL. `*reader` is set only with KINORA_OK. */
  KinoraStatus (*open_reader)(const char* path, const KinoraOptionValue* options, size_t option_count,
                              KinoraReader** reader, KinoraMessage* message);
  KinoraStatus (*reader_info)(KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message);
  /* KINORA_OK, KINORA_END, KINORA_BAD_FRAME, or an error after which only close is allowed. */
  KinoraStatus (*reader_next)(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message);
  /* The next frame will be that with this index. NULL without KINORA_SEEKS. */
  KinoraStatus (*reader_seek)(KinoraReader* reader, int64_t index, KinoraMessage* message);
  void (*reader_close)(KinoraReader* reader);

  /* Writing: needs a capability KINORA_WRITES_..., else all NULL. writer_write needs KINORA_WRITES_PICTURES. Writes
   * exactly to `path`, whatever its extension; what existed there is replaced. A format of frames without extensions
   * writes a folder, which is there and empty. `*writer` is set only with KINORA_OK. */
  KinoraStatus (*open_writer)(const char* path, const KinoraOptionValue* options, size_t option_count,
                              KinoraWriter** writer, KinoraMessage* message);
  KinoraStatus (*writer_write)(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message);
  /* Completes the output and frees the writer, whatever it returns. */
  KinoraStatus (*writer_finish)(KinoraWriter* writer, KinoraMessage* message);
  /* Frees the writer without completing; a started output may stay, incomplete. */
  void (*writer_abandon)(KinoraWriter* writer);

  /* Formats that were made before these members existed end here. */

  /* Needs KINORA_WRITES_MESHES, else NULL. All meshes come before the first pose. */
  KinoraStatus (*writer_mesh)(KinoraWriter* writer, const KinoraMesh* mesh, KinoraMessage* message);
  /* Needs KINORA_WRITES_SKINS, else NULL. */
  KinoraStatus (*writer_pose)(KinoraWriter* writer, const KinoraMeshPose* pose, KinoraMessage* message);
  /* Needs KINORA_WRITES_VOLUMES, else NULL. Called once. */
  KinoraStatus (*writer_volume)(KinoraWriter* writer, const KinoraVolume* volume, KinoraMessage* message);

  /* Formats that were made before these members existed end here. Both need KINORA_WRITES_FRAMES, else NULL. */

  /* What holds for all frames; called once, before the first frame. There are no warnings in it. */
  KinoraStatus (*writer_capture)(KinoraWriter* writer, const KinoraCaptureInfo* info, KinoraMessage* message);
  /* A frame as a reader hands it out. KINORA_BAD_FRAME: it does not fit those before and is left out. */
  KinoraStatus (*writer_frame)(KinoraWriter* writer, const KinoraFrame* frame, KinoraMessage* message);

  /* Formats that were made before this member existed end here. */

  /* How the output was made, for its own metadata, as names and texts: "source", "frames", "fps", "layers", "lost" and
   * others. Called at most once, before all that is written. NULL if the format has no place for it. */
  KinoraStatus (*writer_facts)(KinoraWriter* writer, const KinoraOptionValue* facts, size_t count,
                               KinoraMessage* message);

  /* Formats that were made before these members existed end here. */

  /* Sound that comes with the frames. Both need KINORA_READS_SOUND, else NULL. KINORA_END: this capture has none. */
  KinoraStatus (*reader_sound)(KinoraReader* reader, KinoraSound* sound, KinoraMessage* message);
  /* The next packet from the capture's beginning on, whichever frames have been read; its bytes are valid until the
   * next call of this function. KINORA_END: there is no further one. Times never decrease. */
  KinoraStatus (*reader_sound_packet)(KinoraReader* reader, KinoraSoundPacket* packet, KinoraMessage* message);
  /* Both need KINORA_WRITES_SOUND, else NULL. Called at most once, before the first frame. */
  KinoraStatus (*writer_sound)(KinoraWriter* writer, const KinoraSound* sound, KinoraMessage* message);
  /* Each comes before the first frame that is later. */
  KinoraStatus (*writer_sound_packet)(KinoraWriter* writer, const KinoraSoundPacket* packet, KinoraMessage* message);

  /* Formats that were made before these members existed end here. Both need KINORA_WRITES_VOLUME_INDEX, else NULL. */

  const char* index_extension; /* of the index, with its dot */
  /* Writes the index to exactly `path`; `options` are those of the volumes. */
  KinoraStatus (*write_volume_index)(const char* path, const KinoraOptionValue* options, size_t option_count,
                                     const KinoraVolumeSequence* sequence, KinoraMessage* message);
} KinoraFormat;

typedef struct KinoraPlugin {
  KINORA_STRUCT_HEADER;
  const char* name;
  const char* version;
  const KinoraFormat* const* formats;
  size_t format_count;
} KinoraPlugin;

/* What an external plugin exports under the name "kinora_plugin". Returns NULL if it cannot work with the host's
 * version of this interface. Called once, after loading. */
typedef const KinoraPlugin* (*KinoraPluginEntry)(uint32_t host_abi_version);
#define KINORA_PLUGIN_ENTRY "kinora_plugin"

/* ---- what the host gives
 *
 * A plugin that exports kinora_plugin_host is given this once, after kinora_plugin has answered and before anything of
 * it is used. It stays as it is for the life of the process; its functions may be called from any thread. No plugin
 * needs it. */
typedef struct KinoraFile KinoraFile; /* the host's own */

typedef struct KinoraHost {
  KINORA_STRUCT_HEADER;
  /* One sentence for the user. A warning is always shown, the rest to who wants to know more (-v). */
  void (*log)(const char* sentence, int32_t is_warning);
  /* Memory as malloc gives it, NULL if there is none; what is left over is released with `release`, also NULL. */
  void* (*allocate)(size_t bytes);
  void (*release)(void* memory);
  /* A regular file that is read at any place. NULL with a message if it cannot be opened; `bytes` is its size. */
  KinoraFile* (*open_file)(const char* path, uint64_t* bytes, KinoraMessage* message);
  /* All `bytes` from `offset` on, or KINORA_CORRUPT with a message if the file ends before. */
  KinoraStatus (*read_file)(KinoraFile* file, uint64_t offset, void* to, size_t bytes, KinoraMessage* message);
  void (*close_file)(KinoraFile* file);
  /* How far something is that takes long, such as opening: `done` of `total` steps. Not 0: the user wants to stop, and
   * the plugin shall come back soon with KINORA_FAILURE. */
  int32_t (*progress)(uint64_t done, uint64_t total);
} KinoraHost;
typedef void (*KinoraPluginHostEntry)(const KinoraHost* host);
#define KINORA_PLUGIN_HOST_ENTRY "kinora_plugin_host"

/* The formats that come with Kinora, in the same form. */
const KinoraPlugin* kinora_builtin_plugin(void);

#ifdef __cplusplus
}
#endif

#endif
