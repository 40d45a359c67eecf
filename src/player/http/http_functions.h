// What Kinora has cpp-httplib do, which few commands need: its users stand in a module (core/module.h).
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "container/byte_source.h"

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

/// The bytes of a file at http:// or https://, fetched in ranges as they are read, over one connection that is taken up
/// again where it breaks. A server that gives no ranges is asked for the whole, up to 1 GB. `stopped` is asked while it
/// waits. Errors, here and from read(): kUsage (no address), kNotRecognised (no such file), kCorruptInput (the file was
/// changed meanwhile, or the server gives what it was not asked for), kFailure (not to be reached, also after five
/// tries), kInterrupted.
std::unique_ptr<container::ByteSource> open_address(const std::string& address, const std::function<bool()>& stopped);

} // namespace http

/// True if `text` begins with http:// or https://.
bool is_address(const std::string& text);

/// What the module exports, through `extern "C" const HttpFunctions* kinora_functions()`.
struct HttpFunctions {
  decltype(&http::serve_folder) serve_folder;
  decltype(&http::open_address) open_address;
};

/// Thread-safe. Throws Error(kMissingComponent) if the module or cpp-httplib is not installed.
const HttpFunctions& http_functions();

} // namespace kinora::player
