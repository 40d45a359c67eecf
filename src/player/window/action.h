// What a person can ask of the window, and with which key.
#pragma once

#include <optional>

namespace kinora::player::window {

struct Action {
  enum class Kind {
    kPlayPause,
    kStep,   ///< value: frames, may be negative
    kSeek,   ///< value: seconds of the clip
    kSeekBy, ///< value: seconds, may be negative
    kLoop,
    kSpeed,      ///< value: factor on the speed
    kMute,       ///< or sound again
    kHome,       ///< back to the capture's own view
    kLayer,      ///< value: index of the layer to be shown or hidden
    kView,       ///< value: PictureView
    kScreenshot, ///< into the current folder
    kRecord,     ///< starts or ends the recording of the camera's path
    kPanel,      ///< shows or hides what lies over the picture
    kQuit
  };
  Kind kind{};
  double value = 0;
  bool operator==(const Action&) const = default;
};

/// Keys that give no character.
enum class SpecialKey { kEscape, kHome, kLeft, kRight, kTab };

/// The action of a character, whatever key of the layout gives it; none if it has none.
std::optional<Action> action_of(char32_t character);
Action action_of(SpecialKey key);

} // namespace kinora::player::window
