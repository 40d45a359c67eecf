#include "clip/clip_edit.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "clip/coding/allocation_budget.h"
#include "clip/payloads/births_codec.h"
#include "clip/payloads/deformation_codec.h"
#include "clip/payloads/graph_codec.h"
#include "clip/payloads/joints_codec.h"
#include "clip/stored_sound.h"
#include "container/reader.h"
#include "container/writer.h"
#include "core/error.h"

namespace kinora::clip {

namespace {

using container::Payload;
using container::Track;

/// What a track of a clip is for.
struct Role {
  std::uint16_t id = 0;
  std::string codec;
  std::string layer; // empty: the camera
  bool per_frame = false;
};

std::vector<Role> roles_of(const ClipDescription& description) {
  std::vector<Role> roles{{description.camera_track, std::string(kCameraCodec), "", description.camera_moves}};
  const auto add = [&roles](std::uint16_t id, std::string_view codec, const std::string& layer, bool per_frame) {
    if (id != 0) roles.push_back({id, std::string(codec), layer, per_frame});
  };
  for (const LayerDescription& layer : description.layers) {
    add(layer.field_track, kFieldCodec, layer.name, false);
    add(layer.motion_track, kMotionCodec, layer.name, true);
    add(layer.confidence_track, kConfidenceCodec, layer.name, false);
    add(layer.joints_track, kJointsCodec, layer.name, false);
    add(layer.births_track, kBirthsCodec, layer.name, false);
  }
  return roles;
}

const Track& track_with(const StoredClip& clip, std::uint16_t id) {
  return *std::find_if(clip.tracks.begin(), clip.tracks.end(), [id](const Track& track) { return track.id == id; });
}

motion::JointPaths joints_of(const StoredClip& clip, const Payload& payload) {
  AllocationBudget budget(payload.bytes.size());
  return decode_joints(payload.bytes, clip.description.times_ns.size(), clip.name, budget);
}

// Of a layer, and the graph whose nodes they are.
struct StoredBirths {
  std::shared_ptr<const motion::DeformationGraph> graph;
  std::vector<std::uint32_t> frames; // one per node
};

StoredBirths births_of(const StoredClip& clip, const std::string& layer, const Payload& payload) {
  const std::vector<LayerDescription>& layers = clip.description.layers;
  const auto found =
      std::find_if(layers.begin(), layers.end(), [&](const LayerDescription& one) { return one.name == layer; });
  StoredBirths births{decode_graph(track_with(clip, found->motion_track).private_data, clip.name), {}};
  AllocationBudget budget(payload.bytes.size());
  births.frames =
      decode_births(payload.bytes, *births.graph, clip.description.times_ns.size(), clip.name, budget).frames();
  births.frames.resize(births.graph->nodes().size(), 0);
  return births;
}

// Deformations from `begin` on up to the next key payload, of which the first becomes one.
void make_first_a_key(const Track& track, std::span<const Payload> original, std::size_t begin,
                      std::span<Payload> pieces) {
  std::size_t frame = begin;
  while (!original[frame].key) --frame;
  const auto graph = decode_graph(track.private_data, track.name);
  DeformationDecoder decoder(*graph);
  DeformationEncoder encoder(*graph);
  for (const std::size_t end = begin + pieces.size(); frame < end; ++frame) {
    if (frame > begin && original[frame].key) break;
    const auto deformation = decoder.decode(original[frame].bytes, original[frame].key, track.name);
    if (frame < begin) continue;
    auto [key, bytes] = encoder.encode(deformation);
    pieces[frame - begin].key = key;
    pieces[frame - begin].bytes = std::move(bytes);
  }
}

void require_same(bool same, const StoredClip& a, const StoredClip& b, const std::string& what) {
  if (same) return;
  throw Error(
      ErrorCode::kFailure,
      fmt::format("{} and {} are no pieces of one clip: {} differs; join pieces that kinora cut has made of one",
                  a.name, b.name, what));
}

std::string name_of(const Role& role) {
  return role.layer.empty() ? "the camera" : fmt::format("{} of layer {}", role.codec, role.layer);
}

void require_pieces_of_one(const StoredClip& a, const StoredClip& b) {
  require_same(a.attachments.size() == b.attachments.size(), a, b, "what is attached");
  for (const container::Attachment& attachment : a.attachments) {
    const auto same = [&](const container::Attachment& other) {
      return other.name != kCalibrationFile || attachment.name != other.name || other.bytes == attachment.bytes;
    };
    require_same(std::all_of(b.attachments.begin(), b.attachments.end(), same), a, b, "the camera");
  }
  require_same(a.sound.has_value() == b.sound.has_value(), a, b, "whether there is sound");
  if (a.sound) {
    const bool same =
        a.sound->track.codec == b.sound->track.codec && a.sound->track.private_data == b.sound->track.private_data;
    require_same(same, a, b, "the codec of sound");
  }
  const std::vector<Role> ours = roles_of(a.description);
  const std::vector<Role> theirs = roles_of(b.description);
  require_same(ours.size() == theirs.size(), a, b, "the number of tracks");
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const auto& [mine, yours] = std::pair(ours[i], theirs[i]);
    const bool same = mine.codec == yours.codec && mine.layer == yours.layer && mine.per_frame == yours.per_frame;
    require_same(same, a, b, name_of(mine));
    require_same(track_with(a, mine.id).private_data == track_with(b, yours.id).private_data, a, b, name_of(mine));
    if (mine.per_frame || mine.codec == kJointsCodec || mine.codec == kBirthsCodec) continue;
    const auto same_bytes = [](const Payload& one, const Payload& other) { return one.bytes == other.bytes; };
    require_same(std::ranges::equal(a.payloads.at(mine.id), b.payloads.at(yours.id), same_bytes), a, b, name_of(mine));
  }
  for (std::size_t l = 0; l < a.description.layers.size(); ++l) {
    const LayerDescription& mine = a.description.layers[l];
    const LayerDescription& yours = b.description.layers[l];
    require_same(mine.kind == yours.kind && mine.label == yours.label, a, b, "layer " + mine.name);
  }
}

// By which the second clip's times move.
std::int64_t delay_of_second(const std::vector<std::int64_t>& first, const std::vector<std::int64_t>& second) {
  constexpr std::int64_t kFrame = 33'333'333; // where nothing says more
  if (second.front() > first.back()) return 0;
  const auto steps = static_cast<std::int64_t>(first.size()) - 1;
  const std::int64_t frame = steps > 0 ? (first.back() - first.front()) / steps : kFrame;
  return first.back() + frame - second.front();
}

bool is_preview(const container::StoredTrack& track) {
  return !track.ours && track.type == container::kVideoType && !track.encoded_again &&
         track.track.name == container::kPreviewName;
}

bool is_poster(const container::StoredAttachment& attachment) {
  return attachment.name == kPosterFile || attachment.name == "cover.png";
}

// A block's time is rounded to the next tick: what belongs to a frame may come so much before it.
constexpr std::int64_t kHalfTick = 500'000;

void cut_preview(std::int64_t first, std::int64_t end, std::optional<container::Preview>& preview) {
  if (!preview) return;
  std::vector<Payload>& packets = preview->packets;
  std::erase_if(packets, [&](const Payload& packet) {
    return packet.time_ns < first - kHalfTick || packet.time_ns >= end - kHalfTick;
  });
  packets.erase(packets.begin(), std::ranges::find_if(packets, &Payload::key));
  if (packets.empty()) preview.reset();
}

void cut_chapters(std::int64_t first, std::int64_t end, std::vector<container::Chapter>& chapters) {
  for (std::size_t i = 0; i + 1 < chapters.size(); ++i) {
    if (chapters[i + 1].time_ns > first) chapters[i].time_ns = std::max(chapters[i].time_ns, first);
  }
  if (!chapters.empty()) chapters.back().time_ns = std::max(chapters.back().time_ns, first);
  std::erase_if(chapters,
                [&](const container::Chapter& chapter) { return chapter.time_ns < first || chapter.time_ns >= end; });
}

void append_chapters(const StoredClip& second, std::int64_t delay, StoredClip& whole) {
  const std::int64_t begin = second.description.times_ns.front() + delay;
  std::erase_if(whole.chapters, [begin](const container::Chapter& chapter) { return chapter.time_ns >= begin; });
  for (container::Chapter chapter : second.chapters) {
    chapter.time_ns += delay;
    // The one that the cut went through goes on.
    const bool goes_on =
        chapter.time_ns == begin && !whole.chapters.empty() && whole.chapters.back().title == chapter.title;
    if (!goes_on) whole.chapters.push_back(std::move(chapter));
  }
}

void append_preview(const StoredClip& second, std::int64_t delay, StoredClip& whole) {
  if (!whole.preview) return;
  const auto format = [](const container::Preview& preview) {
    const container::MediaFormat& media = *preview.track.media;
    return std::tuple(preview.track.codec, media.width, media.height, preview.track.private_data);
  };
  if (!second.preview || format(*whole.preview) != format(*second.preview)) {
    whole.others.emplace_back(container::kPreviewName);
    whole.preview.reset();
    return;
  }
  const std::int64_t begin = second.description.times_ns.front() + delay;
  std::erase_if(whole.preview->packets, [begin](const Payload& packet) { return packet.time_ns >= begin - kHalfTick; });
  for (Payload packet : second.preview->packets) {
    packet.time_ns += delay;
    whole.preview->packets.push_back(std::move(packet));
  }
}

} // namespace

