// Messages of a robot's log, whatever file holds them: ROS 1 bags and MCAP differ only in how they make this.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/random_access_file.h"

namespace kinora::formats {

enum class MessageEncoding { kRos1, kCdr, kOther };

struct Channel {
  std::string topic;
  std::string type; ///< "sensor_msgs/Image", without ROS 2's "/msg"
  MessageEncoding encoding = MessageEncoding::kOther;
};

struct LoggedMessage {
  std::size_t channel = 0;          ///< in MessageLog::channels
  std::int64_t time_ns = 0;         ///< when it was logged
  std::optional<std::size_t> chunk; ///< of MessageLog::chunks; nothing: it lies in the file itself
  std::uint64_t offset = 0;         ///< in the unpacked chunk, or in the file
  std::uint64_t bytes = 0;
};

/// A part of the file that is compressed.
struct LogChunk {
  std::uint64_t offset = 0; ///< of the packed bytes in the file
  std::uint64_t bytes = 0;
  std::uint64_t unpacked_bytes = 0;
  std::string compression;
};

struct MessageLog {
  std::vector<Channel> channels;
  std::vector<LoggedMessage> messages; ///< in the order of the file
  std::vector<LogChunk> chunks;
  std::string problem; ///< why the file could not be read to its end; empty if it could
};

/// The structure of a file: every message's place. Memory holds some 50 bytes for each message and one chunk. A file
/// that is cut off or damaged is read up to there. Throws Error: kNotRecognised for another magic; kCorruptInput.
MessageLog read_bag_log(const RandomAccessFile& file);
MessageLog read_mcap_log(const RandomAccessFile& file);

/// Messages out of their file. Not thread-safe.
class MessageReader {
public:
  MessageReader(RandomAccessFile file, MessageLog log) : file_(std::move(file)), log_(std::move(log)) {}

  const MessageLog& log() const { return log_; }
  const std::string& name() const { return file_.name(); }
  /// Throws Error(kCorruptInput).
  std::vector<std::byte> read(const LoggedMessage& message);

private:
  RandomAccessFile file_;
  MessageLog log_;
  std::optional<std::size_t> open_chunk_;
  std::vector<std::byte> unpacked_; ///< of the open chunk
};

/// Unpacks a chunk of the file. Throws Error(kCorruptInput).
std::vector<std::byte> unpack(const RandomAccessFile& file, const LogChunk& chunk);

} // namespace kinora::formats
