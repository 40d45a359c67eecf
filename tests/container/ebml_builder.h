// Matroska files by hand, for files that our writer would never write.
#pragma once

#include <filesystem>
#include <string_view>

#include <unistd.h>

#include "container/byte_source.h"
#include "container/envelope.h"
#include "container/matroska_ids.h"
#include "container/reader.h"

namespace kinora::container::testing {

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline Bytes bytes_of(std::string_view text) {
  const auto view = std::as_bytes(std::span(text));
  return {view.begin(), view.end()};
}

inline Bytes big_endian(std::uint64_t value, int length) {
  Bytes out;
  for (int i = length - 1; i >= 0; --i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
  return out;
}

inline Bytes id_bytes(std::uint32_t id) {
  return big_endian(id, id > 0xFFFFFF ? 4 : id > 0xFFFF ? 3 : id > 0xFF ? 2 : 1);
}

/// The size always takes 8 bytes.
inline Bytes element(std::uint32_t id, const Bytes& body) {
  return id_bytes(id) + big_endian(body.size() | std::uint64_t{1} << 56, 8) + body;
}
inline Bytes unknown_size(std::uint32_t id, const Bytes& body) { return id_bytes(id) + big_endian(0xFF, 1) + body; }
inline Bytes number(std::uint32_t id, std::uint64_t value) { return element(id, big_endian(value, 8)); }
inline Bytes text(std::uint32_t id, std::string_view value) { return element(id, bytes_of(value)); }

inline Bytes ebml_head(std::string_view doc_type = "matroska") {
  return element(ids::kEbml, text(ids::kDocType, doc_type));
}

inline Bytes track_entry(std::uint64_t matroska_number, std::uint16_t id, const Bytes& extra = {}) {
  return element(ids::kTrackEntry, number(ids::kTrackNumber, matroska_number) + text(ids::kCodecId, "S_KINORA/TEST") +
                                       element(ids::kCodecPrivate, wrap_private({id, "", "", bytes_of("private")})) +
                                       extra);
}

/// Body of a SimpleBlock or Block.
inline Bytes block(std::uint8_t matroska_number, const Bytes& frame, std::uint8_t flags = 0) {
  return big_endian(0x80U | matroska_number, 1) + big_endian(0, 2) + big_endian(flags, 1) + frame;
}
inline Bytes simple_block(std::uint8_t matroska_number, const Bytes& frame, std::uint8_t flags = 0) {
  return element(ids::kSimpleBlock, block(matroska_number, frame, flags));
}

inline Reader open(const Bytes& file) { return Reader(std::make_unique<MemorySource>(file, "memory.mkv")); }

inline std::vector<Payload> read_all(Reader& reader) {
  std::vector<Payload> payloads;
  Payload payload;
  while (reader.next(payload)) payloads.push_back(payload);
  return payloads;
}

inline Bytes load(const std::filesystem::path& path) {
  FileSource source(path);
  Bytes bytes(static_cast<std::size_t>(source.size()));
  source.read(0, bytes);
  return bytes;
}

/// A folder of this process's own that goes away with the test.
class TemporaryFolder {
public:
  TemporaryFolder()
      : path_(std::filesystem::temp_directory_path() /
              ("kinora_container_" + std::to_string(::getpid()) + "_" + std::to_string(counter()++))) {
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

private:
  static int& counter() {
    static int value = 0;
    return value;
  }
  std::filesystem::path path_;
};

} // namespace kinora::container::testing