StoredClip load_stored_clip(const std::filesystem::path& path) {
  StoredClip clip;
  clip.sound = read_clip(path).sound; // the clip is whole and in order
  container::Reader reader(path);
  clip.name = path.string();
  clip.chapters = reader.chapters();
  std::ranges::copy_if(reader.tags(), std::back_inserter(clip.tags), [](const auto& tag) {
    return tag.first != container::kKindTag && tag.first != container::kVersionTag;
  });
  for (const container::StoredAttachment& stored : reader.attachments()) {
    Bytes bytes = reader.read_attachment(stored);
    if (stored.name == kClipFile) {
      clip.description = parse_clip_description(bytes, clip.name);
    } else if (stored.name == kCalibrationFile || stored.name == kMetadataFile ||
               stored.name == kCompressedMetadataFile) {
      clip.attachments.push_back({stored.name, stored.media_type, stored.description, std::move(bytes)});
    } else if (is_poster(stored) && !clip.poster) {
      clip.poster = {stored.name, stored.media_type, stored.description, std::move(bytes)};
    } else {
      clip.others.push_back(stored.name);
    }
  }
  for (const Role& role : roles_of(clip.description)) clip.payloads[role.id];
  bool sound_found = false;
  std::optional<std::size_t> preview;
  for (std::size_t i = 0; i < reader.tracks().size(); ++i) {
    const container::StoredTrack& stored = reader.tracks()[i];
    if (stored.ours && clip.payloads.contains(stored.track.id)) {
      clip.tracks.push_back(stored.track);
    } else if (clip.sound && !sound_found && is_clip_sound(stored)) {
      sound_found = true;
    } else if (is_preview(stored) && !preview) {
      preview = i;
      clip.preview = container::Preview{stored.track, {}};
      clip.preview->track.id = container::kPreviewTrack;
    } else {
      clip.others.push_back(stored.track.name.empty() ? stored.track.codec : stored.track.name);
    }
  }
  container::StoredBlock block;
  while (reader.next_block(block)) {
    if (block.track == preview && block.lacing == container::Lacing::kNone) {
      clip.preview->packets.push_back({container::kPreviewTrack, block.time_ns, block.key, reader.read_block(block)});
    }
    if (!reader.tracks()[block.track].ours) continue;
    Payload payload = reader.read_payload(block);
    if (const auto found = clip.payloads.find(payload.track); found != clip.payloads.end()) {
      found->second.push_back(std::move(payload));
    }
  }
  for (auto& [id, payloads] : clip.payloads) std::ranges::stable_sort(payloads, {}, &Payload::time_ns);
  return clip;
}

