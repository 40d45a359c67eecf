#include "cli/context.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

#include "core/error.h"
#include "host/host_services.h"

namespace kinora::cli {

CLI::App& Context::add_command(CLI::App& app, const std::string& name, const std::string& description,
                               const std::string& examples, std::function<void()> run) {
  CLI::App& command = *app.add_subcommand(name, description);
  command.footer("Examples:\n" + examples);
  command.callback([this, run = std::move(run)] { action = run; });
  add_shared(command);
  return command;
}

void Context::add_shared(CLI::App& command) {
  const char* group = "Options that all commands share";
  command.add_flag("--json", shared.json, "Machine output on stdout, with a versioned schema")->group(group);
  auto* verbose = command.add_flag("-v,--verbose", shared.verbose, "Say more on stderr")->group(group);
  command.add_flag("-q,--quiet", shared.quiet, "Say nothing but errors on stderr")->group(group)->excludes(verbose);
  command.add_option("--threads", shared.threads, "Threads to use; 0 = one per core (results do not depend on it)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->group(group);
  command.add_option("--plugin-dir", shared.plugin_folders, "Also look for format plugins in this folder")
      ->type_name("FOLDER")
      ->allow_extra_args(false)
      ->group(group);
  command.add_flag("--no-external-plugins", shared.no_external_plugins, "Use only the formats that come with Kinora")
      ->group(group);
}

void Context::add_overwrite(CLI::App& command) {
  command.add_flag("--overwrite", shared.overwrite, "Replace files that exist already");
}

const host::PluginTable& Context::plugins() {
  if (!plugins_) {
    plugins_ = std::make_unique<host::PluginTable>(host::PluginTable::builtin());
    if (!shared.no_external_plugins) {
      host::set_plugin_listener({[this](const std::string& sentence, bool is_warning) {
                                   is_warning ? progress.warn(sentence) : progress.detail(sentence);
                                 },
                                 [this](std::uint64_t done, std::uint64_t total) {
                                   if (done == 0) progress.stage("in a plugin", total);
                                   progress.advance(done, "");
                                   return progress.cancelled();
                                 }});
      host::load_external_plugins(*plugins_, host::plugin_folders(shared.plugin_folders), progress);
    }
  }
  return *plugins_;
}

void Context::print_json(const nlohmann::json& value) { print(value.dump(1) + "\n"); }

void Context::flush() {
  const bool written = std::fwrite(output_.data(), 1, output_.size(), stdout) == output_.size();
  const bool flushed = std::fflush(stdout) == 0;
  output_.clear();
  if ((written && flushed) || errno == EPIPE) return;
  throw Error(ErrorCode::kUnwritableOutput,
              fmt::format("the output cannot be written to stdout: {}", std::strerror(errno)));
}

} // namespace kinora::cli
