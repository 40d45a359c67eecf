// How large pictures are while something moves: resolution drops before frames do.
#pragma once

namespace kinora::player::window {

/// Not thread-safe.
class MovingResolution {
public:
  static constexpr double kWantedMilliseconds = 30; ///< of a picture: as often as a clip's frames come
  static constexpr double kLeastOfWanted = 0.7, kMostOfWanted = 1.05; ///< so little is worth no other size
  static constexpr double kSmallest = 1.0 / 8, kLargest = 1;

  /// Of a picture's sides, as a fraction of the window's.
  double scale() const { return scale_; }
  /// What a picture of that scale took: goes half of the way towards the scale that takes as long as is wanted.
  void took(double milliseconds);

private:
  double scale_ = 0.5;
};

} // namespace kinora::player::window