void write_stored_clip(const StoredClip& clip, const std::filesystem::path& path) {
  container::FileHead head;
  head.kind = std::string(kClipKind);
  head.tracks = clip.tracks;
  if (clip.sound) head.tracks.push_back(clip.sound->track);
  if (clip.preview) head.tracks.push_back(clip.preview->track);
  head.attachments.push_back({kClipFile, "application/json", "Timeline and layers", to_json(clip.description)});
  head.attachments.insert(head.attachments.end(), clip.attachments.begin(), clip.attachments.end());
  if (clip.poster) head.attachments.push_back(*clip.poster);
  head.chapters = clip.chapters;
  head.tags = clip.tags;
  head.duration_ns = clip.description.times_ns.back();
  // As in a file that was not cut: frame by frame what moves, and behind the first what is for all frames of a layer,
  // first payloads first.
  std::vector<const Payload*> payloads;
  std::vector<std::pair<std::size_t, const Payload*>> lasting;
  for (const Role& role : roles_of(clip.description)) {
    const std::vector<Payload>& list = clip.payloads.at(role.id);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (role.per_frame || role.layer.empty())
        payloads.push_back(&list[i]);
      else
        lasting.emplace_back(i, &list[i]);
    }
  }
  std::ranges::stable_sort(lasting, {}, [](const auto& entry) { return entry.first; });
  std::ranges::stable_sort(payloads, {}, [](const Payload* payload) { return payload->time_ns; });
  const auto second = std::ranges::find_if(
      payloads, [&clip](const Payload* payload) { return payload->time_ns != clip.description.times_ns.front(); });
  std::vector<const Payload*> of_first_frame;
  std::ranges::transform(lasting, std::back_inserter(of_first_frame), [](const auto& entry) { return entry.second; });
  payloads.insert(second, of_first_frame.begin(), of_first_frame.end());
  const auto add_all = [&payloads](const std::vector<Payload>& packets) {
    std::ranges::transform(packets, std::back_inserter(payloads), [](const Payload& packet) { return &packet; });
  };
  if (clip.sound) add_all(clip.sound->packets);
  if (clip.preview) add_all(clip.preview->packets);
  std::ranges::stable_sort(payloads, {}, [](const Payload* payload) { return payload->time_ns; });
  container::Writer writer(path, head);
  for (const Payload* payload : payloads) writer.write(payload->track, payload->time_ns, payload->key, payload->bytes);
  writer.finish();
}

