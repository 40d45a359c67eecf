// What Kinora has cpp-httplib do, which few commands need: its users stand in a module (core/module.h).
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace kinora::player {

struct ServedFolder {
  std::filesystem::path folder;
  std::filesystem::path page;     ///< holds the page that plays a clip (web/), given below "/.kinora/"; empty: none
  std::string host = "127.0.0.1"; ///< address to listen at; 0.0.0.0: reachable from other machines
  int port = 8080;                ///< 0: any that is free
};

/// Defined in the module alone: called through http_functions().
namespace http {

/// Answers GET and HEAD for the files of a folder, with ranges, and with a page that lists its clips at "/". Nothing
/// outside the folder, but for the page's own files, is given, also not through links. `ready` is called once with the
/// port; returns when `stopped` says so, which is asked ten times a second. Throws Error(kUsage) if there is no such
/// folder, Error(kFailure) if the address is taken or not this machine's.
void serve_folder(const ServedFolder& served, const std::function<void(int port)>& ready,
                  const std::function<bool()>& stopped);

} // namespace http

/// What the module exports, through `extern "C" const HttpFunctions* kinora_functions()`.
struct HttpFunctions {
  decltype(&http::serve_folder) serve_folder;
};

/// Thread-safe. Throws Error(kMissingComponent) if the module or cpp-httplib is not installed.
const HttpFunctions& http_functions();

} // namespace kinora::player
