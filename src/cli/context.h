// What every subcommand is given: the options that all share, progress, the plugins and the way to stdout.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/console_progress.h"
#include "host/plugin_table.h"

namespace kinora::cli {

struct SharedOptions {
  bool json = false;
  bool verbose = false;
  bool quiet = false;
  bool overwrite = false;
  bool no_external_plugins = false;
  int threads = 0; ///< 0: one per core
  std::vector<std::filesystem::path> plugin_folders;
};

class Context {
public:
  SharedOptions shared;
  ConsoleProgress progress;
  std::function<void()> action; ///< the subcommand that was asked for

  /// A subcommand with the shared options; `run` is called after the whole command line has been understood.
  CLI::App& add_command(CLI::App& app, const std::string& name, const std::string& description,
                        const std::string& examples, std::function<void()> run);
  /// The flag of commands that write files.
  void add_overwrite(CLI::App& command);

  /// Found on first use; a plugin that cannot be used is warned of.
  const host::PluginTable& plugins();

  /// Text for stdout; it is written when the command has ended.
  void print(const std::string& text) { output_ += text; }
  /// The machine's output of a command, if --json was given.
  void print_json(const nlohmann::json& value);
  /// Writes all that was printed. Throws Error(kUnwritableOutput); a closed pipe is no error.
  void flush();

private:
  void add_shared(CLI::App& command);

  std::string output_;
  std::unique_ptr<host::PluginTable> plugins_;
};

} // namespace kinora::cli
