// include/kinora/player.h over the player: exceptions become status codes here.
#include <kinora/player.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>

#include <fmt/format.h>

#include "clip/clip_io.h"
#include "player/api_errors.h"
#include "player/callback_source.h"
#include "player/picture_view.h"
#include "player/player_handle.h"
#include "player/subject.h"

namespace kinora::player {
namespace {

thread_local std::string last_error; // NOLINT: C functions say what went wrong through it

} // namespace

KinoraPlayerStatus failed(int status, const char* sentence) noexcept {
  try {
    last_error = sentence;
  } catch (...) {
    last_error.clear();
  }
  return static_cast<KinoraPlayerStatus>(status);
}

namespace {

KinoraPlayer* opened(std::unique_ptr<container::ByteSource> source) {
  const std::uint64_t bytes = source->size();
  auto player = std::make_shared<const Player>(clip::read_clip(std::move(source)));
  return std::make_unique<KinoraPlayer>(ClipSoFar{std::move(player), true, "", bytes}).release();
}

void to_plain(const Camera& camera, KinoraPlayerCamera& plain) {
  const Intrinsics& k = camera.intrinsics;
  plain = {plain.struct_size, k.width, k.height, k.fx, k.fy, k.cx, k.cy, {}};
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(plain.camera_to_world) = camera.camera_to_world.matrix();
}

Camera from_plain(const KinoraPlayerCamera& plain) {
  require_size(&plain, "KinoraPlayerCamera");
  Camera camera{{plain.width, plain.height, plain.fx, plain.fy, plain.cx, plain.cy}};
  constexpr int kMaxSide = 16384;
  if (plain.width < 1 || plain.height < 1 || plain.width > kMaxSide || plain.height > kMaxSide) {
    misused("a picture must have between 1 and 16384 pixels on each side");
  }
  const bool focal = plain.fx > 0 && plain.fy > 0 && std::isfinite(plain.fx) && std::isfinite(plain.fy);
  if (!focal || !std::isfinite(plain.cx) || !std::isfinite(plain.cy)) misused("the camera's intrinsics are none");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(plain.camera_to_world);
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool rigid = matrix.allFinite() && matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-6) &&
                     (rotation.transpose() * rotation).isIdentity(1e-4) && rotation.determinant() > 0;
  if (!rigid) misused("camera_to_world is no rotation and translation");
  camera.camera_to_world.matrix() = matrix;
  return camera;
}

PictureView view_of(KinoraPlayerView view) {
  if (view < KINORA_PLAYER_COLOR || view > KINORA_PLAYER_HEALTH) misused(fmt::format("there is no view {}", view));
  return static_cast<PictureView>(view);
}

/// Every pixel of the caller's buffer from a picture of its size, or a smaller one whose pixels are repeated.
template <typename T>
void put(const Image<T>& image, int channels, int width, int height, T* out, std::size_t row_bytes) {
  for (int v = 0; v < height; ++v) {
    T* to = reinterpret_cast<T*>(reinterpret_cast<std::byte*>(out) + static_cast<std::size_t>(v) * row_bytes);
    const int from_row = static_cast<int>(static_cast<std::int64_t>(v) * image.height() / height);
    for (int u = 0; u < width; ++u, to += channels) {
      const int from = static_cast<int>(static_cast<std::int64_t>(u) * image.width() / width);
      std::copy_n(image.pixel(from, from_row), channels, to);
    }
  }
}

/// One request: draws at one size after the other.
class Rendering {
public:
  Rendering(const KinoraPlayer& owner, const KinoraPlayerRequest& request, const KinoraPlayerPicture& picture)
      : owner_(owner), player_(owner.player()), request_(request), picture_(picture),
        camera_(from_plain(request.camera)), view_(view_of(picture.view)), options_(draw_options_for(view_)),
        started_(owner.cancellations), preview_(request.struct_size >= sizeof request && request.preview != 0) {
    if (!std::isfinite(request.seconds)) misused("the time is no number");
    row_bytes_ = picture.color_row_bytes != 0 ? picture.color_row_bytes : 4 * width();
    if (row_bytes_ < 4 * width()) misused("color_row_bytes is less than a row of the picture has");
    options_.normals |= picture.normal != nullptr;
    options_.confidence |= picture.confidence != nullptr;
    for (std::size_t i = 0; i < player_->clip().layers.size(); ++i) {
      if (request.visible == nullptr || request.visible[i] != 0) layers_.push_back(i);
    }
  }

