#include "core/module.h"

#include <system_error>

#include <dlfcn.h>
#include <fmt/format.h>

#include "core/error.h"

namespace kinora {
namespace fs = std::filesystem;

fs::path module_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path().parent_path() / "lib" / "kinora";
}

fs::path module_path(const std::string& name) { return module_folder() / (name + ".so"); }

void* module_symbol(const std::string& name, const char* symbol, const std::string& purpose) {
  const std::string path = module_path(name).string();
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{} is not there, which Kinora needs {}; install Kinora with all its modules, or build it "
                            "where their libraries are installed",
                            path, purpose));
  // Lazily, as the program itself: most functions of a large library are never called.
  void* module = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (module == nullptr) {
    const char* why = dlerror();
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}, which Kinora needs {}, cannot be opened ({}); install what is missing", path, purpose,
                            why != nullptr ? why : "no reason given"));
  }
  void* found = dlsym(module, symbol);
  if (found == nullptr)
    throw Error(
        ErrorCode::kMissingComponent,
        fmt::format("{} belongs to another version of Kinora; install the program and its modules together", path));
  return found;
}

} // namespace kinora
