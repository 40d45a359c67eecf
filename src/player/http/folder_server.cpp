#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <httplib.h>

#include "core/error.h"
#include "player/http/http_functions.h"

namespace kinora::player::http {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::pair<std::string_view, const char*>, 8> kMediaTypes{{{".mkv", "video/x-matroska"},
                                                                               {".mp4", "video/mp4"},
                                                                               {".html", "text/html; charset=utf-8"},
                                                                               {".js", "text/javascript"},
                                                                               {".mjs", "text/javascript"},
                                                                               {".wasm", "application/wasm"},
                                                                               {".json", "application/json"},
                                                                               {".png", "image/png"}}};

const char* media_type(const fs::path& file) {
  const std::string extension = file.extension().string();
  for (const auto& [known, type] : kMediaTypes) {
    if (extension == known) return type;
  }
  return "application/octet-stream";
}

constexpr std::string_view kPageAddress = "/.kinora/";

/// The file below `root` (canonical) that a request's path means, with all links followed; none if it lies outside.
std::optional<fs::path> file_of(const fs::path& root, const std::string& requested) {
  if (requested.empty() || requested.front() != '/' || requested.find('\0') != std::string::npos) return std::nullopt;
  std::error_code error;
  const fs::path file = fs::canonical(root / requested.substr(1), error);
  if (error || !fs::is_regular_file(file, error)) return std::nullopt;
  const auto [end_of_root, rest] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  if (end_of_root != root.end()) return std::nullopt;
  return file;
}

std::string in_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&' || c == '"') {
      out += fmt::format("&#{};", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out;
}

std::string in_url(const std::string& path) {
  constexpr std::string_view kPlain = "-._~/";
  std::string out;
  for (const char c : path) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    out += plain || kPlain.find(c) != std::string_view::npos
               ? std::string(1, c)
               : fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
  }
  return out;
}

/// With `page`, a clip's name leads to what plays it.
std::string clip_list(const fs::path& root, bool page) {
  constexpr std::size_t kMaxClips = 1000;
  std::vector<std::pair<std::string, std::uintmax_t>> clips;
  std::error_code error;
  for (fs::recursive_directory_iterator it(root, fs::directory_options::skip_permission_denied, error), end;
       !error && it != end && clips.size() < kMaxClips; it.increment(error)) {
    std::error_code ignored;
    const std::string name = it->path().lexically_relative(root).string();
    if (it->path().extension() == ".mkv" && file_of(root, "/" + name)) clips.emplace_back(name, it->file_size(ignored));
  }
  std::sort(clips.begin(), clips.end());
  std::string list =
      "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Kinora clips</title>\n"
      "<style>body{font:18px/2 system-ui,sans-serif;margin:1em auto;max-width:40em;padding:0 1em}</style>\n"
      "<h1>Clips</h1>\n<ul>\n";
  for (const auto& [name, bytes] : clips) {
    const std::string address = in_url(name);
    const std::string played =
        page ? fmt::format("{}index.html?clip={}", kPageAddress, in_url("/" + address)) : "/" + address;
    list += fmt::format("<li><a href=\"{}\">{}</a> {:.1f} MB{}</li>\n", played, in_html(name),
                        static_cast<double>(bytes) / 1e6,
                        page ? fmt::format(" <a href=\"/{}\" download>Download</a>", address) : "");
  }
  return list + (clips.empty() ? "<li>There is no .mkv file in this folder.</li>\n</ul>\n" : "</ul>\n");
}

/// Ranges of a file of `size` bytes, each cut at its end; none if nothing of them lies inside.
std::optional<httplib::Ranges> inside(httplib::Ranges ranges, std::uintmax_t size) {
  const auto end = static_cast<std::ptrdiff_t>(size);
  for (auto& [first, last] : ranges) {
    if (first >= end) return std::nullopt;
    last = std::min(last, first < 0 ? end : end - 1); // without a first byte it counts from the end
  }
  return ranges;
}

void give_file(const fs::path& file, httplib::Request& request, httplib::Response& response) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  const auto changed = fs::last_write_time(file, error).time_since_epoch().count();
  auto stream = std::make_shared<std::ifstream>(file, std::ios::binary);
  if (error || !*stream) {
    response.status = 404;
    return;
  }
  response.set_header("ETag", fmt::format("\"{:x}-{:x}\"", size, changed));
  response.set_header("Accept-Ranges", "bytes");
  auto ranges = inside(std::exchange(request.ranges, {}), size);
  if (!ranges) {
    response.status = 416;
    response.set_header("Content-Range", fmt::format("bytes */{}", size));
    return;
  }
  request.ranges = std::move(*ranges);
  if (size == 0) { // a content provider of no bytes would never end
    response.set_content("", media_type(file));
    return;
  }
  response.set_content_provider(size, media_type(file),
                                [stream](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                  constexpr std::size_t kPiece = 1 << 16;
                                  std::vector<char> piece(std::min(length, kPiece));
                                  stream->seekg(static_cast<std::streamoff>(offset));
                                  // A file that was cut meanwhile ends the connection: no bytes are made up.
                                  if (!stream->read(piece.data(), static_cast<std::streamsize>(piece.size())))
                                    return false;
                                  return sink.write(piece.data(), piece.size());
                                });
}