  void run() const {
    constexpr std::array<int, 3> kCoarse{8, 4, 2};
    const double frame = player_->clip().frame_at(request_.seconds);
    const auto health = player_->drawn_health(frame, layers_);
    if (request_.refined != nullptr) {
      for (const int reduction : kCoarse) {
        Camera coarse = camera_;
        coarse.intrinsics = camera_.intrinsics.resized((camera_.intrinsics.width + reduction - 1) / reduction,
                                                       (camera_.intrinsics.height + reduction - 1) / reduction);
        check();
        tell(player_->preview(coarse, frame, layers_, options_), health, false);
      }
    }
    check();
    tell(preview_ ? player_->preview(camera_, frame, layers_, options_)
                  : player_->draw(camera_, frame, layers_, options_),
         health, true);
  }

private:
  std::size_t width() const { return static_cast<std::size_t>(camera_.intrinsics.width); }
  [[noreturn]] static void cancelled() { throw Error(ErrorCode::kInterrupted, "the rendering was cancelled"); }
  void check() const {
    if (owner_.cancellations != started_) cancelled();
  }

  void tell(const fields::Picture& drawn, const std::vector<motion::Health>& health, bool finest) const {
    const auto [w, h] = std::pair(camera_.intrinsics.width, camera_.intrinsics.height);
    check();
    if (picture_.color != nullptr) put(painted(drawn, view_, health), 4, w, h, picture_.color, row_bytes_);
    if (picture_.depth != nullptr) put(drawn.depth, 1, w, h, picture_.depth, width() * sizeof(float));
    if (picture_.normal != nullptr) put(drawn.normal, 3, w, h, picture_.normal, 3 * width() * sizeof(float));
    if (picture_.confidence != nullptr) put(drawn.confidence, 1, w, h, picture_.confidence, width());
    if (request_.refined != nullptr && request_.refined(request_.context, finest ? 1 : 0) == 0 && !finest) cancelled();
  }

  const KinoraPlayer& owner_;
  std::shared_ptr<const Player> player_;
  const KinoraPlayerRequest& request_;
  const KinoraPlayerPicture& picture_;
  Camera camera_;
  PictureView view_;
  fields::DrawOptions options_;
  std::uint64_t started_;
  bool preview_;
  std::size_t row_bytes_ = 0;
  LayerChoice layers_;
};

void fill_info(const KinoraPlayer& player, KinoraPlayerInfo& info) {
  const ClipSoFar now = player.now();
  const clip::Clip& clip = now.player->clip();
  const Intrinsics& k = clip.intrinsics;
  const double duration = clip.times.back() - clip.times.front();
  const double rate = duration > 0 ? static_cast<double>(clip.times.size() - 1) / duration : 30;
  info = {info.struct_size,
          static_cast<std::uint32_t>(clip.layers.size()),
          clip.times.size(),
          now.bytes,
          duration,
          rate,
          k.width,
          k.height,
          k.fx,
          k.fy,
          k.cx,
          k.cy};
}

template <typename Body> auto with_clock(const KinoraPlayer* player, const Body& body) {
  const std::lock_guard lock(player->clock_mutex);
  return body(player->clock);
}
template <typename Body> auto with_clock(KinoraPlayer* player, const Body& body) {
  const std::lock_guard lock(player->clock_mutex);
  return body(player->clock);
}

} // namespace
} // namespace kinora::player

using namespace kinora::player; // NOLINT: the C functions below are this room's
using kinora::container::FileSource;
using kinora::container::MemorySource;

const char* kinora_player_error(void) { return last_error.c_str(); }

KinoraPlayerStatus kinora_player_open_file(const char* path, KinoraPlayer** player) {
  return guarded([&] {
    require(path, "path");
    require(player, "player");
    *player = nullptr;
    *player = opened(std::make_unique<FileSource>(path));
  });
}

KinoraPlayerStatus kinora_player_open_memory(const void* bytes, size_t size, const char* name, KinoraPlayer** player) {
  return guarded([&] {
    require(bytes, "bytes");
    require(player, "player");
    *player = nullptr;
    const std::span span(static_cast<const std::byte*>(bytes), size);
    *player = opened(std::make_unique<MemorySource>(span, name != nullptr ? name : "the clip"));
  });
}

KinoraPlayerStatus kinora_player_open_source(const KinoraPlayerSource* source, KinoraPlayer** player) {
  return guarded([&] {
    require(player, "player");
    *player = nullptr;
    *player = opened(callback_source(source));
  });
}

void kinora_player_close(KinoraPlayer* player) { delete player; } // NOLINT: owned by the caller through this interface

KinoraPlayerStatus kinora_player_info(const KinoraPlayer* player, KinoraPlayerInfo* info) {
  return guarded([&] {
    require(player, "player");
    require_size(info, "KinoraPlayerInfo");
    fill_info(*player, *info);
  });
}

