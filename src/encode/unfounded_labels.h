// Labels that a segmenter told from the room, and whose motion tracking could not follow, or that explains no more than
// the room does: no layer is made of them.
#pragma once

#include "encode/frame_pass.h"
#include "encode/training_plan.h"

namespace kinora::encode {

/// The share of a label's measured pixels whose place and colour other frames show again: their depth agrees within
/// what a sensor tells, or what they see behind that place has the same colour (far depth is noisy). Of those alone
/// before which nothing else stands. 1 for what keeps still, lower for what goes away from before something of another
/// colour. Looks at up to eight frames of the store, spread over those that show the label. 0 if no pair of frames
/// tells.
double still_share(const fields::PixelStore& pixels, int label);

/// Looks at a label's measured pixels in other frames: the surface and the colour are again where they were, or where
/// the label's motion carries them.
struct MotionGain {
  double looks = 0;     ///< whether they tell or not, by how rarely a store keeps all pixels that they need
  double told = 0;      ///< those at which both places are in view
  double at_rest = 0;   ///< of these, found where they were
  double by_motion = 0; ///< found where motion carries them
  /// Looks at the room's pixels (label 0) in the same frames that tell, and those that find them where they were; only
  /// from camera to camera elsewhere: what is wrong with their places lets the room seem to move, too.
  double room_told = 0;
  double room_at_rest = 0;

  /// Motion explains the pictures better than rest: at one of 200 looks, and a fifth of those that rest fails at; and
  /// rest fails twice as often as with the room. Also where rest explains less than half of what is told, or nothing
  /// is.
  bool pays() const;
};

/// From up to eight frames that show the label and that its motion follows, to those 1, 2, 4 … such frames away from
/// them.
MotionGain motion_gain(const fields::PixelStore& pixels, int label, const motion::Motion& motion, std::size_t frames);

/// Takes from `pass` every label that moves, that a segmenter found (LabelInfo::why), not a mask, and that is held or
/// lost in more than half of the stored frames that show it, or whose motion does not pay. Where its still_share is at
/// least one half the room explains it, and its pixels become the room's (label 0); else they are trained on nowhere.
/// Returns the labels with their reasons.
std::vector<NotModelled> drop_unfounded_labels(FramePass& pass, const ingest::CaptureInfo& capture);

} // namespace kinora::encode
