// Identifiers of the elements that the reader looks at. Source: RFC 8794, section 11; RFC 9559, section 5.
#pragma once

#include <cstdint>

namespace kinora::container::ids {

inline constexpr std::uint32_t kEbml = 0x1A45DFA3;
inline constexpr std::uint32_t kEbmlReadVersion = 0x42F7;
inline constexpr std::uint32_t kEbmlMaxIdLength = 0x42F2;
inline constexpr std::uint32_t kEbmlMaxSizeLength = 0x42F3;
inline constexpr std::uint32_t kDocType = 0x4282;
inline constexpr std::uint32_t kDocTypeReadVersion = 0x4285;

inline constexpr std::uint32_t kVoid = 0xEC;
inline constexpr std::uint32_t kCrc32 = 0xBF;

inline constexpr std::uint32_t kSegment = 0x18538067;
inline constexpr std::uint32_t kSeekHead = 0x114D9B74;
inline constexpr std::uint32_t kSeek = 0x4DBB;
inline constexpr std::uint32_t kSeekId = 0x53AB;
inline constexpr std::uint32_t kSeekPosition = 0x53AC;
inline constexpr std::uint32_t kInfo = 0x1549A966;
inline constexpr std::uint32_t kTimestampScale = 0x2AD7B1;
inline constexpr std::uint32_t kTracks = 0x1654AE6B;
inline constexpr std::uint32_t kCluster = 0x1F43B675;
inline constexpr std::uint32_t kCues = 0x1C53BB6B;
inline constexpr std::uint32_t kAttachments = 0x1941A469;
inline constexpr std::uint32_t kChapters = 0x1043A770;
inline constexpr std::uint32_t kTags = 0x1254C367;

inline constexpr std::uint32_t kTrackEntry = 0xAE;
inline constexpr std::uint32_t kTrackNumber = 0xD7;
inline constexpr std::uint32_t kTrackType = 0x83;
inline constexpr std::uint32_t kTrackName = 0x536E;
inline constexpr std::uint32_t kCodecId = 0x86;
inline constexpr std::uint32_t kCodecPrivate = 0x63A2;
inline constexpr std::uint32_t kDefaultDuration = 0x23E383;
inline constexpr std::uint32_t kCodecDelay = 0x56AA;
inline constexpr std::uint32_t kVideo = 0xE0;
inline constexpr std::uint32_t kPixelWidth = 0xB0;
inline constexpr std::uint32_t kPixelHeight = 0xBA;
inline constexpr std::uint32_t kAudio = 0xE1;
inline constexpr std::uint32_t kSamplingFrequency = 0xB5;
inline constexpr std::uint32_t kChannels = 0x9F;
inline constexpr std::uint32_t kBitDepth = 0x6264;
inline constexpr std::uint32_t kContentEncodings = 0x6D80;
inline constexpr std::uint32_t kContentEncoding = 0x6240;
inline constexpr std::uint32_t kContentEncodingType = 0x5033;
inline constexpr std::uint32_t kContentCompression = 0x5034;
inline constexpr std::uint32_t kContentCompAlgo = 0x4254;
inline constexpr std::uint32_t kContentCompSettings = 0x4255;

inline constexpr std::uint32_t kTimestamp = 0xE7; // of a cluster
inline constexpr std::uint32_t kPosition = 0xA7;
inline constexpr std::uint32_t kPrevSize = 0xAB;
inline constexpr std::uint32_t kSimpleBlock = 0xA3;
inline constexpr std::uint32_t kBlockGroup = 0xA0;
inline constexpr std::uint32_t kBlock = 0xA1;
inline constexpr std::uint32_t kReferenceBlock = 0xFB;

inline constexpr std::uint32_t kCuePoint = 0xBB;
inline constexpr std::uint32_t kCueTime = 0xB3;
inline constexpr std::uint32_t kCueTrackPositions = 0xB7;
inline constexpr std::uint32_t kCueTrack = 0xF7;
inline constexpr std::uint32_t kCueClusterPosition = 0xF1;

inline constexpr std::uint32_t kAttachedFile = 0x61A7;
inline constexpr std::uint32_t kFileDescription = 0x467E;
inline constexpr std::uint32_t kFileName = 0x466E;
inline constexpr std::uint32_t kFileMediaType = 0x4660;
inline constexpr std::uint32_t kFileData = 0x465C;

inline constexpr std::uint32_t kEditionEntry = 0x45B9;
inline constexpr std::uint32_t kChapterAtom = 0xB6;
inline constexpr std::uint32_t kChapterTimeStart = 0x91;
inline constexpr std::uint32_t kChapterDisplay = 0x80;
inline constexpr std::uint32_t kChapString = 0x85;

inline constexpr std::uint32_t kTag = 0x7373;
inline constexpr std::uint32_t kTargets = 0x63C0;
inline constexpr std::uint32_t kTagTrackUid = 0x63C5;
inline constexpr std::uint32_t kTagEditionUid = 0x63C9;
inline constexpr std::uint32_t kTagChapterUid = 0x63C4;
inline constexpr std::uint32_t kTagAttachmentUid = 0x63C6;
inline constexpr std::uint32_t kSimpleTag = 0x67C8;
inline constexpr std::uint32_t kTagName = 0x45A3;
inline constexpr std::uint32_t kTagString = 0x4487;

/// True for elements that hold payloads: they stand in clusters.
constexpr bool is_block(std::uint32_t id) { return id == kSimpleBlock || id == kBlockGroup || id == kBlock; }

/// True for elements that stand directly in a segment, or begin a new one: where a cluster of unknown size ends.
constexpr bool ends_cluster(std::uint32_t id) {
  return id == kCluster || id == kCues || id == kTags || id == kAttachments || id == kChapters || id == kTracks ||
         id == kInfo || id == kSeekHead || id == kSegment || id == kEbml;
}

} // namespace kinora::container::ids
