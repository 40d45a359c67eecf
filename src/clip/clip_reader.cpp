// read_clip: a clip out of a file that is not trusted.
#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "clip/arriving_clip.h"
#include "clip/byte_account.h"
#include "clip/clip_description.h"
#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "clip/coding/allocation_budget.h"
#include "clip/live_clip_reader.h"
#include "clip/missing_parts.h"
#include "clip/payloads/births_codec.h"
#include "clip/payloads/confidence_codec.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/field_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/payloads/pose_codec.h"
#include "clip/stored_sound.h"
#include "container/reader.h"
#include "core/error.h"

namespace kinora::clip {

namespace {

using container::Payload;
using container::StoredAttachment;
using container::StoredTrack;

// Where the payloads of one track go.
struct Destination {
  std::size_t layer = 0; // of a field or motion track
  std::string_view codec;
  bool moves = true; // one payload for each frame; else a single one
  bool found = true; // its track is listed, and is of this codec
  std::vector<bool> seen;
  std::vector<motion::Motion::Pose> poses;               // of a camera or a rigid layer
  std::shared_ptr<const motion::DeformationGraph> graph; // of a deforming layer, as the rest
  FieldDecoder field;                                    // of a field track
  Bytes kept;                                            // not decoded before the layer's field or graph is known
  std::optional<DeformationDecoder> decoder;
  std::vector<motion::Motion::Deformation> deformations;
  std::size_t next_frame = 0; // that a deformation without the key flag may be of
};

// Frames that have nothing of their own get what the nearest one before them has, else after them.
template <class PerFrame, class MarkLost>
void fill_gaps(std::vector<PerFrame>& frames, const std::vector<bool>& seen, const MarkLost& mark_lost) {
  std::size_t source = static_cast<std::size_t>(std::find(seen.begin(), seen.end(), true) - seen.begin());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (seen[f]) {
      source = f;
      continue;
    }
    frames[f] = frames[source];
    mark_lost(frames[f]);
  }
}

class ClipReader {
public:
  /// `missing`: null if everything must be there.
  ClipReader(std::unique_ptr<container::ByteSource> source, std::vector<std::string>* missing)
      : reader_(std::move(source), missing == nullptr ? container::Reading::kStrict : container::Reading::kSalvage),
        budget_(reader_.file_bytes()), sound_(reader_), missing_(missing) {
    reader_.limit_payloads(kMaxPayloadBytes);
  }

  Clip read() {
    check_kind();
    if (is_live()) return read_live();
    if (reader_.truncated() && missing_ == nullptr) {
      corrupt(fmt::format("byte {}: the file is cut short here; fetch it again", reader_.file_bytes()));
    }
    description_ = parse_clip_description(attachment(kClipFile), place_of(kClipFile));
    clip_.intrinsics = parse_intrinsics(attachment(kCalibrationFile), place_of(kCalibrationFile));
    allow_missing("metadata", [this] { clip_.metadata = parse_json(metadata(), place_of(kMetadataFile)); });
    constexpr double kNanoseconds = 1e9;
    for (const std::int64_t time : description_.times_ns)
      clip_.times.push_back(static_cast<double>(time) / kNanoseconds);
    clip_.capture_frames = description_.capture_frames;
    clip_.held_out = description_.held_out;
    clip_.layers.resize(description_.layers.size());
    prepare_destinations();
    container::StoredBlock block;
    while (reader_.next_block(block)) {
      if (reader_.tracks()[block.track].ours) {
        take_if_usable(reader_.read_payload(block));
        continue;
      }
      sound_.take(reader_, block, budget_);
      media_bytes_[block.track] += static_cast<std::size_t>(block.stored_bytes);
    }
    assemble();
    clip_.sound = std::move(sound_).gathered();
    report_damage();
    return std::move(clip_);
  }

  /// What the file says that there is, and which frames have come.
  void tell(Arrival& arrival) {
    arrival.layers = std::max(description_.layers.size(), layers_);
    arrival.times = std::move(times_);
    arrival.there = std::move(there_);
  }

  ByteAccount account() const { return account_of(reader_, bytes_, media_bytes_); }

private:
  /// Of what need not be there if parts may be missing; `part` says what that is.
  template <class Work> void allow_missing(const std::string& part, const Work& work) {
    try {
      work();
    } catch (const Error& error) {
      if (missing_ == nullptr || error.code() != ErrorCode::kCorruptInput) throw;
      missing_->push_back(part);
    }
  }

