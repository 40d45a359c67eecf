// The module http: what it exports.
#include "player/http/http_functions.h"

extern "C" const kinora::player::HttpFunctions* kinora_functions() {
  static constexpr kinora::player::HttpFunctions functions = {.serve_folder = kinora::player::http::serve_folder,
                                                              .open_address = kinora::player::http::open_address};
  return &functions;
}
