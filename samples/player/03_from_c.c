/* Plays a clip once along the clock, in plain C, and says which frames a viewer would have seen.
 * usage: 03_from_c CLIP.mkv */
#include <stdio.h>
#include <stdlib.h>

#include <kinora/player.h>

static int fail(void) {
  fprintf(stderr, "%s\n", kinora_player_error());
  return 1;
}

static int play(KinoraPlayer* player) {
  KinoraPlayerRequest request = {0};
  KinoraPlayerPicture picture = {0};
  unsigned long long shown = 0, last = 0;
  int playing;
  request.struct_size = sizeof request;
  request.camera.struct_size = sizeof request.camera;
  picture.struct_size = sizeof picture;
  if (kinora_player_capture_camera(player, 0, &request.camera) != KINORA_PLAYER_OK) return fail();
  if (kinora_player_resize_camera(&request.camera, 160, 120) != KINORA_PLAYER_OK) return fail();
  picture.color = malloc((size_t)4 * 160 * 120);
  if (picture.color == NULL) return 1;
  kinora_player_play(player);
  do {
    playing = kinora_player_is_playing(player);   /* asked before the frame, so that the last one is shown too */
    request.seconds = kinora_player_time(player); /* of the frame that is due: a slow machine leaves frames out */
    last = kinora_player_frame(player);
    if (kinora_player_render(player, &request, &picture) != KINORA_PLAYER_OK) {
      free(picture.color);
      return fail();
    }
    ++shown; /* here picture.color goes to the screen */
  } while (playing);
  printf("%llu pictures, the last of frame %llu\n", shown, last);
  free(picture.color);
  return 0;
}

int main(int count, char** words) {
  KinoraPlayer* player = NULL;
  int result;
  if (count != 2) {
    fprintf(stderr, "usage: 03_from_c CLIP.mkv\n");
    return 2;
  }
  if (kinora_player_open_file(words[1], &player) != KINORA_PLAYER_OK) return fail();
  result = play(player);
  kinora_player_close(player);
  return result;
}