  void report_damage() {
    if (missing_ == nullptr) return;
    if (const container::DamageList& damage = reader_.damage(); !damage.empty()) {
      missing_->push_back(
          fmt::format("{} damaged bytes from byte {} on", damage.bytes(), damage.entries().front().offset));
    }
    if (reader_.truncated()) {
      missing_->push_back(fmt::format("what followed byte {}, where the file is cut short", reader_.file_bytes()));
    }
    if (missing_->empty() && !unusable_payload_.empty()) missing_->push_back(unusable_payload_);
  }

  [[noreturn]] void corrupt(const std::string& why) const {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", reader_.name(), why));
  }
  std::string place_of(const char* attachment_name) const {
    return fmt::format("{}: {}", reader_.name(), attachment_name);
  }

  void check_kind() const {
    const std::optional<std::string> kind = reader_.tag(container::kKindTag);
    const auto not_recognised = [this](const std::string& why) {
      throw Error(ErrorCode::kNotRecognised,
                  fmt::format("{} is not a clip that this Kinora reads: {}", reader_.name(), why));
    };
    if (!kind) {
      if (reader_.truncated()) corrupt("the file is cut short before it says what it is; fetch it again");
      not_recognised("it is a Matroska file of another kind");
    }
    if (*kind != kClipKind && *kind != kLiveClipKind) not_recognised(fmt::format("it says that it is a {}", *kind));
    const std::string version = reader_.tag(container::kVersionTag).value_or("(none)");
    if (version != std::to_string(container::kFileVersion)) {
      not_recognised(fmt::format("its layout has version {}; use a newer Kinora", version));
    }
  }

  bool is_live() const { return reader_.tag(container::kKindTag) == kLiveClipKind; }

  /// Where it ends while it is written, or where its writer was killed, is no damage: the last whole update counts.
  Clip read_live() {
    const Intrinsics intrinsics = parse_intrinsics(attachment(kCalibrationFile), place_of(kCalibrationFile));
    LiveClipDecoder decoder(reader_.name(), budget_);
    std::size_t passed_over = 0;
    try {
      Payload payload;
      while (reader_.next(payload)) {
        if (payload.track != kUpdateTrack) continue;
        bytes_[payload.track] += static_cast<std::size_t>(payload.stored_bytes);
        if (!decoder.take(std::move(payload))) ++passed_over;
      }
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput || !reader_.truncated()) throw;
    }
    Clip clip = decoder.decode(intrinsics);
    if (passed_over > 0 && missing_ == nullptr) corrupt(fmt::format("{} updates lack what they change", passed_over));
    if (missing_ != nullptr && !reader_.damage().empty()) report_damage();
    layers_ = clip.layers.size();
    times_ = clip.times;
    there_.assign(times_.size(), true);
    return clip;
  }

  Bytes attachment(const char* attachment_name) {
    const StoredAttachment* const stored = reader_.find_attachment(attachment_name);
    if (stored == nullptr) corrupt(fmt::format("the attachment {} is missing", attachment_name));
    if (!stored->checksum) corrupt(fmt::format("the attachment {} has no checksum", attachment_name));
    return reader_.read_attachment(*stored);
  }

  Bytes metadata() {
    if (reader_.find_attachment(kMetadataFile) != nullptr) return attachment(kMetadataFile);
    return decompress_attachment(attachment(kCompressedMetadataFile), place_of(kCompressedMetadataFile));
  }

  Bytes decompress_attachment(const Bytes& frame, const std::string& location) {
    constexpr std::uint64_t kMaxBytes = std::uint64_t{16} << 20;
    const std::uint64_t size = decompressed_size(frame, location);
    if (size > kMaxBytes) throw Error(ErrorCode::kCorruptInput, fmt::format("{}: it is too large", location));
    budget_.take(size, location);
    return decompress(frame, static_cast<std::size_t>(size), location);
  }