KinoraPlayerStatus kinora_player_layer(const KinoraPlayer* player, uint32_t layer, KinoraPlayerLayer* about) {
  return guarded([&] {
    require(player, "player");
    require_size(about, "KinoraPlayerLayer");
    const auto now = player->player();
    const auto& layers = now->clip().layers;
    if (layer >= layers.size()) misused(fmt::format("there is no layer {}; the clip has {}", layer, layers.size()));
    const kinora::clip::Layer& known = layers[layer];
    *about = {about->struct_size, known.label, player->kept(known.name),
              kinora::motion::name_of(known.motion.kind()).data(), known.confidence ? 1 : 0};
  });
}

KinoraPlayerStatus kinora_player_frame_time(const KinoraPlayer* player, uint64_t frame, double* seconds) {
  return guarded([&] {
    require(player, "player");
    require(seconds, "seconds");
    const auto now = player->player();
    const auto& times = now->clip().times;
    if (frame >= times.size()) misused(fmt::format("there is no frame {}; the clip has {}", frame, times.size()));
    *seconds = times[frame];
  });
}

KinoraPlayerStatus kinora_player_subject(const KinoraPlayer* player, double seconds, double position[3]) {
  return guarded([&] {
    require(player, "player");
    require(position, "position");
    if (!std::isfinite(seconds)) misused("the time is no number");
    const auto now = player->player();
    const auto frame = static_cast<int>(std::lround(now->clip().frame_at(seconds)));
    Eigen::Map<Eigen::Vector3d>{position} = subject_of(*now, frame);
  });
}

KinoraPlayerStatus kinora_player_capture_camera(const KinoraPlayer* player, double seconds,
                                                KinoraPlayerCamera* camera) {
  return guarded([&] {
    require(player, "player");
    require_size(camera, "KinoraPlayerCamera");
    if (!std::isfinite(seconds)) misused("the time is no number");
    const auto now = player->player();
    const kinora::clip::Clip& clip = now->clip();
    to_plain(clip.capture_camera(clip.frame_at(seconds)), *camera);
  });
}

KinoraPlayerStatus kinora_player_resize_camera(KinoraPlayerCamera* camera, int32_t width, int32_t height) {
  return guarded([&] {
    require(camera, "camera");
    kinora::Camera wanted = from_plain(*camera);
    if (width < 1 || height < 1) misused("a picture has at least one pixel on each side");
    wanted.intrinsics = wanted.intrinsics.resized(width, height);
    to_plain(wanted, *camera);
  });
}

KinoraPlayerStatus kinora_player_render(KinoraPlayer* player, const KinoraPlayerRequest* request,
                                        const KinoraPlayerPicture* picture) {
  return guarded([&] {
    require(player, "player");
    require_size(request, "KinoraPlayerRequest", offsetof(KinoraPlayerRequest, preview));
    require_size(picture, "KinoraPlayerPicture");
    Rendering(*player, *request, *picture).run();
  });
}

void kinora_player_cancel(KinoraPlayer* player) { ++player->cancellations; }

double kinora_player_time(const KinoraPlayer* player) {
  return with_clock(player, [](const PlaybackClock& clock) { return clock.seconds(); });
}
uint64_t kinora_player_frame(const KinoraPlayer* player) {
  return with_clock(player, [](const PlaybackClock& clock) { return clock.frame(); });
}
int kinora_player_is_playing(const KinoraPlayer* player) {
  return with_clock(player, [](const PlaybackClock& clock) { return clock.playing() ? 1 : 0; });
}
void kinora_player_play(KinoraPlayer* player) {
  with_clock(player, [](PlaybackClock& clock) { clock.play(); });
}
void kinora_player_pause(KinoraPlayer* player) {
  with_clock(player, [](PlaybackClock& clock) { clock.pause(); });
}
KinoraPlayerStatus kinora_player_seek(KinoraPlayer* player, double seconds) {
  return guarded([&] {
    require(player, "player");
    if (!std::isfinite(seconds)) misused("the time is no number");
    with_clock(player, [&](PlaybackClock& clock) { clock.seek(seconds); });
  });
}
void kinora_player_step(KinoraPlayer* player, int frames) {
  with_clock(player, [&](PlaybackClock& clock) { clock.step(frames); });
}
KinoraPlayerStatus kinora_player_set_speed(KinoraPlayer* player, double speed) {
  return guarded([&] {
    require(player, "player");
    with_clock(player, [&](PlaybackClock& clock) { clock.set_speed(speed); });
  });
}
void kinora_player_set_loop(KinoraPlayer* player, int loop) {
  with_clock(player, [&](PlaybackClock& clock) { clock.set_loop(loop != 0); });
}
void kinora_player_set_master(KinoraPlayer* player, double (*seconds)(void* context), void* context) {
  with_clock(player, [&](PlaybackClock& clock) {
    clock.set_master(seconds != nullptr ? MasterClock([=] { return seconds(context); }) : steady_clock());
  });
}
