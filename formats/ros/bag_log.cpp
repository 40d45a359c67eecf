// ROS 1 bags, version 2.0. Source: http://wiki.ros.org/Bags/Format/2.0
#include <algorithm>
#include <map>

#include "ros/log_bytes.h"
#include "ros/message_log.h"

namespace kinora::formats {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMaxHeaderBytes = 1U << 20;

enum Op : std::uint8_t { kMessage = 2, kChunk = 5, kConnection = 7 };

/// A record's header: names and the bytes of their values.
using Fields = std::map<std::string, std::vector<std::byte>>;

Fields fields_of(std::span<const std::byte> bytes, const std::string& source) {
  Fields fields;
  ByteReader reader(bytes, source);
  while (reader.left() > 0) {
    const auto count = reader.number<std::uint32_t>();
    const std::string field = reader.text(count);
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) reader.fail("a field of a record has no '='");
    const auto value = std::as_bytes(std::span(field)).subspan(equals + 1);
    fields[field.substr(0, equals)].assign(value.begin(), value.end());
  }
  return fields;
}

template <class Number> Number number_in(const Fields& fields, const char* name, const std::string& source) {
  const auto found = fields.find(name);
  if (found == fields.end() || found->second.size() < sizeof(Number))
    throw Error(ErrorCode::kCorruptInput, source + ": a record has no \"" + name + "\"");
  return ByteReader(found->second, source).number<Number>();
}

std::string text_in(const Fields& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end()) return {};
  return {reinterpret_cast<const char*>(found->second.data()), found->second.size()};
}

class BagScan {
public:
  explicit BagScan(const RandomAccessFile& file) : file_(file), source_(file.name()) {}

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
      const auto header_bytes = number_at(bytes, at);
      if (header_bytes > kMaxHeaderBytes)
        throw Error(ErrorCode::kCorruptInput, source_ + ": the record at byte " + std::to_string(at) + " is absurd");
      const Fields fields = fields_of(bytes.read(at + 4, header_bytes, source_), source_);
      const std::uint64_t data = at + 8 + header_bytes;
      const std::uint64_t data_bytes = number_at(bytes, data - 4);
      const auto op = number_in<std::uint8_t>(fields, "op", source_);
      const std::uint64_t there = std::min(data_bytes, bytes.size() - data);
      if (op == kChunk && outside) scan_chunk(fields, data, there); // of one that is cut off, what is there
      if (there < data_bytes)
        throw Error(ErrorCode::kCorruptInput, source_ + ": the record at byte " + std::to_string(at) + " is cut off");
      if (op == kConnection) add_connection(fields, bytes.read(data, data_bytes, source_));
      if (op == kMessage) add_message(fields, bytes, data, data_bytes);
      at = data + data_bytes;
    }
  }

  std::uint64_t number_at(const LogBytes& bytes, std::uint64_t at) const {
    return ByteReader(bytes.read(at, 4, source_), source_).number<std::uint32_t>();
  }

  void scan_chunk(const Fields& fields, std::uint64_t data, std::uint64_t data_bytes) {
    const std::string compression = text_in(fields, "compression");
    if (compression == "none") return scan_records(LogBytes(file_, data + data_bytes), data, false);
    const std::size_t number = log_.chunks.size();
    log_.chunks.push_back({data, data_bytes, number_in<std::uint32_t>(fields, "size", source_), compression});
    const std::vector<std::byte> chunk = unpack(file_, log_.chunks.back());
    scan_records(LogBytes(chunk, number), 0, false);
  }

  void add_connection(const Fields& fields, std::span<const std::byte> data) {
    const auto id = number_in<std::uint32_t>(fields, "conn", source_);
    if (channels_.contains(id)) return; // they stand in chunks and again at the end
    channels_[id] = log_.channels.size();
    log_.channels.push_back(
        {text_in(fields, "topic"), text_in(fields_of(data, source_), "type"), MessageEncoding::kRos1});
  }

  void add_message(const Fields& fields, const LogBytes& bytes, std::uint64_t data, std::uint64_t data_bytes) {
    const auto channel = channels_.find(number_in<std::uint32_t>(fields, "conn", source_));
    if (channel == channels_.end()) return;
    const auto time = number_in<std::uint64_t>(fields, "time", source_); // seconds, then nanoseconds
    const auto ns = static_cast<std::int64_t>((time & 0xffffffffU) * 1'000'000'000 + (time >> 32U));
    log_.messages.push_back({channel->second, ns, bytes.chunk(), data, data_bytes});
  }

  const RandomAccessFile& file_;
  std::string source_;
  MessageLog log_;
  std::map<std::uint32_t, std::size_t> channels_;
};

} // namespace

MessageLog read_bag_log(const RandomAccessFile& file) {
  if (file.size() < kMagic.size() || ByteReader(file.read(0, kMagic.size()), "").text(kMagic.size()) != kMagic)
    throw Error(ErrorCode::kNotRecognised, file.name() + ": not a ROS 1 bag of version 2.0");
  return BagScan(file).scan();
}

} // namespace kinora::formats