StoredClip cut(const StoredClip& clip, std::size_t begin, std::size_t end) {
  StoredClip piece = clip;
  const auto slice = [begin, end](auto& values) {
    using Values = std::remove_reference_t<decltype(values)>;
    values =
        Values(values.begin() + static_cast<std::ptrdiff_t>(begin), values.begin() + static_cast<std::ptrdiff_t>(end));
  };
  slice(piece.description.times_ns);
  slice(piece.description.capture_frames);
  slice(piece.description.held_out);
  for (LayerDescription& layer : piece.description.layers) {
    std::vector<bool> there = layer.presence.in_frames(clip.description.times_ns.size());
    slice(there);
    layer.presence = motion::Presence::of_frames(there);
  }
  const std::int64_t first = piece.description.times_ns.front();
  const std::int64_t last = end < clip.description.times_ns.size() ? clip.description.times_ns[end] : INT64_MAX;
  cut_preview(first, last, piece.preview);
  cut_chapters(first, last, piece.chapters);
  if (piece.sound) {
    std::erase_if(piece.sound->packets,
                  [&](const Payload& packet) { return packet.time_ns < first || packet.time_ns >= last; });
  }
  for (const Role& role : roles_of(clip.description)) {
    std::vector<Payload>& payloads = piece.payloads.at(role.id);
    if (role.per_frame) {
      slice(payloads);
      if (!payloads.front().key) {
        make_first_a_key(track_with(clip, role.id), clip.payloads.at(role.id), begin, payloads);
      }
      continue;
    }
    for (Payload& payload : payloads) payload.time_ns = piece.description.times_ns.front();
    if (role.codec == kBirthsCodec) {
      StoredBirths births = births_of(clip, role.layer, payloads.front());
      for (std::uint32_t& birth : births.frames)
        birth = std::clamp(birth, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)) -
                static_cast<std::uint32_t>(begin);
      payloads.front().bytes = encode_births(motion::NodeBirths(std::move(births.frames)), *births.graph);
    }
    if (role.codec != kJointsCodec) continue;
    motion::JointPaths joints = joints_of(clip, payloads.front());
    slice(joints.positions);
    payloads.front().bytes = encode_joints(joints);
  }
  return piece;
}

