// Labels for captures that bring no masks.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "ingest/capture.h"

namespace kinora::ingest {

/// Opens the capture anew, for a range of its frames.
using CaptureFactory = std::function<std::unique_ptr<Capture>(const FrameRange&)>;

/// What a label was given for.
struct FoundLabel {
  LabelInfo info;  ///< name and kind ("deforming", "rigid" or "still")
  std::string why; ///< one sentence for the report
};

/// Labels frames: 0 background, 1 person, 2… things that are handled. Two passes: `prepare` looks at the capture once,
/// then `label` is called for its frames in order. Not thread-safe; the same bits for any number of threads.
class Segmenter {
public:
  virtual ~Segmenter() = default;
  /// The first pass over the frames of `range`; may read only some of them. Throws what the capture throws.
  virtual void prepare(const CaptureFactory& open, const FrameRange& range, Progress& progress) = 0;
  /// Fills in `frame.labels`. Frames come in the order of the capture; some may be left out.
  virtual void label(Frame& frame) = 0;
  /// The labels that were found, 0 among them; complete after `prepare`.
  virtual const std::map<int, FoundLabel>& labels() const = 0;
};

/// Without a network, for a still camera: what differs from the background or wavers is in front of it, what is flat
/// or was seen alone is a thing, the rest is a person. With a moving camera everything is background, and says so.
std::unique_ptr<Segmenter> make_motion_segmenter();

} // namespace kinora::ingest
