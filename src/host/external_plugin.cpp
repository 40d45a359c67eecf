#include "host/external_plugin.h"

#include <algorithm>
#include <cstring>
#include <fstream>

#include <dlfcn.h>
#include <fmt/format.h>

#include "core/error.h"
#include "host/format_fault.h"
#include "host/host_services.h"
#include "host/interface_struct.h"
#include "host/isolated.h"

namespace kinora::host {
namespace fs = std::filesystem;

namespace {

const KinoraPlugin& open_library(const fs::path& path) {
  void* library = dlopen(fs::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = dlerror();
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}: cannot be loaded ({})", path.string(), why != nullptr ? why : "no reason given"));
  }
  const auto entry = reinterpret_cast<KinoraPluginEntry>(dlsym(library, KINORA_PLUGIN_ENTRY));
  if (entry == nullptr)
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}: no Kinora plugin (it exports no {})", path.string(), KINORA_PLUGIN_ENTRY));
  const KinoraPlugin* plugin = entry(KINORA_PLUGIN_ABI);
  if (plugin == nullptr)
    throw Error(ErrorCode::kMissingComponent, fmt::format("{}: does not work with version {} of the plugin interface",
                                                          path.string(), KINORA_PLUGIN_ABI));
  if (plugin->abi_version != KINORA_PLUGIN_ABI || plugin->struct_size < sizeof(KinoraPlugin) ||
      (plugin->format_count > 0 && plugin->formats == nullptr))
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}: made for version {} of the plugin interface, not {}; get a matching build",
                            path.string(), plugin->abi_version, KINORA_PLUGIN_ABI));
  const auto host_entry = reinterpret_cast<KinoraPluginHostEntry>(dlsym(library, KINORA_PLUGIN_HOST_ENTRY));
  if (host_entry != nullptr) host_entry(&host_services());
  return *plugin;
}

/// Touches everything that the host will look at, so that what breaks does so in the child.
void look_at(const KinoraPlugin& plugin) {
  for (std::size_t i = 0; i < plugin.format_count; ++i) static_cast<void>(fault_of(plugin.formats[i]));
}

} // namespace

const KinoraPlugin& load_library(const fs::path& path) {
  std::byte lived{};
  const Isolated trial = run_isolated(std::span(&lived, 1), [&path] {
    try {
      look_at(open_library(path));
    } catch (const Error&) { // said again by the parent, where it does no harm
    }
  });
  if (!trial.ended)
    throw Error(ErrorCode::kMissingComponent, fmt::format("{}: {} while it was opened on trial; get a corrected build",
                                                          path.string(), trial.problem));
  return open_library(path);
}

ExternalAnswer probe_isolated(const std::function<void(KinoraProbe*)>& probe) {
  auto answer = make_struct<KinoraProbe>();
  const Isolated trial = run_isolated(std::as_writable_bytes(std::span(&answer, 1)), [&] { probe(&answer); });
  if (!trial.ended) return {0, "its plugin " + trial.problem + " when it was asked; it is left out", true};
  answer.reason[sizeof answer.reason - 1] = '\0';
  return {std::clamp(answer.confidence, 0, 100), answer.reason, false};
}

bool ExternalPlugin::installed() const {
  std::error_code ignored;
  return fs::is_regular_file(manifest_.library, ignored);
}

bool ExternalPlugin::has_magic(const ManifestFormat& format, const fs::path& input) {
  std::error_code ignored;
  if (!fs::is_regular_file(input, ignored)) return false;
  std::ifstream file(input, std::ios::binary);
  return std::ranges::any_of(format.magic, [&file](const Magic& magic) {
    std::string found(magic.bytes.size(), '\0');
    file.clear();
    file.seekg(static_cast<std::streamoff>(magic.offset));
    return file.read(found.data(), static_cast<std::streamsize>(found.size())) && found == magic.bytes;
  });
}

ExternalAnswer ExternalPlugin::probe(const ManifestFormat& format, const fs::path& input) const {
  const bool magic = has_magic(format, input);
  if (!format.magic.empty() && !magic) return {0, "has not the bytes that such files begin with", false};
  if (!installed())
    return {0,
            fmt::format("{}{} is not installed", magic ? "its bytes are there, but " : "", manifest_.library.string()),
            false};
  auto answer = make_struct<KinoraProbe>();
  const Isolated trial = run_isolated(std::as_writable_bytes(std::span(&answer, 1)), [&] {
    try {
      checked_format(open_library(manifest_.library), format).probe(input.c_str(), &answer);
    } catch (const Error& error) {
      answer.confidence = -1;
      std::snprintf(answer.reason, sizeof answer.reason, "%s", error.what());
    }
  });
  if (!trial.ended)
    return {0, fmt::format("{} {} when it was asked; it is left out", manifest_.library.string(), trial.problem), true};
  answer.reason[sizeof answer.reason - 1] = '\0';
  return {std::clamp(answer.confidence, 0, 100), answer.reason, answer.confidence < 0};
}

const KinoraFormat& ExternalPlugin::open(const ManifestFormat& format) const {
  const std::lock_guard lock(mutex_);
  if (!installed())
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("the format {} needs {}, which is not installed; install the plugin {} again",
                            format.description.name, manifest_.library.string(), manifest_.name));
  if (opened_ == nullptr) opened_ = &load_library(manifest_.library);
  return checked_format(*opened_, format);
}

const KinoraFormat& ExternalPlugin::checked_format(const KinoraPlugin& plugin, const ManifestFormat& format) const {
  const auto refusal = [this](const std::string& why) {
    return Error(ErrorCode::kMissingComponent,
                 fmt::format("{}: {}; get a corrected build", manifest_.library.string(), why));
  };
  for (std::size_t i = 0; i < plugin.format_count; ++i) {
    const KinoraFormat* found = plugin.formats[i];
    if (const std::string fault = fault_of(found); !fault.empty()) throw refusal(fault);
    if (std::strcmp(found->name, format.description.name) != 0) continue;
    if (found->capabilities != format.description.capabilities)
      throw refusal(
          fmt::format("the format {} can do other things than {} says", found->name, manifest_.path.string()));
    return *found;
  }
  throw refusal(fmt::format("has no format {}, which {} promises", format.description.name, manifest_.path.string()));
}

} // namespace kinora::host
