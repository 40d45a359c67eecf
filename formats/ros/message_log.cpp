#include "ros/message_log.h"

#include "core/error.h"
#include "ros/chunk_compression.h"

namespace kinora::formats {

std::vector<std::byte> unpack(const RandomAccessFile& file, const LogChunk& chunk) {
  const std::vector<std::byte> packed = file.read(chunk.offset, chunk.bytes);
  return unpack_chunk(chunk.compression, packed, chunk.unpacked_bytes,
                      file.name() + ": the chunk at byte " + std::to_string(chunk.offset));
}

std::vector<std::byte> MessageReader::read(const LoggedMessage& message) {
  if (!message.chunk) return file_.read(message.offset, message.bytes);
  if (open_chunk_ != message.chunk) {
    open_chunk_.reset();
    unpacked_ = unpack(file_, log_.chunks[*message.chunk]);
    open_chunk_ = message.chunk;
  }
  if (message.offset > unpacked_.size() || message.bytes > unpacked_.size() - message.offset)
    throw Error(ErrorCode::kCorruptInput, file_.name() + ": a message goes beyond its chunk");
  const auto begin = unpacked_.begin() + static_cast<std::ptrdiff_t>(message.offset);
  return {begin, begin + static_cast<std::ptrdiff_t>(message.bytes)};
}

} // namespace kinora::formats
