// The subcommands: each adds itself to the command line.
#pragma once

#include "cli/context.h"

namespace kinora::cli {

void add_info(CLI::App& app, Context& context);
void add_formats(CLI::App& app, Context& context);
void add_probe(CLI::App& app, Context& context);
void add_encode(CLI::App& app, Context& context);
void add_render(CLI::App& app, Context& context);
void add_convert(CLI::App& app, Context& context);
void add_track(CLI::App& app, Context& context);
void add_motion(CLI::App& app, Context& context);
void add_eval(CLI::App& app, Context& context);
void add_play(CLI::App& app, Context& context);
void add_serve(CLI::App& app, Context& context);
void add_record(CLI::App& app, Context& context);
void add_recover(CLI::App& app, Context& context);
void add_validate(CLI::App& app, Context& context);
void add_cut(CLI::App& app, Context& context);
void add_join(CLI::App& app, Context& context);

} // namespace kinora::cli
