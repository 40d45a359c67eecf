// The edge between a plugin's C++ and the C interface: exceptions become statuses, and structs get their headers.
#pragma once

#include <cstdio>
#include <exception>
#include <map>
#include <string>

#include "core/error.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// A struct of the interface, zeroed, with size and version filled in.
template <class Struct> constexpr Struct make_struct() {
  Struct made{};
  made.struct_size = sizeof(Struct);
  made.abi_version = KINORA_PLUGIN_ABI;
  return made;
}

/// A format as it is listed, without functions.
template <std::size_t count>
constexpr KinoraFormat describe(const char* name, const char* description, const char* extensions,
                                std::uint64_t capabilities, const KinoraOption (&options)[count]) {
  auto format = make_struct<KinoraFormat>();
  format.name = name;
  format.description = description;
  format.extensions = extensions;
  format.capabilities = capabilities;
  format.options = options;
  format.option_count = count;
  return format;
}

inline KinoraStatus status_of(ErrorCode code) {
  switch (code) {
  case ErrorCode::kUsage:
    return KINORA_USAGE;
  case ErrorCode::kNotRecognised:
    return KINORA_NOT_RECOGNISED;
  case ErrorCode::kCorruptInput:
    return KINORA_CORRUPT;
  case ErrorCode::kUnwritableOutput:
    return KINORA_UNWRITABLE;
  case ErrorCode::kMissingComponent:
    return KINORA_MISSING;
  default:
    return KINORA_FAILURE;
  }
}

inline void set_message(KinoraMessage* message, const char* sentence) {
  if (message != nullptr) std::snprintf(message->text, sizeof message->text, "%s", sentence);
}

/// Runs `call`, which returns a KinoraStatus; an exception becomes a status and a message.
template <class Call> KinoraStatus guarded(KinoraMessage* message, const Call& call) noexcept {
  try {
    return call();
  } catch (const Error& error) {
    set_message(message, error.what());
    return status_of(error.code());
  } catch (const std::bad_alloc&) {
    set_message(message, "out of memory");
  } catch (const std::exception& error) {
    set_message(message, error.what());
  } catch (...) { // whatever a library throws must not pass through C
    set_message(message, "an unknown exception");
  }
  return KINORA_FAILURE;
}

/// Fills in the answer of a probe.
inline void answer_probe(KinoraProbe* answer, int confidence, const std::string& reason) {
  answer->confidence = confidence;
  std::snprintf(answer->reason, sizeof answer->reason, "%s", reason.c_str());
}

/// What the host handed over, by name. The host has checked names and types.
inline std::map<std::string, std::string> option_map(const KinoraOptionValue* options, std::size_t count) {
  std::map<std::string, std::string> map;
  for (std::size_t i = 0; i < count; ++i) map[options[i].name] = options[i].value;
  return map;
}

} // namespace kinora::formats
