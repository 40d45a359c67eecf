#include "player/http/http_functions.h"

#include "core/module.h"

namespace kinora::player {

const HttpFunctions& http_functions() {
  using Entry = const HttpFunctions* (*)();
  static const HttpFunctions* const functions =
      reinterpret_cast<Entry>(module_symbol("http", "kinora_functions", "to serve clips"))();
  return *functions;
}

} // namespace kinora::player