  void prepare_destinations() {
    add_destination(description_.camera_track, kCameraCodec, 0, description_.camera_moves);
    for (std::size_t l = 0; l < description_.layers.size(); ++l) {
      const LayerDescription& layer = description_.layers[l];
      add_destination(layer.field_track, kFieldCodec, l, false);
      if (layer.motion_track != 0) add_destination(layer.motion_track, kMotionCodec, l, true);
      if (layer.confidence_track != 0) add_destination(layer.confidence_track, kConfidenceCodec, l, false);
      if (layer.joints_track != 0) add_destination(layer.joints_track, kJointsCodec, l, false);
      if (layer.births_track != 0) add_destination(layer.births_track, kBirthsCodec, l, false);
    }
  }

  void add_destination(std::uint16_t id, std::string_view codec, std::size_t layer, bool moves) {
    const auto has_id = [id](const StoredTrack& track) { return track.ours && track.track.id == id; };
    const auto track = std::find_if(reader_.tracks().begin(), reader_.tracks().end(), has_id);
    Destination destination;
    destination.layer = layer;
    destination.codec = codec;
    destination.moves = moves;
    destination.seen.assign(moves ? description_.times_ns.size() : 1, false);
    destination.found = track != reader_.tracks().end() && track->track.codec == codec;
    if (!destination.found) {
      if (missing_ == nullptr) corrupt(fmt::format("track {} is missing or is no {}", id, codec));
      destinations_.emplace(id, std::move(destination)); // as if all its payloads were missing
      return;
    }
    if (codec == kMotionCodec && description_.layers[layer].kind == motion::MotionKind::kDeforming) {
      destination.graph = decode_graph(track->track.private_data, fmt::format("{}: track {}", reader_.name(), id));
      budget_.take(decoding_memory(*destination.graph, destination.seen.size()), reader_.name());
      destination.decoder.emplace(*destination.graph);
      destination.deformations.resize(destination.seen.size());
    } else if (codec == kCameraCodec || codec == kMotionCodec) {
      budget_.take(destination.seen.size() * 2 * sizeof(motion::Motion::Pose), reader_.name());
      destination.poses.resize(destination.seen.size());
    }
    destinations_.emplace(id, std::move(destination));
  }

  void take_if_usable(const Payload& payload) {
    try {
      take(payload);
    } catch (const Error& error) {
      if (missing_ == nullptr || error.code() != ErrorCode::kCorruptInput) throw;
      if (unusable_payload_.empty()) unusable_payload_ = error.what();
    }
  }

  void take(const Payload& payload) {
    bytes_[payload.track] += static_cast<std::size_t>(payload.stored_bytes);
    const auto found = destinations_.find(payload.track);
    if (found == destinations_.end()) return; // of a later Kinora, beside what this one knows
    if (!found->second.found) return;
    Destination& destination = found->second;
    const std::string location = fmt::format("{}: byte {}", reader_.name(), payload.offset);
    const auto at = std::lower_bound(description_.times_ns.begin(), description_.times_ns.end(), payload.time_ns);
    const auto frame = static_cast<std::size_t>(at - description_.times_ns.begin());
    if (at == description_.times_ns.end() || *at != payload.time_ns || frame >= destination.seen.size()) {
      throw Error(ErrorCode::kCorruptInput,
                  fmt::format("{}: a payload at {} ns is of no frame", location, payload.time_ns));
    }
    const bool makes_finer = destination.codec == kFieldCodec && !payload.key;
    if (destination.seen[frame] && !makes_finer) {
      throw Error(ErrorCode::kCorruptInput, fmt::format("{}: frame {} comes twice", location, frame));
    }
    decode(destination, payload, frame, location);
    destination.seen[frame] = true;
  }

  void decode(Destination& destination, const Payload& payload, std::size_t frame, const std::string& location) {
    if (destination.codec == kFieldCodec) {
      destination.field.take(payload.bytes, location, budget_);
    } else if (destination.codec == kConfidenceCodec || destination.codec == kBirthsCodec) {
      destination.kept = payload.bytes;
    } else if (destination.codec == kJointsCodec) {
      clip_.layers[destination.layer].joints = decode_joints(payload.bytes, clip_.times.size(), location, budget_);
    } else if (destination.decoder) {
      const bool follows = payload.key ? frame >= destination.next_frame : frame == destination.next_frame;
      if (!follows || (missing_ == nullptr && frame != destination.next_frame)) {
        throw Error(ErrorCode::kCorruptInput,
                    fmt::format("{}: frame {} comes before frame {}", location, frame, destination.next_frame));
      }
      destination.deformations[frame] = destination.decoder->decode(payload.bytes, payload.key, location);
      destination.next_frame = frame + 1; // not after an error: then nothing but a key payload follows
    } else {
      destination.poses[frame] = decode_pose(payload.bytes, location);
    }
  }

