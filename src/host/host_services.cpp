#include "host/host_services.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/interface_struct.h"

/// A descriptor, and the name for messages.
struct KinoraFile {
  int descriptor;
  std::string name;
};

namespace kinora::host {
namespace {

/// The listener, and that only one plugin speaks at a time.
struct Ear {
  std::mutex mutex;
  PluginListener listener;
};

Ear& ear() {
  static Ear only;
  return only;
}

/// Nothing that a listener throws may pass through the plugin.
template <class Call> auto quietly(const Call& call) noexcept -> decltype(call()) {
  try {
    const std::lock_guard lock(ear().mutex);
    return call();
  } catch (...) {
    return decltype(call())();
  }
}

void set_message(KinoraMessage* message, const std::string& sentence) {
  if (message != nullptr) std::snprintf(message->text, sizeof message->text, "%s", sentence.c_str());
}

void log(const char* sentence, std::int32_t is_warning) {
  quietly([&] {
    if (sentence != nullptr && ear().listener.log) ear().listener.log(sentence, is_warning != 0);
  });
}

std::int32_t progress(std::uint64_t done, std::uint64_t total) {
  return quietly([&] { return ear().listener.progress && ear().listener.progress(done, total) ? 1 : 0; });
}

KinoraFile* open_file(const char* path, std::uint64_t* bytes, KinoraMessage* message) {
  const int descriptor = ::open(path, O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (descriptor >= 0 && ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) {
    *bytes = static_cast<std::uint64_t>(status.st_size);
    return new (std::nothrow) KinoraFile{descriptor, path};
  }
  if (descriptor >= 0) ::close(descriptor);
  set_message(message, std::string(path) + ": not a regular file that can be read");
  return nullptr;
}

KinoraStatus read_file(KinoraFile* file, std::uint64_t offset, void* to, std::size_t bytes, KinoraMessage* message) {
  for (std::size_t done = 0; done < bytes;) {
    const ::ssize_t got = ::pread(file->descriptor, static_cast<std::byte*>(to) + done, bytes - done,
                                  static_cast<::off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      set_message(message, file->name + (got < 0 ? ": cannot be read: " + std::string(std::strerror(errno))
                                                 : ": ends too early; it is truncated or damaged"));
      return got < 0 ? KINORA_FAILURE : KINORA_CORRUPT;
    }
    done += static_cast<std::size_t>(got);
  }
  return KINORA_OK;
}

void close_file(KinoraFile* file) {
  if (file == nullptr) return;
  ::close(file->descriptor);
  delete file;
}

} // namespace

void set_plugin_listener(PluginListener listener) {
  const std::lock_guard lock(ear().mutex);
  ear().listener = std::move(listener);
}

const KinoraHost& host_services() {
  static const KinoraHost services = [] {
    auto made = make_struct<KinoraHost>();
    made.log = log;
    made.allocate = [](std::size_t bytes) { return std::malloc(bytes); };
    made.release = [](void* memory) { std::free(memory); };
    made.open_file = open_file;
    made.read_file = read_file;
    made.close_file = close_file;
    made.progress = progress;
    return made;
  }();
  return services;
}

} // namespace kinora::host