/// A file of the page, compressed where it was and the browser takes that.
void give_page_file(const fs::path& file, const httplib::Request& request, httplib::Response& response) {
  struct Coding {
    const char* name;
    const char* ending;
  };
  constexpr std::array<Coding, 2> kCodings{{{"br", ".br"}, {"gzip", ".gz"}}}; // the smallest first
  std::ifstream packed;
  const std::string accepted = request.get_header_value("Accept-Encoding");
  for (const Coding& coding : kCodings) {
    if (packed.is_open() || accepted.find(coding.name) == std::string::npos) continue;
    packed.open(fs::path(file) += coding.ending, std::ios::binary);
    if (packed.is_open()) response.set_header("Content-Encoding", coding.name);
  }
  std::ifstream plain(file, std::ios::binary);
  std::istream& stream = packed.is_open() ? packed : plain;
  response.set_header("Vary", "Accept-Encoding");
  const auto bytes =
      std::make_shared<const std::string>(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>{});
  // As a string cpp-httplib would compress it, once more.
  response.set_content_provider(bytes->size(), media_type(file),
                                [bytes](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                  return sink.write(bytes->data() + offset, length);
                                });
}

void no_such_file(httplib::Response& response) {
  response.status = 404;
  response.set_content("There is no such file here.\n", "text/plain");
}

void answer(httplib::Server& server, const fs::path& root, const fs::path& page) {
  // Pages of others may read clips, and a page of this server may use threads.
  server.set_default_headers({{"Access-Control-Allow-Origin", "*"},
                              {"Access-Control-Expose-Headers", "Content-Length, Content-Range, Accept-Ranges, ETag"},
                              {"Cross-Origin-Opener-Policy", "same-origin"},
                              {"Cross-Origin-Embedder-Policy", "require-corp"},
                              {"Cross-Origin-Resource-Policy", "cross-origin"}});
  server.Get("/", [root, page](const httplib::Request&, httplib::Response& response) {
    response.set_content(clip_list(root, !page.empty()), "text/html; charset=utf-8");
  });
  server.Get(fmt::format("{}.*", kPageAddress), [page](const httplib::Request& request, httplib::Response& response) {
    const auto file = page.empty() ? std::nullopt : file_of(page, request.path.substr(kPageAddress.size() - 1));
    if (file) {
      give_page_file(*file, request, response);
    } else {
      no_such_file(response);
    }
  });
  server.Get(".*", [root](const httplib::Request& request, httplib::Response& response) {
    if (const auto file = file_of(root, request.path)) {
      // Its own, and of this call alone: cpp-httplib reads the ranges after it, and cuts none at the file's end.
      give_file(*file, const_cast<httplib::Request&>(request), response);
    } else {
      no_such_file(response);
    }
  });
  server.Options(".*", [](const httplib::Request&, httplib::Response& response) {
    response.set_header("Access-Control-Allow-Methods", "GET, HEAD");
    response.set_header("Access-Control-Allow-Headers", "Range, If-Range");
    response.status = 204;
  });
}

} // namespace

void serve_folder(const ServedFolder& served, const std::function<void(int port)>& ready,
                  const std::function<bool()>& stopped) {
  std::error_code error;
  const fs::path root = fs::canonical(served.folder, error);
  if (error || !fs::is_directory(root, error)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{} is no folder; name the folder that holds the clips", served.folder.string()));
  }
  const fs::path page = served.page.empty() ? fs::path() : fs::canonical(served.page, error);
  httplib::Server server;
  // Its own default lets two servers share one port, each with half of the requests.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  answer(server, root, error ? fs::path() : page);
  const int port = served.port == 0                                ? server.bind_to_any_port(served.host)
                   : server.bind_to_port(served.host, served.port) ? served.port
                                                                   : -1;
  if (port < 0) {
    throw Error(ErrorCode::kFailure, fmt::format("cannot listen at {}:{}; it is taken or not an address of this "
                                                 "machine: give another --port or --host",
                                                 served.host, served.port));
  }
  ready(port);
  std::jthread watch([&](const std::stop_token& ended) {
    constexpr std::chrono::milliseconds kPause{100};
    while (!ended.stop_requested() && !stopped()) std::this_thread::sleep_for(kPause);
    while (!server.is_running() && !ended.stop_requested()) std::this_thread::sleep_for(kPause);
    server.stop();
  });
  server.listen_after_bind();
}

} // namespace kinora::player::http