static void append_sound(const StoredClip& second, std::int64_t delay, StoredClip& whole) {
  if (!whole.sound) return;
  const std::int64_t begin = second.description.times_ns.front() + delay;
  std::erase_if(whole.sound->packets, [begin](const Payload& packet) { return packet.time_ns >= begin; });
  for (Payload packet : second.sound->packets) {
    packet.time_ns += delay;
    whole.sound->packets.push_back(std::move(packet));
  }
}

void store_fields(const Clip& decoded, const std::vector<FieldRounding>& fields, StoredClip& clip) {
  const std::size_t layers = clip.description.layers.size();
  if (decoded.layers.size() != layers || fields.size() != layers)
    throw Error(ErrorCode::kFailure, clip.name + ": other layers than those that are stored again");
  for (std::size_t l = 0; l < layers; ++l) {
    const std::uint16_t track = clip.description.layers[l].field_track;
    std::vector<Payload>& payloads = clip.payloads.at(track);
    payloads.clear();
    for (Bytes& bytes : encode_field_coarse_first(decoded.layers[l].field, fields[l])) {
      const bool is_first = payloads.empty();
      payloads.push_back({track, clip.description.times_ns.front(), is_first, std::move(bytes)});
    }
  }
}

StoredClip join(const StoredClip& first, const StoredClip& second) {
  require_pieces_of_one(first, second);
  StoredClip whole = first;
  const std::int64_t delay = delay_of_second(first.description.times_ns, second.description.times_ns);
  const auto append = [](auto& values, const auto& more) { values.insert(values.end(), more.begin(), more.end()); };
  for (const std::int64_t time : second.description.times_ns) whole.description.times_ns.push_back(time + delay);
  append(whole.description.capture_frames, second.description.capture_frames);
  append(whole.description.held_out, second.description.held_out);
  for (std::size_t l = 0; l < whole.description.layers.size(); ++l) {
    motion::Presence& presence = whole.description.layers[l].presence;
    std::vector<bool> there = presence.in_frames(first.description.times_ns.size());
    append(there, second.description.layers[l].presence.in_frames(second.description.times_ns.size()));
    presence = motion::Presence::of_frames(there);
  }
  append(whole.others, second.others);
  append_sound(second, delay, whole);
  append_preview(second, delay, whole);
  append_chapters(second, delay, whole);
  const std::vector<Role> ours = roles_of(first.description);
  const std::vector<Role> theirs = roles_of(second.description);
  for (std::size_t i = 0; i < ours.size(); ++i) {
    std::vector<Payload>& payloads = whole.payloads.at(ours[i].id);
    const std::vector<Payload>& further = second.payloads.at(theirs[i].id);
    if (ours[i].per_frame) {
      for (Payload payload : further) {
        payload.track = ours[i].id;
        payload.time_ns += delay;
        payloads.push_back(std::move(payload));
      }
    } else if (ours[i].codec == kBirthsCodec) {
      StoredBirths births = births_of(first, ours[i].layer, payloads.front());
      const StoredBirths more = births_of(second, theirs[i].layer, further.front());
      const auto end = static_cast<std::uint32_t>(first.description.times_ns.size());
      for (std::size_t n = 0; n < births.frames.size(); ++n) {
        if (births.frames[n] == end) births.frames[n] += more.frames[n];
      }
      payloads.front().bytes = encode_births(motion::NodeBirths(std::move(births.frames)), *births.graph);
    } else if (ours[i].codec == kJointsCodec) {
      motion::JointPaths joints = joints_of(first, payloads.front());
      const motion::JointPaths more = joints_of(second, further.front());
      require_same(joints.names == more.names, first, second, name_of(ours[i]));
      append(joints.positions, more.positions);
      payloads.front().bytes = encode_joints(joints);
    }
  }
  return whole;
}

} // namespace kinora::clip
