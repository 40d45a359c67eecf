// A plugin that hands over anything at all: its answers are the input. It lies about everything but the size of its
// buffers, which nobody could check.
#include "core/error.h"
#include "fuzz/fuzzer.h"
#include "host/interface_struct.h"
#include "host/picture_writer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"

namespace kinora::fuzz {
namespace {

using host::make_struct;

/// Decisions out of the input, and 0 at its end.
class Choices {
public:
  Choices() = default;
  explicit Choices(std::span<const std::byte> input) : left_(input) {}

  std::uint8_t byte() {
    if (left_.empty()) return 0;
    const auto value = std::to_integer<std::uint8_t>(left_.front());
    left_ = left_.subspan(1);
    return value;
  }
  /// Mostly `usual`; else something else.
  template <class Number> Number number(Number usual) {
    constexpr Number kOdd[] = {Number(0),
                               Number(-1),
                               Number(1),
                               std::numeric_limits<Number>::max(),
                               std::numeric_limits<Number>::lowest(),
                               std::numeric_limits<Number>::quiet_NaN()};
    const std::uint8_t choice = byte();
    if (choice < 192) return usual;
    if (choice < 224) return kOdd[choice % std::size(kOdd)];
    return static_cast<Number>(byte());
  }
  const char* text(const char* usual) {
    static const std::string long_text(5000, 'a');
    const std::uint8_t choice = byte();
    return choice < 224 ? usual : choice < 236 ? nullptr : choice < 248 ? "" : long_text.c_str();
  }
  KinoraStatus status(KinoraStatus usual) {
    const std::uint8_t choice = byte();
    return choice < 224 ? usual : static_cast<KinoraStatus>(choice % 12);
  }
  bool rarely() { return byte() >= 240; }

private:
  std::span<const std::byte> left_;
};

constexpr int kWidth = 16;
constexpr int kHeight = 12;
constexpr int kFrames = 6;

/// The plugin: C functions remember nothing else.
struct Plugin {
  Choices choices;
  int frames = 0;
  KinoraLabel labels[2];
  const char* warnings[2];
  std::vector<std::byte> buffers[5];
};
Plugin plugin; // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

KinoraImage image(std::vector<std::byte>& buffer, int channels, KinoraPixelType type) {
  constexpr std::size_t kMaxBuffer = 1U << 20U;
  Choices& choices = plugin.choices;
  KinoraImage made{};
  made.width = choices.number(kWidth);
  made.height = choices.number(kHeight);
  made.channels = choices.number(channels);
  made.pixel_type = choices.number(type);
  const std::size_t row = std::size_t{kWidth} * static_cast<std::size_t>(channels) * (type == KINORA_PIXEL_U16 ? 2 : 1);
  made.row_bytes = choices.rarely() ? choices.byte() : row;
  const std::size_t bytes = made.row_bytes * static_cast<std::size_t>(std::max(made.height, 0));
  if (bytes > kMaxBuffer || choices.rarely()) return made;              // without data
  buffer.assign(bytes, choices.rarely() ? std::byte{0} : std::byte{4}); // of depth: a metre
  made.data = buffer.data();
  return made;
}

KinoraCamera camera() {
  Choices& choices = plugin.choices;
  KinoraCamera made{};
  made.width = choices.number(kWidth);
  made.height = choices.number(kHeight);
  made.fx = choices.number(20.0);
  made.fy = choices.number(20.0);
  made.cx = choices.number(7.5);
  made.cy = choices.number(5.5);
  for (double& k : made.distortion) k = choices.number(0.0);
  // What memory a large camera takes is what it says of itself.
  constexpr int kMaxSide = 1024;
  if (made.width > kMaxSide) made.width = kMaxSide;
  if (made.height > kMaxSide) made.height = kMaxSide;
  return made;
}

void fill_matrix(double* matrix) {
  for (int i = 0; i < 16; ++i) matrix[i] = plugin.choices.number(i % 5 == 0 ? 1.0 : 0.0);
}

void probe(const char* /*path*/, KinoraProbe* answer) {
  answer->confidence = plugin.choices.number(90);
  std::memset(answer->reason, plugin.choices.rarely() ? 'a' : 0, sizeof answer->reason);
}

KinoraStatus open_reader(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*count*/,
                         KinoraReader** reader, KinoraMessage* message) {
  if (plugin.choices.rarely()) std::memset(message->text, 'a', sizeof message->text);
  if (!plugin.choices.rarely()) *reader = reinterpret_cast<KinoraReader*>(&plugin);
  return plugin.choices.status(KINORA_OK);
}

KinoraStatus reader_info(KinoraReader* /*reader*/, KinoraCaptureInfo* info, KinoraMessage* /*message*/) {
  Choices& choices = plugin.choices;
  info->frame_count = choices.number(std::int64_t{kFrames});
  info->start_time = choices.number(0.0);
  info->frames_per_second = choices.number(30.0);
  info->camera = camera();
  info->has_poses = choices.number(0);
  info->has_masks = choices.number(1);
  for (KinoraLabel& label : plugin.labels) label = {choices.number(2), choices.text("box"), choices.text("rigid")};
  for (const char*& warning : plugin.warnings) warning = choices.text("dusty");
  info->labels = choices.rarely() ? nullptr : plugin.labels;
  info->label_count = choices.byte() % 3;
  info->warnings = choices.rarely() ? nullptr : plugin.warnings;
  info->warning_count = choices.byte() % 3;
  info->has_depth_camera = choices.rarely() ? 1 : 0;
  if (info->has_depth_camera != 0) {
    info->depth_camera = camera();
    fill_matrix(info->depth_to_color);
  }
  return choices.status(KINORA_OK);
}

KinoraStatus reader_next(KinoraReader* /*reader*/, KinoraFrame* frame, KinoraMessage* /*message*/) {
  Choices& choices = plugin.choices;
  if (++plugin.frames > kFrames) return KINORA_END;
  frame->index = choices.number(frame->index);
  frame->time = choices.number(plugin.frames / 30.0);
  frame->color = image(plugin.buffers[0], 3, KINORA_PIXEL_U8);
  frame->depth = image(plugin.buffers[1], 1, KINORA_PIXEL_U16);
  frame->depth_unit = choices.number(0.001);
  if (choices.rarely()) frame->infrared = image(plugin.buffers[2], 1, KINORA_PIXEL_U16);
  if (choices.rarely()) frame->confidence = image(plugin.buffers[3], 1, KINORA_PIXEL_U8);
  if (choices.rarely()) frame->labels = image(plugin.buffers[4], 1, KINORA_PIXEL_U8);
  frame->has_pose = choices.number(0);
  fill_matrix(frame->camera_to_world);
  return choices.status(KINORA_OK);
}

KinoraStatus reader_seek(KinoraReader* /*reader*/, int64_t /*index*/, KinoraMessage* /*message*/) {
  return plugin.choices.status(KINORA_OK);
}
void reader_close(KinoraReader* /*reader*/) {}

KinoraStatus open_writer(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*count*/,
                         KinoraWriter** writer, KinoraMessage* message) {
  if (plugin.choices.rarely()) std::memset(message->text, 'a', sizeof message->text);
  if (!plugin.choices.rarely()) *writer = reinterpret_cast<KinoraWriter*>(&plugin);
  return plugin.choices.status(KINORA_OK);
}
KinoraStatus writer_write(KinoraWriter* /*writer*/, const KinoraPicture* /*picture*/, KinoraMessage* /*message*/) {
  return plugin.choices.status(KINORA_OK);
}
KinoraStatus writer_finish(KinoraWriter* /*writer*/, KinoraMessage* /*message*/) {
  return plugin.choices.status(KINORA_OK);
}
void writer_abandon(KinoraWriter* /*writer*/) {}

template <class Function> Function* unless_rarely(Function* function) {
  return plugin.choices.rarely() ? nullptr : function;
}

KinoraFormat format() {
  Choices& choices = plugin.choices;
  auto made = make_struct<KinoraFormat>();
  if (choices.rarely()) made.struct_size = choices.byte();
  made.name = choices.text("fuzzed");
  made.description = choices.text("anything");
  made.extensions = choices.text(".fuzz");
  made.capabilities =
      KINORA_READS_FRAMES | KINORA_WRITES_PICTURES | (choices.byte() % 2 == 0 ? std::uint64_t{KINORA_SEEKS} : 0U);
  made.option_count = choices.rarely() ? 1 : 0; // without a list
  made.probe = unless_rarely(probe);
  made.open_reader = unless_rarely(open_reader);
  made.reader_info = unless_rarely(reader_info);
  made.reader_next = unless_rarely(reader_next);
  made.reader_seek = unless_rarely(reader_seek);
  made.reader_close = unless_rarely(reader_close);
  made.open_writer = unless_rarely(open_writer);
  made.writer_write = unless_rarely(writer_write);
  made.writer_finish = unless_rarely(writer_finish);
  made.writer_abandon = unless_rarely(writer_abandon);
  return made;
}

void use_plugin(std::span<const std::byte> input) {
  plugin = {};
  plugin.choices = Choices(input);
  const KinoraFormat made = format();
  const KinoraFormat* const formats[] = {&made};
  auto given = make_struct<KinoraPlugin>();
  given.name = plugin.choices.text("fuzz");
  given.version = plugin.choices.text("1");
  given.formats = plugin.choices.rarely() ? nullptr : formats;
  given.format_count = 1;
  host::PluginTable table = host::PluginTable::builtin();
  table.add(given, "built-in"); // asked here, not in a child process, where a sanitizer would not be heard
  (void)table.probe("a.fuzz");
  Progress progress;
  ingest::CaptureOptions options;
  options.format = made.name;
  {
    const auto capture = ingest::Capture::open(table, "a.fuzz", options, progress);
    while (capture->next()) {
    }
  }
  host::PictureWriter writer(made, "a.fuzz", {});
  writer.write({"a", 0, ColorImage(4, 4, 4), {}, {}, {}});
  writer.finish();
}

std::vector<Bytes> answers() { return {Bytes(400), Bytes(600, std::byte{100}), Bytes(200, std::byte{191})}; }

} // namespace

std::vector<Fuzzer> plugin_fuzzers() { return {{"plugin", answers, use_plugin, 600}}; }

} // namespace kinora::fuzz
