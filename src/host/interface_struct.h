// Structs of the plugin interface with size and version filled in, and statuses as errors.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "core/error.h"
#include "kinora/plugin.h"

namespace kinora::host {

template <class Struct> Struct make_struct() {
  Struct made{};
  made.struct_size = sizeof(Struct);
  made.abi_version = KINORA_PLUGIN_ABI;
  return made;
}

/// The numbers of rows that lie one after another; null if there are none.
template <class Row> auto numbers_of(const std::vector<Row>& rows) {
  return rows.empty() ? nullptr : rows.front().data();
}

/// The error that a status stands for; `origin` names the format if the plugin gave no message.
inline Error error_of(KinoraStatus status, const KinoraMessage& message, const std::string& origin) {
  std::string sentence(message.text, strnlen(message.text, sizeof message.text));
  if (sentence.empty()) sentence = origin + ": failed with status " + std::to_string(status) + " and without a word";
  switch (status) {
  case KINORA_USAGE:
    return {ErrorCode::kUsage, sentence};
  case KINORA_NOT_RECOGNISED:
    return {ErrorCode::kNotRecognised, sentence};
  case KINORA_CORRUPT:
  case KINORA_BAD_FRAME:
    return {ErrorCode::kCorruptInput, sentence};
  case KINORA_UNWRITABLE:
    return {ErrorCode::kUnwritableOutput, sentence};
  case KINORA_MISSING:
    return {ErrorCode::kMissingComponent, sentence};
  default:
    return {ErrorCode::kFailure, sentence};
  }
}

} // namespace kinora::host
