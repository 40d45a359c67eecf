#include "exr/sequence_probe.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "common/boundary.h"
#include "common/byte_reader.h"
#include "common/files.h"
#include "common/numbering.h"
#include "common/random_access_file.h"
#include "exr/channel_names.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint64_t kMaxHeaderBytes = 1 << 20;
constexpr std::size_t kMaxChannels = 1024;

std::string zero_ended(ByteReader& reader) {
  std::string text;
  for (char c = reader.number<char>(); c != '\0'; c = reader.number<char>()) text += c;
  return text;
}

struct FixedSize {
  std::string_view type;
  std::uint32_t bytes;
};
constexpr FixedSize kFixedSizes[] = {{"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
                                     {"compression", 1}, {"double", 8},   {"envmap", 1},
                                     {"float", 4},       {"int", 4},      {"keycode", 28},
                                     {"lineOrder", 1},   {"m33f", 36},    {"m44f", 64},
                                     {"m33d", 72},       {"m44d", 128},   {"rational", 8},
                                     {"timecode", 8},    {"tiledesc", 9}, {"v2i", 8},
                                     {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
                                     {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1}};

/// Throws Error(kCorruptInput) if a value is not as long as its attribute says: the library reads what its type needs,
/// would go on in the middle of another attribute, and believe whatever size it finds there.
void check_length(const std::string& type, ByteReader value) {
  constexpr std::uint32_t kMaxUnpacked = 1U << 26;
  const auto* fixed = std::ranges::find(kFixedSizes, type, &FixedSize::type);
  if (fixed != std::end(kFixedSizes)) value.bytes(fixed->bytes);
  if (type == "stringvector")
    while (value.left() > 0) value.bytes(value.number<std::uint32_t>());
  if (type == "preview") {
    const std::uint64_t width = value.number<std::uint32_t>();
    const std::uint64_t pixels = width * value.number<std::uint32_t>();
    value.bytes(pixels > value.left() ? pixels : 4 * pixels);
  }
  if (type == "idmanifest" && value.number<std::uint32_t>() > kMaxUnpacked) value.fail("its manifest is absurd");
  const bool as_long_as_told = fixed == std::end(kFixedSizes) && type != "preview";
  if (!as_long_as_told && value.left() > 0) value.fail("it is longer than a " + type);
}

/// The names in a channel list. Source: "OpenEXR File Layout", "Structure".
std::vector<std::string> names_of(ByteReader list) {
  constexpr std::uint64_t kChannelBytes = 16; // what follows a name
  std::vector<std::string> names;
  for (std::string name = zero_ended(list); !name.empty() && names.size() < kMaxChannels; name = zero_ended(list)) {
    names.push_back(name);
    list.bytes(kChannelBytes);
  }
  if (list.left() > 0) list.fail("the list of channels is longer than its channels");
  return names;
}

} // namespace

std::vector<std::string> exr_channel_names(const fs::path& path) {
  constexpr std::uint32_t kManyParts = 1U << 12;
  const RandomAccessFile file(path);
  const std::vector<std::byte> head = file.read(0, std::min(file.size(), kMaxHeaderBytes));
  ByteReader reader(head, path.string());
  if (reader.number<std::uint32_t>() != kMagic) reader.fail("is no OpenEXR file");
  const bool many = (reader.number<std::uint32_t>() & kManyParts) != 0;
  std::vector<std::string> channels;
  for (bool in_part = false;;) {
    const std::string name = zero_ended(reader);
    if (name.empty() && (!many || !in_part)) break;
    in_part = !name.empty();
    if (!in_part) continue;
    const std::string type = zero_ended(reader);
    const auto value = reader.bytes(reader.number<std::uint32_t>());
    check_length(type, {value, path.string() + ": the attribute " + name});
    if (type != "chlist") continue;
    std::vector<std::string> names = names_of({value, path.string()}); // of each list, for its length
    if (name == "channels" && channels.empty()) channels = std::move(names);
  }
  if (channels.empty()) reader.fail("has no channels");
  return channels;
}

std::vector<fs::path> exr_files(const fs::path& folder) {
  std::vector<fs::path> files = list_files(folder);
  std::erase_if(files, [](const fs::path& path) { return path.extension() != ".exr"; });
  const auto number = [](const fs::path& path) {
    return number_in_name(path.stem().string()).value_or(std::numeric_limits<std::int64_t>::max());
  };
  std::ranges::stable_sort(files, {}, number);
  return files;
}

void probe_exr_sequence(const char* path, KinoraProbe* answer) {
  const std::vector<fs::path> files = exr_files(path);
  if (files.empty()) return answer_probe(answer, 0, "not a folder with .exr files");
  try {
    const ExrChannels channels = choose_channels(exr_channel_names(files.front()));
    if (channels.has_color && !channels.depth.empty())
      return answer_probe(answer, 90, "OpenEXR files with colour and depth");
    answer_probe(answer, 20, files.front().filename().string() + " has no colour, or no depth (Z)");
  } catch (const Error& error) { // of this format, but broken
    answer_probe(answer, 30, error.what());
  }
}

} // namespace kinora::formats
