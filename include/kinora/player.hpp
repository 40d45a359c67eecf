// The C++ interface of Kinora's player: player.h with objects that close themselves and errors that are exceptions,
// which are thrown by this header alone. Units, threads and memory are said in player.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <kinora/player.h>

namespace kinora {

/// What went wrong, as one sentence for a person.
class ClipError : public std::runtime_error {
public:
  ClipError(KinoraPlayerStatus status, const char* sentence) : std::runtime_error(sentence), status_(status) {}
  KinoraPlayerStatus status() const { return status_; }

private:
  KinoraPlayerStatus status_;
};

/// Bytes that the caller fetches; used while a clip is opened, or until a player that follows it is gone.
class ClipSource {
public:
  virtual ~ClipSource() = default;
  virtual std::string name() const = 0;
  virtual std::uint64_t size() const = 0;
  /// Fills `out` from `offset`; false if it cannot. Must not throw.
  virtual bool read(std::uint64_t offset, std::span<std::byte> out) noexcept = 0;
  /// Whether a player that follows it asks for its size again, which then must not throw.
  virtual bool grows() const noexcept { return false; }
};

/// What ClipPlayer::update() has found.
struct ClipArrival {
  bool more = false;     ///< layers or frames
  bool complete = false; ///< nothing more will come
  std::string message;   ///< what is awaited, missing or wrong; empty: nothing
};

/// A picture and its buffer.
struct ClipPicture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> color; ///< 4 per pixel: sRGB and straight alpha
};

/// A clip that can be looked at. Moves, is not copied. Throws ClipError.
class ClipPlayer {
public:
  static ClipPlayer open(const std::string& path) {
    return make([&](KinoraPlayer** player) { return kinora_player_open_file(path.c_str(), player); });
  }
  static ClipPlayer open(std::span<const std::byte> bytes, const std::string& name) {
    return make([&](KinoraPlayer** player) {
      return kinora_player_open_memory(bytes.data(), bytes.size(), name.c_str(), player);
    });
  }
  static ClipPlayer open(ClipSource& source) {
    const std::string name = source.name();
    const KinoraPlayerSource plain = plain_source(source, name);
    return make([&](KinoraPlayer** player) { return kinora_player_open_source(&plain, player); });
  }

  /// Of a clip that may be damaged, cut short or still on its way, as soon as there is something to show.
  static ClipPlayer follow(const std::string& path) {
    return make([&](KinoraPlayer** player) { return kinora_player_follow_file(path.c_str(), player); });
  }
  /// `source` is read in another thread, and must outlive the player.
  static ClipPlayer follow(ClipSource& source) {
    const std::string name = source.name();
    const KinoraPlayerSource plain = plain_source(source, name);
    return make([&](KinoraPlayer** player) { return kinora_player_follow_source(&plain, player); });
  }
  /// Takes what has come since; layers may be numbered anew.
  ClipArrival update() {
    KinoraPlayerArrival arrival{};
    arrival.struct_size = sizeof arrival;
    check(kinora_player_update(get(), &arrival));
    return {arrival.more != 0, arrival.complete != 0, arrival.message};
  }

  KinoraPlayerInfo info() const {
    KinoraPlayerInfo info{};
    info.struct_size = sizeof info;
    check(kinora_player_info(get(), &info));
    return info;
  }
  std::vector<KinoraPlayerLayer> layers() const {
    std::vector<KinoraPlayerLayer> layers(info().layers);
    for (std::uint32_t i = 0; i < layers.size(); ++i) {
      layers[i].struct_size = sizeof(KinoraPlayerLayer);
      check(kinora_player_layer(get(), i, &layers[i]));
    }
    return layers;
  }
  double frame_time(std::uint64_t frame) const {
    double seconds = 0;
    check(kinora_player_frame_time(get(), frame, &seconds));
    return seconds;
  }
  KinoraPlayerCamera capture_camera(double seconds) const {
    KinoraPlayerCamera camera{};
    camera.struct_size = sizeof camera;
    check(kinora_player_capture_camera(get(), seconds, &camera));
    return camera;
  }

