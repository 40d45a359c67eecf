// How the functions of include/kinora/player.h fail: exceptions become status codes and one sentence.
#pragma once

#include <cstdint>
#include <exception>
#include <new>
#include <string>

#include <fmt/format.h>

#include <kinora/player.h>

#include "core/error.h"

namespace kinora::player {

/// Notes what kinora_player_error() says to this thread; gives `status`.
KinoraPlayerStatus failed(int status, const char* sentence) noexcept;

/// Runs `body`, out of which nothing is thrown.
template <typename Body> KinoraPlayerStatus guarded(const Body& body) noexcept {
  try {
    body();
    return KINORA_PLAYER_OK;
  } catch (const Error& error) {
    return failed(error.exit_code(), error.what());
  } catch (const std::bad_alloc&) {
    return failed(KINORA_PLAYER_FAILURE, "out of memory; ask for a smaller picture");
  } catch (const std::exception& error) {
    return failed(KINORA_PLAYER_FAILURE, error.what());
  } catch (...) {
    return failed(KINORA_PLAYER_FAILURE, "an error of unknown kind");
  }
}

/// Throws Error(kUsage).
[[noreturn]] inline void misused(const std::string& sentence) { throw Error(ErrorCode::kUsage, sentence); }

inline void require(const void* pointer, const char* name) {
  if (pointer == nullptr) misused(fmt::format("{} is NULL", name));
}

/// `smallest`: the size that the struct had in the first version.
template <typename Struct>
void require_size(const Struct* given, const char* name, std::size_t smallest = sizeof(Struct)) {
  require(given, name);
  if (given->struct_size < smallest) {
    misused(fmt::format("{}.struct_size is {} and not sizeof {}, {}", name, given->struct_size, name, sizeof(Struct)));
  }
}

} // namespace kinora::player
