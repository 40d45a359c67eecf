// What a camera that stands still shows of the room at one place in all frames: the room's surface there is one, and
// whatever moves is before it.
#pragma once

#include "fields/sampling/pixel_store.h"

namespace kinora::encode {

/// Near where something moves, pixels of the background get a label that nobody has if they are measured, or guessed
/// from near, clearly before what most frames measure of the room there, or before what they measure of things that
/// move: they show something else. Guesses of the room from afar move back behind what other frames measure of things
/// that move, or to where they measure the room. From a moving camera nothing changes. The same bits for any number of
/// threads.
void correct_still_room(fields::PixelStore& pixels);

} // namespace kinora::encode
