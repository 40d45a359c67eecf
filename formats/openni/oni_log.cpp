#include "openni/oni_log.h"

#include <algorithm>
#include <map>

#include "common/byte_reader.h"

namespace kinora::formats {
namespace {

constexpr std::uint64_t kFileHeadBytes = 24;
constexpr std::uint32_t kRecordMagic = 0x0052494E; // "NIR", zero
constexpr std::uint32_t kMaxFieldBytes = 1U << 20;

enum Record : std::uint32_t {
  kNodeAdded4 = 0x02, // of version 1.0.0.4; those of later versions are longer
  kIntProperty = 0x03,
  kGeneralProperty = 0x06,
  kNewData = 0x0A,
  kEnd = 0x0B,
  kNodeAdded5 = 0x0C,
  kNodeAdded = 0x0D
};
enum NodeType : std::uint32_t { kDepthNode = 2, kImageNode = 3 };

struct Node {
  std::uint32_t type = 0;
  OniStream stream;
};

std::string text_of(ByteReader& fields) {
  std::string text = fields.text(fields.number<std::uint32_t>());
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  return text;
}

OniPixels pixels_of_openni1(std::uint64_t number) {
  constexpr OniPixels kPixels[] = {OniPixels::kOther, OniPixels::kRgb,   OniPixels::kUyvy,
                                   OniPixels::kGrey,  OniPixels::kOther, OniPixels::kJpeg};
  return number < std::size(kPixels) ? kPixels[number] : OniPixels::kOther;
}

OniPixels pixels_of_openni2(std::uint64_t number) {
  switch (number) {
  case 100:
    return OniPixels::kDepthMillimetres;
  case 101:
    return OniPixels::kDepthTenthMillimetres;
  case 200:
    return OniPixels::kRgb;
  case 201:
    return OniPixels::kUyvy;
  case 202:
    return OniPixels::kGrey;
  case 204:
    return OniPixels::kJpeg;
  case 205:
    return OniPixels::kYuyv;
  default:
    return OniPixels::kOther;
  }
}

Node node_of(ByteReader& fields) {
  Node node;
  (void)text_of(fields);
  node.type = fields.number<std::uint32_t>();
  node.stream.codec = fields.text(4);
  node.stream.pixels = node.type == kDepthNode ? OniPixels::kDepthMillimetres : OniPixels::kRgb;
  return node;
}

void take_number(Node& node, ByteReader& fields) {
  const std::string name = text_of(fields);
  if (fields.number<std::uint32_t>() != sizeof(std::uint64_t)) return;
  const auto value = fields.number<std::uint64_t>();
  if (name == "xnMirror") node.stream.mirrored = value != 0;
  if (name == "oniPixelFormat") node.stream.pixels = pixels_of_openni2(value);
  if (name == "xnPixelFormat" && node.type == kImageNode) node.stream.pixels = pixels_of_openni1(value);
}

void take_block(OniStream& stream, ByteReader& fields) {
  const std::string name = text_of(fields);
  (void)fields.number<std::uint32_t>();
  if (name == "xnMapOutputMode") {
    stream.width = fields.number<std::int32_t>();
    stream.height = fields.number<std::int32_t>();
    stream.frames_per_second = fields.number<std::int32_t>();
  } else if (name == "xnFOV") {
    stream.horizontal_view = fields.number<double>();
    stream.vertical_view = fields.number<double>();
  } else if (name == "xnCropping") {
    stream.cropped = fields.number<std::uint32_t>() != 0;
    stream.crop_x = fields.number<std::uint16_t>();
    stream.crop_y = fields.number<std::uint16_t>();
    stream.crop_width = fields.number<std::uint16_t>();
    stream.crop_height = fields.number<std::uint16_t>();
  }
}

/// Files before version 1.0.1 give the place of a record's forerunner as 32 bits, later ones as 64.
std::uint64_t record_head_bytes(const RandomAccessFile& file) {
  if (file.size() < kFileHeadBytes) throw Error(ErrorCode::kNotRecognised, file.name() + ": too short for a .oni file");
  const std::vector<std::byte> head = file.read(0, kFileHeadBytes);
  ByteReader reader(head, file.name());
  if (reader.text(4) != "NI10")
    throw Error(ErrorCode::kNotRecognised, file.name() + ": does not begin with NI10, as .oni files do");
  const auto major = reader.number<std::uint8_t>();
  const auto minor = reader.number<std::uint8_t>();
  const auto maintenance = reader.number<std::uint16_t>();
  return major == 1 && minor == 0 && maintenance == 0 ? 24 : 28;
}

/// Walks from record to record.
class Walk {
public:
  explicit Walk(const RandomAccessFile& file) : file_(file), head_bytes_(record_head_bytes(file)) {}

  /// False after the last one. Throws Error(kCorruptInput).
  bool step(std::map<std::uint32_t, Node>& nodes) {
    const std::string place = file_.name() + ", record at byte " + std::to_string(at_);
    const std::vector<std::byte> head_bytes = file_.read(at_, head_bytes_);
    ByteReader head(head_bytes, place);
    if (head.number<std::uint32_t>() != kRecordMagic) head.fail("it is none");
    const auto type = head.number<std::uint32_t>();
    const auto node = head.number<std::uint32_t>();
    const auto field_bytes = head.number<std::uint32_t>(); // with the head
    const auto payload_bytes = head.number<std::uint32_t>();
    if (field_bytes < head_bytes_ || field_bytes > kMaxFieldBytes) head.fail("its size makes no sense");
    const std::vector<std::byte> bytes = file_.read(at_ + head_bytes_, field_bytes - head_bytes_);
    const std::uint64_t payload = at_ + field_bytes;
    if (payload_bytes > file_.size() - payload) head.fail("it is cut off");
    ByteReader fields(bytes, place);
    take(nodes, type, node, fields, {0, payload, payload_bytes});
    at_ = payload + payload_bytes;
    return type != kEnd;
  }

private:
  static void take(std::map<std::uint32_t, Node>& nodes, std::uint32_t type, std::uint32_t number, ByteReader& fields,
                   OniPicture picture) {
    if (type == kNodeAdded || type == kNodeAdded5 || type == kNodeAdded4) {
      nodes.emplace(number, node_of(fields));
      return;
    }
    const auto node = nodes.find(number);
    if (node == nodes.end()) return;
    if (type == kIntProperty) take_number(node->second, fields);
    if (type == kGeneralProperty) take_block(node->second.stream, fields);
    if (type != kNewData) return;
    picture.time = 1e-6 * static_cast<double>(fields.number<std::uint64_t>());
    node->second.stream.pictures.push_back(picture);
  }

  const RandomAccessFile& file_;
  std::uint64_t head_bytes_;
  std::uint64_t at_ = kFileHeadBytes;
};

} // namespace

OniLog read_oni_log(const RandomAccessFile& file) {
  OniLog log;
  std::map<std::uint32_t, Node> nodes;
  Walk walk(file);
  try {
    while (walk.step(nodes)) {
    }
  } catch (const Error& error) {
    log.problem = error.what();
  }
  for (auto& [number, node] : nodes) {
    if (node.type == kImageNode && !log.color) log.color = std::move(node.stream);
    if (node.type == kDepthNode && !log.depth) log.depth = std::move(node.stream);
  }
  return log;
}

} // namespace kinora::formats
