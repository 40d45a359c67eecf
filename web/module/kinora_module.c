/* The player's C interface without structs: JavaScript passes numbers and arrays of numbers. Functions return a
 * KinoraPlayerStatus, or the number that they are asked for; kinora_player_error() says what is wrong. */
#include <kinora/player.h>

#include <string.h>

/* frames, duration, frames per second, layers */
KinoraPlayerStatus module_info(const KinoraPlayer* player, double out[4]) {
  KinoraPlayerInfo info = {.struct_size = sizeof info};
  const KinoraPlayerStatus status = kinora_player_info(player, &info);
  if (status != KINORA_PLAYER_OK) return status;
  out[0] = (double)info.frames;
  out[1] = info.duration;
  out[2] = info.frames_per_second;
  out[3] = info.layers;
  return KINORA_PLAYER_OK;
}

/* Name and motion as text; 1 if the layer has confidence, 0 if not, -1 if there is no such layer. */
int module_layer(const KinoraPlayer* player, uint32_t layer, const char** name, const char** motion) {
  KinoraPlayerLayer about = {.struct_size = sizeof about};
  if (kinora_player_layer(player, layer, &about) != KINORA_PLAYER_OK) return -1;
  *name = about.name;
  *motion = about.motion;
  return about.has_confidence;
}

KinoraPlayerStatus module_frame_times(const KinoraPlayer* player, uint32_t frames, double* seconds) {
  for (uint32_t i = 0; i < frames; ++i) {
    const KinoraPlayerStatus status = kinora_player_frame_time(player, i, seconds + i);
    if (status != KINORA_PLAYER_OK) return status;
  }
  return KINORA_PLAYER_OK;
}

/* width, height, fx, fy, cx, cy, then camera_to_world, 16 */
KinoraPlayerStatus module_capture_camera(const KinoraPlayer* player, double seconds, double out[22]) {
  KinoraPlayerCamera camera = {.struct_size = sizeof camera};
  const KinoraPlayerStatus status = kinora_player_capture_camera(player, seconds, &camera);
  if (status != KINORA_PLAYER_OK) return status;
  const double intrinsics[6] = {camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy};
  memcpy(out, intrinsics, sizeof intrinsics);
  memcpy(out + 6, camera.camera_to_world, sizeof camera.camera_to_world);
  return KINORA_PLAYER_OK;
}

/* `camera` as module_capture_camera gives it; `visible` one byte for each layer; `color` 4 bytes and `depth`, which may
 * be NULL, one float for each pixel. */
KinoraPlayerStatus module_draw(KinoraPlayer* player, double seconds, const double camera[22], const uint8_t* visible,
                               KinoraPlayerView view, int preview, uint8_t* color, float* depth) {
  KinoraPlayerRequest request = {
      .struct_size = sizeof request, .seconds = seconds, .visible = visible, .preview = preview};
  request.camera = (KinoraPlayerCamera){.struct_size = sizeof request.camera,
                                        .width = (int32_t)camera[0],
                                        .height = (int32_t)camera[1],
                                        .fx = camera[2],
                                        .fy = camera[3],
                                        .cx = camera[4],
                                        .cy = camera[5]};
  memcpy(request.camera.camera_to_world, camera + 6, sizeof request.camera.camera_to_world);
  const KinoraPlayerPicture picture = {.struct_size = sizeof picture, .view = view, .color = color, .depth = depth};
  return kinora_player_render(player, &request, &picture);
}
