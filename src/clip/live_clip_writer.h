// A clip into a file that others may follow while it grows. docs/container.md, "A live clip", specifies it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clip/clip.h"
#include "clip/clip_description.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/update_codec.h"
#include "container/writer.h"

namespace kinora::clip {

/// One motion that goes on: its frames coded once, however often they are asked for. What was coded is coded anew only
/// where the motion has another graph, or other frames, than before. Not thread-safe.
class GrowingMotion {
public:
  void update(const motion::Motion& motion);
  /// The same of a camera's path.
  void update(const std::vector<SE3>& path);

  /// Notes that all frames so far are in a key update.
  void begin_key() { frames_in_key_ = frames_.size(); }
  /// How many frames are as in the last key update: all that were in it, or none.
  std::size_t frames_in_key() const { return frames_in_key_; }
  const Bytes& graph() const { return graph_; } ///< empty unless it deforms
  /// Of an update: from that frame on.
  Bytes coded(std::size_t first) const;

private:
  struct CodedFrame {
    std::size_t hash; ///< of what was coded
    DeformationEncoder::Coded coded;
  };
  /// Forgets what is coded if the first frames are not these.
  void keep_if_same(const Bytes& graph, const std::vector<std::size_t>& hashes);

  Bytes graph_;
  std::optional<DeformationEncoder> encoder_;
  std::vector<CodedFrame> frames_;
  std::size_t frames_in_key_ = 0;
};

/// The clip as it is, again and again, into one file: a key update with all of it, and after that updates with what has
/// changed since the last key update, until these are together as large as that. Memory holds the fields of the last
/// key update and the coded motion. Not thread-safe. Every method throws Error(kUnwritableOutput) naming the path, and
/// Error(kFailure) if the clip cannot be stored.
class LiveClipWriter {
public:
  /// Creates or replaces the file. `intrinsics`: of all clips that are written.
  LiveClipWriter(const std::filesystem::path& path, const Intrinsics& intrinsics);

  /// It is on the disk, and whoever follows the file can read it, when this returns.
  void write(const Clip& clip);
  /// The file is complete: no update follows.
  void finish() { writer_.finish(); }
  /// After an error, such as a full disk: complete up to the last update that fitted.
  void finish_at_last_update() { writer_.finish_at_last_cluster(); }
  std::size_t updates() const { return updates_; }

private:
  struct LayerState {
    GrowingMotion motion;
    fields::Field key_field; ///< as its reader has it
  };
  struct Parts; ///< of an update that is made

  Bytes encode(const Clip& clip, bool key);
  void add_layer(const Layer& layer, const LayerDescription& tracks, bool key, Parts& parts);

  container::Writer writer_;
  GrowingMotion camera_;
  std::map<std::string, LayerState> layers_; ///< by name
  std::uint32_t keys_ = 0;
  std::uint64_t key_bytes_ = 0;    ///< of the last key update
  std::uint64_t update_bytes_ = 0; ///< of all after it
  std::size_t updates_ = 0;
};

} // namespace kinora::clip
