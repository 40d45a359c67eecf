#include "player/window/action.h"

namespace kinora::player::window {

std::optional<Action> action_of(char32_t character) {
  using enum Action::Kind;
  if (character >= U'1' && character <= U'9') return Action{kLayer, static_cast<double>(character - U'1')};
  switch (character) {
  case U' ':
    return Action{kPlayPause};
  case U'.':
    return Action{kStep, 1};
  case U',':
    return Action{kStep, -1};
  case U'l':
    return Action{kLoop};
  case U'm':
    return Action{kMute};
  case U'[':
    return Action{kSpeed, 0.5};
  case U']':
    return Action{kSpeed, 2};
  case U'0':
    return Action{kHome};
  case U'c':
    return Action{kView, 0};
  case U'd':
    return Action{kView, 1};
  case U'n':
    return Action{kView, 2};
  case U'v':
    return Action{kView, 3};
  case U'h':
    return Action{kView, 4};
  case U's':
    return Action{kScreenshot};
  case U'r':
    return Action{kRecord};
  case U'q':
    return Action{kQuit};
  default:
    return std::nullopt;
  }
}

Action action_of(SpecialKey key) {
  using enum Action::Kind;
  switch (key) {
  case SpecialKey::kHome:
    return {kHome};
  case SpecialKey::kLeft:
    return {kSeekBy, -1};
  case SpecialKey::kRight:
    return {kSeekBy, 1};
  case SpecialKey::kTab:
    return {kPanel};
  case SpecialKey::kEscape:
    break;
  }
  return {kQuit};
}

} // namespace kinora::player::window
