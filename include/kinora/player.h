/* The C interface of Kinora's player: a volumetric video (a clip that `kinora encode` made) seen by any camera at any
 * of its times. Library: kinora_player (CMake: find_package(Kinora COMPONENTS player), target Kinora::player;
 * pkg-config: kinora-player).
 *
 * Units: metres, seconds. Camera axes: x right, y down, z forward. Pixel centres lie at integer coordinates. Matrices
 * are 4x4, row by row. The world is that of the clip. Times are the clip's own, in which the first frame is usually at
 * 0. Text is UTF-8.
 *
 * Errors. A function returns a KinoraPlayerStatus; kinora_player_error() then is one sentence that says what is wrong,
 * where, and what helps. No exception leaves the library, and it never prints. Pointers must not be NULL unless said.
 *
 * Threads. Every function may be called for one player by several threads at once, but for kinora_player_close(), which
 * must be the last. Renderings of one player run side by side. Callbacks come in the thread that made the call.
 *
 * Memory. A clip is read whole: a player holds its parameters, what is derived from them to draw, and its motion, and
 * grows no further. Buffers of pictures are the caller's. A clip that is not trusted may make the
 * player take 64 times its size and a quarter of a gigabyte at most, or is refused.
 *
 * Versions. Structs begin with their own size: fill `struct_size` with sizeof; they grow only at their ends.
 */
#ifndef KINORA_PLAYER_H
#define KINORA_PLAYER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t KinoraPlayerStatus;
enum {
  KINORA_PLAYER_OK = 0,
  KINORA_PLAYER_FAILURE = 1,        /* anything not named here */
  KINORA_PLAYER_USAGE = 2,          /* the call makes no sense */
  KINORA_PLAYER_NOT_RECOGNISED = 3, /* no clip, or none that this version reads */
  KINORA_PLAYER_CORRUPT = 4,        /* a clip, but damaged or cut short */
  KINORA_PLAYER_CANCELLED = 130     /* kinora_player_cancel(), or a callback that returned 0 */
};

/* One sentence about the last call of this thread that failed; "" if none has. Valid until this thread's next call. */
const char* kinora_player_error(void);

typedef struct KinoraPlayer KinoraPlayer;

/* ---- opening and closing */

KinoraPlayerStatus kinora_player_open_file(const char* path, KinoraPlayer** player);

/* The bytes are used during the call alone. `name` is said in errors. */
KinoraPlayerStatus kinora_player_open_memory(const void* bytes, size_t size, const char* name, KinoraPlayer** player);

/* Bytes that the caller fetches: from an archive, a network, a sandbox. kinora_player_open_source() uses it during
 * the call alone. */
typedef struct KinoraPlayerSource {
  uint32_t struct_size;
  const char* name; /* said in errors */
  void* context;    /* given back to the callback */
  uint64_t size;    /* of all bytes */
  /* Fills `out` with `count` bytes from `offset`, which lie inside; at most 1 MiB a call. Returns 1, or 0 if it cannot.
   */
  int (*read)(void* context, uint64_t offset, void* out, size_t count);
  /* For kinora_player_follow_source(): how many bytes there are by now, no fewer than before. NULL, or a struct that
   * ends before: they do not become more. */
  uint64_t (*new_size)(void* context);
} KinoraPlayerSource;

KinoraPlayerStatus kinora_player_open_source(const KinoraPlayerSource* source, KinoraPlayer** player);

/* Clips that are damaged or cut short, still being written, or slow to come: what is whole is shown. They return as
 * soon as there is something to show, or with an error if there never will be; the rest is read by a thread of the
 * player's own, which calls the source's functions, one at a time, until the player is closed: closing waits for the
 * call that is under way. A read() that returns 0 ends the reading; what has come stays. Files up to 1 GiB, which are
 * kept in memory until they have come. */
KinoraPlayerStatus kinora_player_follow_file(const char* path, KinoraPlayer** player);
KinoraPlayerStatus kinora_player_follow_source(const KinoraPlayerSource* source, KinoraPlayer** player);

typedef struct KinoraPlayerArrival {
  uint32_t struct_size;
  int32_t more;        /* 1: there is more than before this call: layers or frames. Ask for infos again */
  int32_t complete;    /* 1: nothing more will come */
  const char* message; /* what is awaited, missing or wrong; "": nothing. Valid until this thread's next update */
} KinoraPlayerArrival;

/* Takes what has come; nothing changes but by this call. Layers may be numbered anew, and `visible` of a request must
 * be of as many as there are now: let no rendering begin meanwhile. The clock goes on, and waits at the end of what has
 * come. */
KinoraPlayerStatus kinora_player_update(KinoraPlayer* player, KinoraPlayerArrival* arrival);

/* NULL is allowed. */
void kinora_player_close(KinoraPlayer* player);

/* ---- what a clip holds */

typedef struct KinoraPlayerInfo {
  uint32_t struct_size;
  uint32_t layers;
  uint64_t frames;
  uint64_t bytes;           /* of the file */
  double duration;          /* seconds from the first frame's time to the last's */
  double frames_per_second; /* in the mean; 30 if there is one frame */
  int32_t width, height;    /* of the camera that captured it, pixels */
  double fx, fy, cx, cy;
} KinoraPlayerInfo;

KinoraPlayerStatus kinora_player_info(const KinoraPlayer* player, KinoraPlayerInfo* info);

