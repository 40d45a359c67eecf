// kinora: volumetric video from one RGB-D camera.
#include <cstdio>
#include <exception>
#include <new>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/versions.h"
#include "core/error.h"
#include "core/parallel.h"

namespace kinora::cli {
namespace {

using AddCommand = void (*)(CLI::App&, Context&);
constexpr AddCommand kCommands[] = {add_info,    add_formats,  add_probe, add_encode, add_render, add_convert,
                                    add_track,   add_motion,   add_eval,  add_play,   add_serve,  add_record,
                                    add_recover, add_validate, add_cut,   add_join};

int fail(Context& context, int code, const std::string& sentence) {
  context.progress.finish();
  const bool color = color_wanted();
  fmt::print(stderr, "{}kinora:{} {}\n", color ? "\x1b[31m" : "", color ? "\x1b[0m" : "", sentence);
  return code;
}

// What CLI11 found wrong, as a usage error with the command whose help is meant.
std::string usage_sentence(const CLI::App& app, const CLI::ParseError& error) {
  std::string command = "kinora";
  for (const CLI::App* chosen : app.get_subcommands()) command += " " + chosen->get_name();
  std::string what = error.what();
  while (!what.empty() && (what.back() == '\n' || what.back() == '.')) what.pop_back();
  return fmt::format("{}; see {} --help", what, command);
}

int run(int argc, const char* const* argv, Context& context) {
  CLI::App app("Turns what one RGB-D camera sees into a small volumetric video, and shows it from anywhere.", "kinora");
  app.set_version_flag("--version", version_text, "Versions of Kinora and its libraries");
  app.set_help_flag("-h,--help", "This help");
  app.require_subcommand(1);
  app.footer("Examples:\n"
             "  kinora info capture/\n"
             "  kinora encode capture/ clip.mkv --report report.json\n"
             "  kinora render clip.mkv side.png --orbit 30\n"
             "  kinora COMMAND --help tells more of each.\n\n"
             "Exit codes: 0 ok, 1 failure, 2 usage, 3 not recognised, 4 corrupt input, 5 output cannot be written,\n"
             "6 a plugin or library is missing, 130 interrupted.");
  for (const AddCommand add : kCommands) add(app, context);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    app.exit(request); // help and version go to stdout
    return 0;
  } catch (const CLI::ParseError& error) {
    return fail(context, static_cast<int>(ErrorCode::kUsage), usage_sentence(app, error));
  }
  context.progress.set_verbosity(context.shared.quiet     ? Verbosity::kQuiet
                                 : context.shared.verbose ? Verbosity::kVerbose
                                                          : Verbosity::kNormal);
  set_thread_count(context.shared.threads);
  context.action();
  context.progress.finish();
  context.flush();
  return 0;
}

int guarded(int argc, const char* const* argv) {
  Context context;
  try {
    handle_signals();
    return run(argc, argv, context);
  } catch (const Error& error) {
    return fail(context, error.exit_code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(context, 1, "out of memory; take fewer frames (--frames) or a smaller picture (--size)");
  } catch (const std::exception& error) {
    return fail(context, 1, fmt::format("an error that should not happen: {}", error.what()));
  } catch (...) {
    return fail(context, 1, "an error that should not happen, of unknown kind");
  }
}

} // namespace
} // namespace kinora::cli

int main(int argc, char** argv) { return kinora::cli::guarded(argc, argv); }
