#include "player/http/http_functions.h"

#include "core/module.h"

namespace kinora::player {

bool is_address(const std::string& text) { return text.rfind("http://", 0) == 0 || text.rfind("https://", 0) == 0; }

const HttpFunctions& http_functions() {
  using Entry = const HttpFunctions* (*)();
  static const HttpFunctions* const functions = reinterpret_cast<Entry>(
      module_symbol("http", "kinora_functions", "to serve clips or play them from an address"))();
  return *functions;
}

} // namespace kinora::player