  void assemble() {
    note_frames();
    if (missing_ != nullptr) {
      leave_out_unseen_frames();
      for (auto& [id, destination] : destinations_) fill(destination);
    }
    for (auto& [id, destination] : destinations_) {
      const auto missing = std::find(destination.seen.begin(), destination.seen.end(), false);
      if (missing != destination.seen.end() && missing_ == nullptr) {
        corrupt(fmt::format("track {} has no payload for frame {}; fetch the file again", id,
                            missing - destination.seen.begin()));
      }
      if (destination.codec == kMotionCodec && !unusable_layers_.contains(destination.layer)) {
        clip_.layers[destination.layer].motion =
            destination.graph ? motion::Motion::deforming(destination.graph, std::move(destination.deformations))
                              : motion::Motion::rigid(std::move(destination.poses));
      } else if (destination.codec == kFieldCodec && !unusable_layers_.contains(destination.layer)) {
        if (!destination.field.is_whole()) lacks_levels(part_name(destination));
        clip_.layers[destination.layer].field = *std::move(destination.field).taken_field();
      } else if (destination.codec == kCameraCodec) {
        for (const motion::Motion::Pose& pose : destination.poses)
          clip_.camera_to_world.push_back(pose.canonical_to_world);
      }
    }
    decode_kept();
    for (std::size_t l = 0; l < clip_.layers.size(); ++l) {
      clip_.layers[l].name = description_.layers[l].name;
      clip_.layers[l].label = description_.layers[l].label;
      const std::vector<bool> there = description_.layers[l].presence.in_frames(clip_.times.size());
      clip_.layers[l].presence = motion::Presence::of_frames(there);
    }
    leave_out_unusable_layers();
  }

  void note_frames() {
    times_ = clip_.times;
    there_.assign(times_.size(), true);
    for (const auto& [id, destination] : destinations_) {
      const auto& seen = destination.seen;
      if (!destination.moves || std::find(seen.begin(), seen.end(), true) == seen.end()) continue;
      for (std::size_t f = 0; f < there_.size(); ++f) there_[f] = there_[f] && seen[f];
    }
  }

  void lacks_levels(const std::string& field) {
    if (missing_ == nullptr) corrupt(fmt::format("{} lacks its finer levels; fetch the file again", field));
    missing_->push_back("the finer levels of " + field);
  }

  // A cut file ends with the last frame of which something that moves is there; its first shows what keeps still.
  void leave_out_unseen_frames() {
    std::size_t frames = 0;
    bool anything_moves = false;
    for (const auto& [id, destination] : destinations_) {
      if (!destination.moves) continue;
      anything_moves = true;
      const auto last = std::find(destination.seen.rbegin(), destination.seen.rend(), true);
      frames = std::max(frames, static_cast<std::size_t>(destination.seen.rend() - last));
    }
    if (frames == 0) frames = reader_.truncated() ? 1 : clip_.times.size(); // what keeps still may be whole
    if (!anything_moves || frames == clip_.times.size()) return;
    std::vector<bool> there(clip_.times.size(), false);
    std::fill_n(there.begin(), frames, true);
    missing_->push_back(missing_frames(there, clip_.times));
    clip_.times.resize(frames);
    clip_.capture_frames.resize(frames);
    clip_.held_out.resize(frames);
    for (auto& [id, destination] : destinations_) {
      if (!destination.moves) continue;
      destination.seen.resize(frames);
      if (!destination.poses.empty()) destination.poses.resize(frames);
      if (!destination.deformations.empty()) destination.deformations.resize(frames);
    }
    for (Layer& layer : clip_.layers) {
      if (layer.joints) layer.joints->positions.resize(frames);
    }
  }

