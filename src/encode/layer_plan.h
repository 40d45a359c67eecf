// Which labels of a capture become layers of a clip, under which name and with which motion.
#pragma once

#include <string>

#include "ingest/capture/capture.h"
#include "motion/motion.h"

namespace kinora::encode {

struct LayerPlan {
  int label = 0;
  std::string name;
  motion::MotionKind motion = motion::MotionKind::kStill;
  bool is_specified = false; ///< the capture itself says which motion: what is seen does not change it
  std::string why;           ///< one sentence for the report
};

/// The label's default (0 background, still; 1 person, deforming; 2 object, rigid; n > 2 object(n−1), rigid), unless
/// the capture's labels.json or a segmenter says otherwise.
/// Throws Error(kCorruptInput) for a kind that does not exist.
LayerPlan plan_layer(int label, const ingest::CaptureInfo& capture);

} // namespace kinora::encode
