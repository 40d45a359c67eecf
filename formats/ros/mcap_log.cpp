// MCAP files. Source: https://mcap.dev/spec
#include <algorithm>
#include <map>

#include "ros/log_bytes.h"
#include "ros/message_log.h"

namespace kinora::formats {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t kRecordHead = 9;             ///< opcode and length
constexpr std::uint64_t kMaxDescription = 16U << 20; ///< bytes of a schema or a channel

enum Opcode : std::uint8_t { kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kDataEnd = 15 };

std::string string_of(ByteReader& reader) { return reader.text(reader.number<std::uint32_t>()); }

/// "sensor_msgs/msg/Image" → "sensor_msgs/Image"
std::string without_msg(std::string type) {
  const std::size_t msg = type.find("/msg/");
  return msg == std::string::npos ? type : type.erase(msg, 4);
}

class McapScan {
public:
  explicit McapScan(const RandomAccessFile& file) : file_(file), source_(file.name()) {}

  MessageLog scan() {
    try {
      scan_records(LogBytes(file_), kMagic.size(), true);
    } catch (const Error& error) {
      log_.problem = error.what();
    }
    return std::move(log_);
  }

private:
  void scan_records(const LogBytes& bytes, std::uint64_t at, bool outside) {
    while (at < bytes.size()) {
      const std::vector<std::byte> head_bytes = bytes.read(at, kRecordHead, source_);
      ByteReader head(head_bytes, source_);
      const auto opcode = head.number<std::uint8_t>();
      const auto size = head.number<std::uint64_t>();
      if (opcode == kDataEnd) return;
      const std::uint64_t content = at + kRecordHead;
      const std::uint64_t there = std::min(size, bytes.size() - content);
      if (opcode == kChunk && outside) scan_chunk(content, there); // of one that is cut off, what is there
      if (there < size)
        throw Error(ErrorCode::kCorruptInput, source_ + ": the record at byte " + std::to_string(at) + " is cut off");
      if ((opcode == kSchema || opcode == kChannel) && size <= kMaxDescription)
        add_description(opcode, bytes.read(content, size, source_));
      if (opcode == kMessage) add_message(bytes, content, size);
      at = content + size;
    }
    if (outside) throw Error(ErrorCode::kCorruptInput, source_ + ": was not finished");
  }

  void add_description(std::uint8_t opcode, const std::vector<std::byte>& content) {
    ByteReader reader(content, source_);
    const auto id = reader.number<std::uint16_t>();
    if (opcode == kSchema) {
      schemas_[id] = without_msg(string_of(reader));
      return;
    }
    const auto schema = reader.number<std::uint16_t>();
    const std::string topic = string_of(reader);
    const std::string encoding = string_of(reader);
    if (!channels_.emplace(id, log_.channels.size()).second) return; // they may be repeated
    log_.channels.push_back({topic, schemas_[schema],
                             encoding == "cdr"    ? MessageEncoding::kCdr
                             : encoding == "ros1" ? MessageEncoding::kRos1
                                                  : MessageEncoding::kOther});
  }

  void add_message(const LogBytes& bytes, std::uint64_t content, std::uint64_t size) {
    constexpr std::uint64_t kHead = 22; // channel, sequence, log time, publish time
    const std::vector<std::byte> head = bytes.read(content, std::min(size, kHead), source_);
    ByteReader reader(head, source_);
    const auto channel = channels_.find(reader.number<std::uint16_t>());
    (void)reader.number<std::uint32_t>();
    const auto time = reader.number<std::int64_t>();
    (void)reader.number<std::int64_t>();
    if (channel == channels_.end()) return;
    log_.messages.push_back({channel->second, time, bytes.chunk(), content + kHead, size - kHead});
  }

  void scan_chunk(std::uint64_t content, std::uint64_t size) {
    constexpr std::uint64_t kMaxHead = 256;
    const std::vector<std::byte> bytes = file_.read(content, std::min(size, kMaxHead));
    ByteReader reader(bytes, source_);
    (void)reader.bytes(16); // first and last time
    const auto unpacked = reader.number<std::uint64_t>();
    (void)reader.number<std::uint32_t>(); // checksum
    const std::string compression = string_of(reader);
    const auto packed = reader.number<std::uint64_t>();
    const std::uint64_t data = content + reader.position();
    const std::uint64_t there = std::min(packed, size - reader.position());
    if (compression.empty()) return scan_records(LogBytes(file_, data + there), data, false);
    if (there < packed)
      throw Error(ErrorCode::kCorruptInput, source_ + ": the chunk at byte " + std::to_string(content) + " is cut off");
    const std::size_t number = log_.chunks.size();
    log_.chunks.push_back({data, packed, unpacked, compression});
    const std::vector<std::byte> chunk = unpack(file_, log_.chunks.back());
    scan_records(LogBytes(chunk, number), 0, false);
  }

  const RandomAccessFile& file_;
  std::string source_;
  MessageLog log_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;
};

} // namespace

MessageLog read_mcap_log(const RandomAccessFile& file) {
  if (file.size() < kMagic.size() || ByteReader(file.read(0, kMagic.size()), "").text(kMagic.size()) != kMagic)
    throw Error(ErrorCode::kNotRecognised, file.name() + ": not an MCAP file");
  return McapScan(file).scan();
}

} // namespace kinora::formats