  // What is missing of a track, and what stands in its place.
  void fill(Destination& destination) {
    const bool whole = std::find(destination.seen.begin(), destination.seen.end(), false) == destination.seen.end();
    const bool nothing = std::find(destination.seen.begin(), destination.seen.end(), true) == destination.seen.end();
    if (whole && !destination.seen.empty()) return;
    if (nothing && destination.codec == kCameraCodec)
      corrupt("nothing says where the camera was; fetch the file again");
    const std::string part = part_name(destination);
    if (nothing && (destination.codec == kFieldCodec || destination.codec == kMotionCodec)) {
      unusable_layers_.insert(destination.layer);
      missing_->push_back(part + " and so the whole layer");
    } else if (!destination.moves) {
      missing_->push_back(part);
    } else {
      missing_->push_back(part + " in " + missing_frames(destination.seen, clip_.times));
      fill_gaps(destination.poses, destination.seen,
                [](motion::Motion::Pose& pose) { pose.health = motion::Health::kLost; });
      fill_gaps(destination.deformations, destination.seen,
                [](motion::Motion::Deformation& d) { d.health = motion::Health::kLost; });
    }
  }

  std::string part_name(const Destination& destination) const {
    if (destination.codec == kCameraCodec) return "the camera's path";
    const std::string& layer = description_.layers[destination.layer].name;
    if (destination.codec == kFieldCodec) return "the field of layer " + layer;
    if (destination.codec == kMotionCodec) return "the motion of layer " + layer;
    if (destination.codec == kJointsCodec) return "the joints of layer " + layer;
    if (destination.codec == kBirthsCodec) return "since when parts of layer " + layer + " are there";
    return "how well layer " + layer + " was seen";
  }

  // Those without a field, or of which it is not known where they are.
  void leave_out_unusable_layers() {
    for (auto layer = unusable_layers_.rbegin(); layer != unusable_layers_.rend(); ++layer) {
      clip_.layers.erase(clip_.layers.begin() + static_cast<std::ptrdiff_t>(*layer));
    }
    if (clip_.layers.empty() && !unusable_layers_.empty()) corrupt("no layer of it is whole; fetch the file again");
  }

  // What needs another part of its layer.
  void decode_kept() {
    for (const auto& [id, destination] : destinations_) {
      const bool is_confidence = destination.codec == kConfidenceCodec;
      if ((!is_confidence && destination.codec != kBirthsCodec) || !destination.seen.front()) continue;
      if (unusable_layers_.contains(destination.layer)) continue;
      Layer& layer = clip_.layers[destination.layer];
      allow_missing(part_name(destination), [&, track = id] {
        const Bytes& bytes = destinations_.at(track).kept;
        const std::string location = fmt::format("{}: track {}", reader_.name(), track);
        if (is_confidence) {
          layer.confidence = decode_confidence(bytes, layer.field.occupancy, location, budget_);
        } else {
          const auto births =
              decode_births(bytes, *layer.motion.graph(), description_.times_ns.size(), location, budget_);
          layer.births = births.in_first_frames(static_cast<std::uint32_t>(clip_.times.size()));
        }
      });
    }
  }

  container::Reader reader_;
  AllocationBudget budget_;
  StoredSound sound_;
  ClipDescription description_;
  Clip clip_;
  std::map<std::uint16_t, Destination> destinations_;
  std::map<std::uint16_t, std::size_t> bytes_;
  std::map<std::size_t, std::size_t> media_bytes_; // of blocks that are not ours, by place in Reader::tracks()
  std::vector<std::string>* missing_;
  std::size_t layers_ = 0;    // of a live clip
  std::vector<double> times_; // of all frames, and whether they have come
  std::vector<bool> there_;
  std::set<std::size_t> unusable_layers_;
  std::string unusable_payload_; // the first, and why
};

Clip read(ClipReader& reader, ByteAccount* account) {
  Clip clip = reader.read();
  if (account != nullptr) *account = reader.account();
  return clip;
}

} // namespace

Clip read_clip(const std::filesystem::path& path, ByteAccount* account) {
  return read_clip(std::make_unique<container::FileSource>(path), account);
}

Clip read_clip(std::unique_ptr<container::ByteSource> source, ByteAccount* account) {
  ClipReader reader(std::move(source), nullptr);
  return read(reader, account);
}

Clip read_whole_parts(std::unique_ptr<container::ByteSource> source, std::vector<std::string>& missing,
                      ByteAccount* account) {
  missing.clear();
  ClipReader reader(std::move(source), &missing);
  return read(reader, account);
}

Clip read_arriving(std::unique_ptr<container::ByteSource> source, Arrival& arrival) {
  arrival = {};
  ClipReader reader(std::move(source), &arrival.missing);
  Clip clip = reader.read();
  reader.tell(arrival);
  return clip;
}

} // namespace kinora::clip
