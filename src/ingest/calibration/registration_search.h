// Whether a capture's colour really is registered to its depth, told from how surfaces look from several places.
// Source: colour agreement of points seen from two poses, as in Forster, Pizzoli, Scaramuzza, "SVO", ICRA 2014, here
// solved for the colour camera instead of the pose; normalised by pair, so that exposure does not matter.
#pragma once

#include <cstddef>
#include <optional>

#include "ingest/capture/capture.h"

namespace kinora::ingest {

struct FoundRegistration {
  /// What to read the capture with (CaptureOptions::registration); nothing where the capture's own claim stands.
  std::optional<RegistrationGeometry> geometry;
  std::size_t pairs = 0;           ///< of views that were compared; 0: nothing could be told
  double unexplained_as_given = 0; ///< 1 − correlation of the brightness of points that two views see, as claimed …
  double unexplained = 0;          ///< … and with the best colour camera; both on pairs that it was not fitted to
};

/// Looks at views of a capture that brings camera poses and says that colour and depth are one camera's. Solves for the
/// focal length and the principal point of the colour camera; what the views do not tell stays as claimed.
/// `geometry` is set only if it explains the views clearly better. `capture` is read up to its 600th frame.
/// The same bits for any number of threads. Throws what the capture throws.
FoundRegistration search_registration(Capture& capture, Progress& progress);

} // namespace kinora::ingest