typedef struct KinoraPlayerLayer {
  uint32_t struct_size;
  int32_t label;          /* of the capture's masks */
  const char* name;       /* "background", "person", "object", ...; lives as long as the player */
  const char* motion;     /* "still", "rigid" or "deforming" */
  int32_t has_confidence; /* 1 if the clip says how well its surfaces were seen */
} KinoraPlayerLayer;

KinoraPlayerStatus kinora_player_layer(const KinoraPlayer* player, uint32_t layer, KinoraPlayerLayer* about);

/* Time of a frame, which counts from 0. */
KinoraPlayerStatus kinora_player_frame_time(const KinoraPlayer* player, uint64_t frame, double* seconds);

/* ---- pictures */

typedef struct KinoraPlayerCamera {
  uint32_t struct_size;
  int32_t width, height; /* 1 to 16384 */
  double fx, fy, cx, cy;
  double camera_to_world[16];
} KinoraPlayerCamera;

/* What the clip is about when a time has come, in world coordinates (metres): what a camera turns around. */
KinoraPlayerStatus kinora_player_subject(const KinoraPlayer* player, double seconds, double position[3]);

/* Where the capture's camera was. Set struct_size; the rest is filled. */
KinoraPlayerStatus kinora_player_capture_camera(const KinoraPlayer* player, double seconds, KinoraPlayerCamera* camera);
/* The same view in a picture of another size. */
KinoraPlayerStatus kinora_player_resize_camera(KinoraPlayerCamera* camera, int32_t width, int32_t height);

/* What `color` shows. */
typedef int32_t KinoraPlayerView;
enum {
  KINORA_PLAYER_COLOR = 0,
  KINORA_PLAYER_DEPTH = 1,  /* grey: near is bright, from the nearest to the farthest of the picture */
  KINORA_PLAYER_NORMAL = 2, /* of the camera: x right, y up, z back, as colours */
  KINORA_PLAYER_CONFIDENCE =
      3,                   /* red where no camera saw what is shown, over yellow, to green where they saw it well */
  KINORA_PLAYER_HEALTH = 4 /* at this time: green where a layer was tracked, yellow where held, red where lost */
};

/* The caller's buffers, each for width x height pixels of the camera, rows from the top; NULL: not wanted. */
typedef struct KinoraPlayerPicture {
  uint32_t struct_size;
  KinoraPlayerView view;
  uint8_t* color;         /* 4 bytes each: sRGB and straight alpha, the opacity of what is drawn */
  size_t color_row_bytes; /* from one row to the next; 0: 4 x width */
  float* depth;           /* metres along the optical axis; 0: nothing there. Without gaps, as the rest */
  float* normal;          /* 3 each: unit vectors in the camera's frame, 0 where there is nothing */
  uint8_t* confidence;    /* 255: what is shown was seen well; 0: never, or nothing there */
} KinoraPlayerPicture;

typedef struct KinoraPlayerRequest {
  uint32_t struct_size;
  KinoraPlayerCamera camera;
  double seconds;         /* any time; clamped to the clip */
  const uint8_t* visible; /* one per layer, 0: hidden; NULL: all are drawn */
  /* A coarse picture of 1/8 of the size comes first, then 1/4, 1/2 and the full one: each fills the buffers and is told
   * to `refined`, with `finest` 1 for the last. NULL: the full picture alone. It returns 1, or 0 to stop there. */
  int (*refined)(void* context, int32_t finest);
  void* context;
  /* 1: one sample to a pixel, whatever the capture's size: faster in pictures smaller than it, for what is seen
   * while something moves. 0, or a struct that ends before: as many as the picture needs. */
  int32_t preview;
} KinoraPlayerRequest;

/* Draws with all cores. Cancelled, or with an error, the buffers hold the last picture that was whole. */
KinoraPlayerStatus kinora_player_render(KinoraPlayer* player, const KinoraPlayerRequest* request,
                                        const KinoraPlayerPicture* picture);

/* Stops all renderings of this player that are under way, each before its next refinement. */
void kinora_player_cancel(KinoraPlayer* player);

/* ---- the clock: which time is to be shown now */

/* Starts at 0, paused, at speed 1, without repeating. Times that it gives are those of frames: the last frame whose
 * time has come. */
double kinora_player_time(const KinoraPlayer* player);
uint64_t kinora_player_frame(const KinoraPlayer* player);
int kinora_player_is_playing(const KinoraPlayer* player); /* 0 also when the end was reached */

void kinora_player_play(KinoraPlayer* player); /* from the start, if it stands at the end */
void kinora_player_pause(KinoraPlayer* player);
KinoraPlayerStatus kinora_player_seek(KinoraPlayer* player, double seconds); /* clamped; plays on if it plays */
void kinora_player_step(KinoraPlayer* player, int frames);                   /* pauses; back if negative */
/* 1/16 to 16. */
KinoraPlayerStatus kinora_player_set_speed(KinoraPlayer* player, double speed);
void kinora_player_set_loop(KinoraPlayer* player, int loop);

/* Whose time goes on while the clip plays: with sound, the seconds of sound that have been heard (a device that
 * stalls then holds the picture too); NULL: the system's steady clock. It need not start at 0, must not go back, and
 * may be asked by any thread. Speed still counts: 1 for sound at its own pace. */
void kinora_player_set_master(KinoraPlayer* player, double (*seconds)(void* context), void* context);

#ifdef __cplusplus
}
#endif

#endif