  /// The full picture of all layers.
  ClipPicture render(const KinoraPlayerCamera& camera, double seconds,
                     KinoraPlayerView view = KINORA_PLAYER_COLOR) const {
    return render(camera, seconds, view, nullptr);
  }
  /// From coarse to fine: `refined` is given each picture and whether it is the last, and returns false to stop there.
  /// Exceptions of `refined` end the rendering and are thrown again here. Returns the last picture.
  ClipPicture render(const KinoraPlayerCamera& camera, double seconds, KinoraPlayerView view,
                     const std::function<bool(const ClipPicture& picture, bool finest)>& refined) const {
    struct Refinement {
      const std::function<bool(const ClipPicture&, bool)>& refined;
      ClipPicture picture;
      std::exception_ptr thrown;
    } state{refined, {camera.width, camera.height, {}}, nullptr};
    if (camera.width > 0 && camera.height > 0)
      state.picture.color.resize(4 * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
    const auto call = [](void* context, std::int32_t finest) {
      auto& now = *static_cast<Refinement*>(context);
      try {
        return now.refined(now.picture, finest != 0) ? 1 : 0;
      } catch (...) {
        now.thrown = std::current_exception();
        return 0;
      }
    };
    KinoraPlayerRequest request{};
    request.struct_size = sizeof request;
    request.camera = camera;
    request.seconds = seconds;
    if (refined) request.refined = call;
    request.context = &state;
    KinoraPlayerPicture buffers{};
    buffers.struct_size = sizeof buffers;
    buffers.view = view;
    buffers.color = state.picture.color.data();
    const KinoraPlayerStatus status = kinora_player_render(get(), &request, &buffers);
    if (state.thrown) std::rethrow_exception(state.thrown);
    if (status != KINORA_PLAYER_CANCELLED) check(status);
    return std::move(state.picture);
  }
  void cancel() { kinora_player_cancel(get()); }

  double time() const { return kinora_player_time(get()); }
  std::uint64_t frame() const { return kinora_player_frame(get()); }
  bool is_playing() const { return kinora_player_is_playing(get()) != 0; }
  void play() { kinora_player_play(get()); }
  void pause() { kinora_player_pause(get()); }
  void seek(double seconds) { check(kinora_player_seek(get(), seconds)); }
  void step(int frames) { kinora_player_step(get(), frames); }
  void set_speed(double speed) { check(kinora_player_set_speed(get(), speed)); }
  void set_loop(bool loop) { kinora_player_set_loop(get(), loop ? 1 : 0); }

  /// For functions of player.h that have none here.
  KinoraPlayer* get() const { return player_.get(); }

private:
  static KinoraPlayerSource plain_source(ClipSource& source, const std::string& name) {
    KinoraPlayerSource plain{};
    plain.struct_size = sizeof plain;
    plain.name = name.c_str();
    plain.context = &source;
    plain.size = source.size();
    plain.read = [](void* context, std::uint64_t offset, void* out, std::size_t count) {
      return static_cast<ClipSource*>(context)->read(offset, {static_cast<std::byte*>(out), count}) ? 1 : 0;
    };
    if (source.grows()) plain.new_size = [](void* context) { return static_cast<ClipSource*>(context)->size(); };
    return plain;
  }
  struct Close {
    void operator()(KinoraPlayer* player) const { kinora_player_close(player); }
  };
  explicit ClipPlayer(KinoraPlayer* player) : player_(player) {}

  template <typename Open> static ClipPlayer make(const Open& open) {
    KinoraPlayer* player = nullptr;
    check(open(&player));
    return ClipPlayer(player);
  }
  static void check(KinoraPlayerStatus status) {
    if (status != KINORA_PLAYER_OK) throw ClipError(status, kinora_player_error());
  }

  std::unique_ptr<KinoraPlayer, Close> player_;
};

} // namespace kinora
