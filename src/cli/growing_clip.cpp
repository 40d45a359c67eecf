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
  if (!output_.can_be_read_back()) return; // a device: nobody follows it
  if (!live_) {
    live_.emplace(output_.writing_path(), clip.intrinsics);
    live_->write(clip);
    output_.commit();
    return;
  }
  try {
    live_->write(clip);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnwritableOutput) throw;
    live_->finish_at_last_update();
    tell_what_is_there(error);
  }
}

void GrowingClipFile::finish(const clip::Clip& clip) {
  if (!live_) {
    clip::write_clip(clip, output_.writing_path());
    output_.commit();
    return;
  }
  live_->finish(); // whoever follows it sees that this is all
  Unfinished whole(output_.path(), Unfinished::Kind::kFile);
  try {
    clip::write_clip(clip, whole.path());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnwritableOutput) throw;
    tell_what_is_there(error);
  }
  std::error_code error;
  std::filesystem::rename(whole.path(), output_.path(), error);
  if (error) {
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written: {}", output_.path().string(), error.message()));
  }
  whole.keep();
}

void GrowingClipFile::tell_what_is_there(const Error& error) const {
  throw Error(ErrorCode::kUnwritableOutput,
              fmt::format("{}; {} is complete up to there and can be read", error.what(), output_.path().string()));
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
  seen_from_ = view.camera.camera_to_world;
  const auto output =
      PictureOutput::open({numbered_path(pattern_, count_++), {}, overwrite_, {}, {}}, {view.name}, plugins_);
  output->add({player.draw(view.camera, view.frame, player.all_layers(), {}), view.name, 0, view.camera});
  output->finish();
}

} // namespace kinora::cli
