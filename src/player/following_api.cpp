// The part of include/kinora/player.h that shows clips which are damaged or still on their way.
#include <kinora/player.h>

#include <memory>

#include "player/api_errors.h"
#include "player/callback_source.h"
#include "player/clip_feed.h"
#include "player/player_handle.h"

namespace kinora::player {
namespace {

KinoraPlayer* followed(std::unique_ptr<container::ByteSource> source) {
  const auto feed = std::make_shared<const ClipFeed>(std::move(source));
  ClipSoFar first = feed->first([] { return false; });
  return std::make_unique<KinoraPlayer>(std::move(first), [feed] { return feed->newest(); }).release();
}

} // namespace
} // namespace kinora::player

using namespace kinora::player; // NOLINT: the C functions below are this room's

KinoraPlayerStatus kinora_player_follow_file(const char* path, KinoraPlayer** player) {
  return guarded([&] {
    require(path, "path");
    require(player, "player");
    *player = nullptr;
    *player = followed(std::make_unique<kinora::container::FileSource>(path));
  });
}

KinoraPlayerStatus kinora_player_follow_source(const KinoraPlayerSource* source, KinoraPlayer** player) {
  return guarded([&] {
    require(player, "player");
    *player = nullptr;
    *player = followed(callback_source(source));
  });
}

KinoraPlayerStatus kinora_player_update(KinoraPlayer* player, KinoraPlayerArrival* arrival) {
  return guarded([&] {
    require(player, "player");
    require_size(arrival, "KinoraPlayerArrival");
    thread_local std::string message; // NOLINT: lives until this thread asks again
    arrival->more = player->update() ? 1 : 0;
    ClipSoFar now = player->now();
    message = std::move(now.message);
    arrival->complete = now.complete ? 1 : 0;
    arrival->message = message.c_str();
  });
}
