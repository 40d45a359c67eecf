#include "host/plugin_manifest.h"

#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "host/format_fault.h"
#include "host/interface_struct.h"

namespace kinora::host {
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr std::uintmax_t kMaxManifestBytes = 1 << 20;
constexpr std::size_t kMaxMagicPlace = 1 << 16;

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kMissingComponent, fmt::format("{}: {}; see docs/plugins.md", path.string(), problem));
}

Json parse(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > kMaxManifestBytes) fail(path, "cannot be read, or is larger than 1 MiB");
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) fail(path, "not a JSON object");
  return json;
}

std::string text_of(const Json& json, const char* key, const fs::path& path, const char* fallback = nullptr) {
  if (!json.contains(key) && fallback != nullptr) return fallback;
  if (!json.contains(key) || !json[key].is_string()) fail(path, fmt::format("\"{}\" must be text", key));
  return json[key].get<std::string>();
}

const Json& list_of(const Json& json, const char* key, const fs::path& path) {
  static const Json none = Json::array();
  if (!json.contains(key)) return none;
  if (!json[key].is_array()) fail(path, fmt::format("\"{}\" must be a list", key));
  return json[key];
}

std::string bytes_of_hex(const std::string& hex, const fs::path& path) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    const std::string pair = hex.substr(i, 2);
    if (pair.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) break;
    bytes += static_cast<char>(std::stoi(pair, nullptr, 16));
  }
  if (bytes.empty() || bytes.size() * 2 != hex.size()) fail(path, fmt::format("\"{}\" is not hexadecimal", hex));
  return bytes;
}

Magic magic_of(const Json& json, const fs::path& path) {
  if (!json.is_object()) fail(path, R"(an entry of "magic" must be {"offset": 0, "hex": "…"} or {"text": "…"})");
  Magic magic;
  if (json.contains("offset")) {
    if (!json["offset"].is_number_unsigned() || json["offset"].get<std::size_t>() > kMaxMagicPlace)
      fail(path, "\"offset\" of \"magic\" must be a number from 0 to 65536");
    magic.offset = json["offset"].get<std::size_t>();
  }
  magic.bytes = json.contains("hex") ? bytes_of_hex(text_of(json, "hex", path), path) : text_of(json, "text", path);
  if (magic.bytes.empty() || magic.bytes.size() > 256) fail(path, "\"magic\" must have 1 to 256 bytes");
  return magic;
}

/// The interface's strings live as long as the manifest.
class Texts {
public:
  explicit Texts(Manifest& manifest) : manifest_(manifest) {}
  const char* keep(std::string text) { return manifest_.texts.emplace_back(std::move(text)).c_str(); }

private:
  Manifest& manifest_;
};

void take_options(const Json& json, Manifest& manifest, KinoraFormat& description) {
  Texts texts(manifest);
  std::vector<KinoraOption>& options = manifest.options.emplace_back();
  for (const Json& item : list_of(json, "options", manifest.path)) {
    if (!item.is_object()) fail(manifest.path, "an entry of \"options\" must be an object");
    options.push_back({texts.keep(text_of(item, "name", manifest.path)),
                       texts.keep(text_of(item, "type", manifest.path)),
                       texts.keep(text_of(item, "default", manifest.path)),
                       texts.keep(text_of(item, "help", manifest.path)), nullptr});
  }
  description.options = options.data();
  description.option_count = options.size();
}

ManifestFormat format_of(const Json& json, Manifest& manifest) {
  const fs::path& path = manifest.path;
  if (!json.is_object()) fail(path, "an entry of \"formats\" must be an object");
  Texts texts(manifest);
  ManifestFormat format{make_struct<KinoraFormat>(), {}};
  format.description.name = texts.keep(text_of(json, "name", path));
  format.description.description = texts.keep(text_of(json, "description", path));
  format.description.extensions = texts.keep(text_of(json, "extensions", path, ""));
  for (const Json& word : list_of(json, "can", path)) {
    const std::uint64_t flag = word.is_string() ? capability_called(word.get<std::string>()) : 0;
    if (flag == 0) fail(path, fmt::format("{} in \"can\" is nothing that a format can do", word.dump()));
    format.description.capabilities |= flag;
  }
  take_options(json, manifest, format.description);
  for (const Json& magic : list_of(json, "magic", path)) format.magic.push_back(magic_of(magic, path));
  if (const std::string fault = fault_of_description(format.description); !fault.empty()) fail(path, fault);
  return format;
}

void check_versions(const Json& json, const fs::path& path) {
  const Json& range = list_of(json, "abi", path);
  if (range.size() != 2 || !range[0].is_number_unsigned() || !range[1].is_number_unsigned())
    fail(path, "\"abi\" must be the first and the last version of the interface that it works with: [1, 1]");
  if (range[0] > KINORA_PLUGIN_ABI || range[1] < KINORA_PLUGIN_ABI)
    fail(path, fmt::format("works with versions {} to {} of the plugin interface, and this program has {}; get a "
                           "matching build",
                           range[0].dump(), range[1].dump(), KINORA_PLUGIN_ABI));
}

} // namespace

Manifest read_manifest(const fs::path& path) {
  const Json json = parse(path);
  Manifest manifest;
  manifest.path = path;
  manifest.name = text_of(json, "name", path);
  manifest.version = text_of(json, "version", path);
  manifest.license = text_of(json, "license", path);
  check_versions(json, path);
  const std::string library = text_of(json, "library", path);
  if (library.empty() || library.find('/') != std::string::npos)
    fail(path, "\"library\" must be the name of a file beside it");
  manifest.library = path.parent_path() / library;
  for (const Json& item : list_of(json, "formats", path)) manifest.formats.push_back(format_of(item, manifest));
  if (manifest.formats.empty()) fail(path, "\"formats\" lists nothing");
  return manifest;
}

} // namespace kinora::host
