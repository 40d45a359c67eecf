#include "cli/growing_clip.h"

#include <fmt/format.h>

#include "cli/conversion.h"
#include "cli/picture_output.h"
#include "clip/clip_io.h"
#include "core/error.h"
#include "player/player.h"
#include "player/view_path.h"

namespace kinora::cli {

void GrowingClipFile::write(const clip::Clip& clip) {
  if (!first_.can_be_read_back() || !is_there_) {
    clip::write_clip(clip, first_.writing_path());
    first_.commit();
    is_there_ = true;
    return;
  }
  Unfinished next(first_.path(), Unfinished::Kind::kFile);
  clip::write_clip(clip, next.path());
  std::error_code error;
  std::filesystem::rename(next.path(), first_.path(), error);
  if (error) {
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written: {}", first_.path().string(), error.message()));
  }
  next.keep();
}

LivePreview::LivePreview(std::filesystem::path pattern, double every, bool overwrite, const host::PluginTable& plugins)
    : pattern_(std::move(pattern)), every_(every), overwrite_(overwrite), plugins_(plugins) {
  if (output_kind(pattern_, plugins_) == OutputKind::kPicture) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("--preview {} names no picture; give a name such as look.png", pattern_.string()));
}

void LivePreview::show(const clip::Clip& clip) {
  using Seconds = std::chrono::duration<double>;
  const auto now = std::chrono::steady_clock::now();
  if (last_ && Seconds(now - *last_).count() < every_) return;
  last_ = now;
  const player::Player player(clip);
  const player::View view = player::orbit_views(player, {static_cast<int>(clip.times.size()) - 1}, kDegrees).front();
  const auto output =
      PictureOutput::open({numbered_path(pattern_, count_++), {}, overwrite_, {}, {}}, {view.name}, plugins_);
  output->add({player.draw(view.camera, view.frame, player.all_layers(), {}), view.name, 0, view.camera});
  output->finish();
}

} // namespace kinora::cli
