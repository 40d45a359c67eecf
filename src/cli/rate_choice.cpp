#include "cli/rate_choice.h"

#include <cmath>

#include <fmt/format.h>

namespace kinora::cli {

void add_kb_per_frame_option(CLI::App& command, double& kb_per_frame) {
  command
      .add_option(
          "--kb-per-frame", kb_per_frame,
          "Store the fields so finely or coarsely that the file takes N times 1000 bytes for each frame, a flat "
          "preview apart")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
}

encode::RateChoice choose_rate(const clip::Clip& clip, std::size_t usual_bytes, double kb_per_frame, Context& context,
                               nlohmann::json& report) {
  const encode::RateControl control(clip, usual_bytes, context.progress);
  const auto frames = static_cast<double>(clip.times.size());
  const auto in_kb = [frames](std::size_t bytes) { return std::round(static_cast<double>(bytes) / frames) / 1000; };
  const auto wanted = static_cast<std::size_t>(std::llround(1000 * kb_per_frame * frames));
  encode::RateChoice choice = control.for_bytes(wanted);
  report = {{"psnr_of_rounding", std::round(100 * choice.picture_psnr) / 100},
            {"fewest_kb_per_frame", in_kb(control.fewest_bytes())},
            {"most_kb_per_frame", in_kb(control.most_bytes())},
            {"wanted_kb_per_frame", kb_per_frame}};
  const bool is_less = wanted < control.fewest_bytes();
  if (is_less || wanted > control.most_bytes()) {
    context.progress.warn(fmt::format("--kb-per-frame {:g} is {} than the clip {}; it takes {:.2f} KB per frame",
                                      kb_per_frame, is_less ? "less" : "more", is_less ? "needs" : "can use",
                                      in_kb(choice.bytes)));
  }
  return choice;
}

} // namespace kinora::cli
