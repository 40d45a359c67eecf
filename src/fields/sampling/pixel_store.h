// What training remembers of the frames: a bounded set of pixels with colour, depth and label.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/color_gain.h"
#include "core/large_buffer.h"
#include "core/rolling_shutter.h"
#include "ingest/frame/frame.h"

namespace kinora::fields {

/// What is known of a pixel's depth; 4 bytes.
class StoredDepth {
public:
  static StoredDepth measured(float metres) { return StoredDepth(metres); } ///< and clean; more than 0
  static StoredDepth guessed(float metres) { return StoredDepth(-metres); } ///< from clean neighbours; 0: unknown
  /// From a surface that goes on, with nothing clean near (extend_surfaces); 0: unknown.
  static StoredDepth extended(float metres) { return StoredDepth(metres > 0 ? -metres - kExtended : 0); }
  static StoredDepth unknown() { return StoredDepth(0); }

  /// As well known, at another depth; more than 0.
  StoredDepth at(float metres) const {
    return is_extended() ? extended(metres) : is_guessed() ? guessed(metres) : is_measured() ? measured(metres) : *this;
  }

  bool is_measured() const { return packed_ > 0; }
  bool is_guessed() const { return packed_ < 0; } ///< from near or from afar
  bool is_extended() const { return packed_ < -kExtended; }
  bool is_known() const { return packed_ != 0; }
  /// Measured or guessed; 0 if it is not known. One that is extended is rounded to a tenth of a millimetre.
  float metres() const { return is_extended() ? -packed_ - kExtended : std::abs(packed_); }

private:
  static constexpr float kExtended = 1000; // metres: farther than any sensor sees
  explicit StoredDepth(float packed) : packed_(packed) {}

  float packed_; // negative: guessed; with kExtended before it: from afar
};

/// 12 bytes.
struct StoredPixel {
  std::uint16_t u, v;
  StoredDepth depth;
  std::array<std::uint8_t, 3> color;
  std::uint8_t label;
};
static_assert(sizeof(StoredPixel) == 12);

struct StoredFrame {
  int frame; ///< index into the clip's timeline
  Camera camera;
  std::size_t begin, end;        ///< its pixels
  Twist readout = Twist::Zero(); ///< how the camera moves while they are read (rolling_shutter.h)

  /// Of one of its pixels.
  RowRay ray(const StoredPixel& pixel) const { return row_ray(camera.intrinsics, pixel.u, pixel.v, readout); }
};

/// Keeps every pixel while they fit, else a fixed pseudo-random share of each frame's. Not thread-safe.
class PixelStore {
public:
  /// `max_pixels` bounds the memory (12 bytes each); `expected_frames` decides the share kept of each frame.
  PixelStore(std::size_t max_pixels, std::size_t expected_frames);
  /// `timeline_index`: the frame's place in the clip's timeline. Throws Error(kFailure) if `max_pixels` are exceeded.
  void add(const ingest::Frame& frame, int timeline_index);
  /// All that another store has. Throws as above.
  void add(const PixelStore& other);

  /// The pixels of a label become those of another, 0 to 255.
  void relabel(int from, int to);
  /// By its index into pixels().
  void change_depth(std::size_t pixel, StoredDepth depth) { pixels_[pixel].depth = depth; }
  void change_label(std::size_t pixel, std::uint8_t label) { pixels_[pixel].label = label; }
  /// Of a frame, by its number in frames().
  void change_colors(std::size_t frame, const GainTables& tables);

  /// Cameras of all frames lie here from now on: one pose for each frame of the timeline.
  void set_cameras(const std::vector<SE3>& camera_to_world);
  /// And move so while a picture is read.
  void set_readout(const std::vector<Twist>& motion);

  /// Without the frames `left_out` (ascending numbers of frames()), and of the others a fixed pseudo-random share of
  /// about `max_pixels`.
  PixelStore thinned(const std::vector<std::size_t>& left_out, std::size_t max_pixels) const;

  const std::vector<StoredFrame>& frames() const { return frames_; }
  const LargeBuffer<StoredPixel>& pixels() const { return pixels_; }

private:
  void make_room(std::size_t count);

  std::size_t max_pixels_;
  std::size_t expected_frames_;
  std::size_t pixels_per_frame_;
  std::vector<StoredFrame> frames_;
  LargeBuffer<StoredPixel> pixels_;
};

} // namespace kinora::fields
