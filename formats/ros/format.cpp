#include "ros/format.h"

#include <fstream>
#include <iterator>

#include "common/captures.h"
#include "ros/log_reader.h"

namespace kinora::formats {
namespace {

using ReadLog = MessageLog (*)(const RandomAccessFile&);

template <ReadLog read_log> std::unique_ptr<LogReader> open_log(const char* path, const OptionMap& options) {
  RandomAccessFile file(path);
  MessageLog log = read_log(file);
  return std::make_unique<LogReader>(MessageReader(std::move(file), std::move(log)), option_text(options, "color"),
                                     option_text(options, "depth"));
}

bool starts_with(const char* path, std::string_view magic) {
  std::ifstream file(path, std::ios::binary);
  std::string head(magic.size(), '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return file && head == magic;
}

void probe_bag(const char* path, KinoraProbe* answer) {
  if (starts_with(path, "#ROSBAG V2.0\n")) return answer_probe(answer, 90, "begins as a ROS 1 bag");
  answer_probe(answer, 0, "does not begin as a ROS 1 bag");
}

void probe_mcap(const char* path, KinoraProbe* answer) {
  if (starts_with(path, "\x89MCAP0\r\n")) return answer_probe(answer, 90, "begins as an MCAP file");
  answer_probe(answer, 0, "does not begin as an MCAP file");
}

constexpr KinoraOption kOptions[] = {
    {"color", "text", "", "The topic of colour images; else the likeliest.", nullptr},
    {"depth", "text", "", "The topic of depth images; else aligned depth, or the likeliest.", nullptr}};

template <ReadLog read_log, void (*probe)(const char*, KinoraProbe*)>
constexpr KinoraFormat log_format(const char* name, const char* description) {
  auto format = make_struct<KinoraFormat>();
  format.name = name;
  format.description = description;
  format.extensions = "";
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe>;
  set_reader<LogReader, open_log<read_log>>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kRosBagFormat =
    log_format<read_bag_log, probe_bag>("ros-bag", "ROS 1 bag with colour and depth images: RealSense and others");
constinit const KinoraFormat kMcapFormat =
    log_format<read_mcap_log, probe_mcap>("mcap", "MCAP file of ROS 2 (or ROS 1) with colour and depth images");

} // namespace kinora::formats
