// Labels for captures that bring no masks.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "ingest/capture/capture.h"

namespace kinora::ingest {

/// Opens the capture anew, for a range of its frames.
using CaptureFactory = std::function<std::unique_ptr<Capture>(const FrameRange&)>;

/// Labels frames: 0 background, 1 person, 2… things that are handled. Two passes: `prepare` looks at the capture once,
/// then `label` is called for its frames in order. Not thread-safe; the same bits for any number of threads.
class Segmenter {
public:
  virtual ~Segmenter() = default;
  /// The first pass over the frames of `range`; may read only some of them. Throws what the capture throws.
  virtual void prepare(const CaptureFactory& open, const FrameRange& range, Progress& progress) = 0;
  /// Fills in `frame.labels`. Frames come in the order of the capture; some may be left out.
  virtual void label(Frame& frame) = 0;
  /// The labels that were found, 0 among them, with all that LabelInfo tells; complete after `prepare`.
  virtual const std::map<int, LabelInfo>& labels() const = 0;
};

/// Without a network, for a camera that is still or whose frames know where it is: what differs from the background or
/// wavers is in front of it, what is flat or was seen alone is a thing, the rest is a person. Where hardly anything
/// keeps still everything is background, and says so.
std::unique_ptr<Segmenter> make_motion_segmenter();

/// The same, but all that is in front of the background gets label 1, at the size at which scenes are taken apart: in a
/// fraction of the time. Frames may come in any order.
std::unique_ptr<Segmenter> make_foreground_segmenter();

/// Everything that is measured and lies on none of a frame's wide planes gets label 1: floor, walls and tables are
/// left. Needs no first pass; frames may come in any order.
std::unique_ptr<Segmenter> make_plane_segmenter();

/// The capture whose frames come in `range`, with a segmenter's labels in place of its own: it has masks, and every
/// frame's are complete. `open` must not read masks. The first pass is made here. Throws what the capture throws.
std::unique_ptr<Capture> segmented_capture(const CaptureFactory& open, const FrameRange& range,
                                           std::unique_ptr<Segmenter> segmenter, Progress& progress);

struct LiveLabelling {
  double watched = 1;        ///< seconds, at least, that are seen before anything is told apart; no frame comes of them
  bool learns_beside = true; ///< on a thread of its own; else where it is: the same bits each time
};

/// The capture with labels that are told while it goes on, by the rules of make_motion_segmenter for what was seen
/// until then. What is seen later is learnt from as well, whenever twice as much was seen: things that are found then
/// get new labels in info(), others keep theirs. A capture that ends before comes labelled by what there is of it, its
/// last 48 frames at most. Its `capture` must outlive it and not read masks.
std::unique_ptr<Capture> live_segmented_capture(Capture& capture, const LiveLabelling& how, Progress& progress);

} // namespace kinora::ingest
