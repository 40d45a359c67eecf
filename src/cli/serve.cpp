// kinora serve: a folder's clips at an address.
#include <filesystem>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "core/module.h"
#include "player/http/http_functions.h"

namespace kinora::cli {
namespace {

void run(const player::ServedFolder& served, Context& context) {
  const auto ready = [&](int port) {
    const bool everybody = served.host == "0.0.0.0" || served.host == "::";
    const std::string host = everybody ? "127.0.0.1" : served.host;
    const std::string address = host.find(':') == std::string::npos ? fmt::format("http://{}:{}/", host, port)
                                                                    : fmt::format("http://[{}]:{}/", host, port);
    if (context.shared.json) {
      context.print_json({{"schema", "kinora.serve/1"}, {"folder", served.folder.string()}, {"address", address}});
    } else {
      context.print(fmt::format("{} is at {}{}; Ctrl-C ends it\n", served.folder.string(), address,
                                everybody ? ", also for other machines" : ""));
    }
    context.flush();
  };
  player::http_functions().serve_folder(served, ready, interrupted);
}

} // namespace

void add_serve(CLI::App& app, Context& context) {
  const auto served = std::make_shared<player::ServedFolder>();
  // What web/build made, installed with the program; without it clips are given and not played.
  const std::filesystem::path page = module_folder().parent_path().parent_path() / "share/kinora/page";
  std::error_code error;
  if (std::filesystem::exists(page / "index.html", error)) served->page = page;
  CLI::App& command = context.add_command(
      app, "serve", "Give a folder's clips to players and browsers, by HTTP, with a page that plays them",
      "  kinora serve clips/\n  kinora serve clips/ --host 0.0.0.0 --port 9000",
      [served, &context] { run(*served, context); });
  command.add_option("FOLDER", served->folder, "What it holds is given to everybody who asks; nothing else is")
      ->required()
      ->type_name("FOLDER");
  command.add_option("--host", served->host, "Address to listen at; 0.0.0.0 lets other machines in")
      ->capture_default_str()
      ->type_name("ADDRESS");
  command.add_option("--port", served->port, "Port to listen at; 0: any that is free")
      ->capture_default_str()
      ->check(CLI::Range(0, 65535))
      ->type_name("N");
}

} // namespace kinora::cli
