// The window itself, which GLFW, OpenGL and Dear ImGui make: a module (core/module.h), so that nobody else waits for
// it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/image.h"
#include "player/window/action.h"

namespace kinora::player::window {

/// What lies over the picture.
struct Panel {
  std::string title;
  double seconds = 0, first_seconds = 0, last_seconds = 0; ///< of the clip
  std::size_t frame = 0, frame_count = 0;
  bool playing = false, loop = false, recording = false;
  bool has_sound = false, muted = false;
  bool shown = true;
  double speed = 1;
  int view = 0;                                     ///< PictureView
  std::vector<std::pair<std::string, bool>> layers; ///< name, whether it is shown
  std::string statistics;
  std::string message; ///< what was done last, or why it was not
};

/// What a window shows, and whom it tells what a person does. All calls come from the window's own thread.
class Shown {
public:
  virtual ~Shown() = default;
  virtual void act(const Action& action) = 0;
  /// By the mouse; as fractions of the window's height.
  virtual void orbit(double right, double down) = 0;
  virtual void pan(double right, double down) = 0;
  virtual void zoom(double steps) = 0;
  virtual void open(const std::string& clip) = 0;
  /// Called for every drawing of a window of that many pixels.
  virtual const Panel& panel(int width, int height) = 0;
  /// The newest picture, 4 channels with straight alpha; null while there is none. Another picture is another object.
  virtual std::shared_ptr<const ColorImage> picture() = 0;
  virtual bool ended() const = 0;
};

/// Opens a window with a picture of that many pixels and returns when `shown` has ended or the window was closed.
/// Throws Error(kMissingComponent) without a display or OpenGL 3. To be called by the program's first thread.
void show(Shown& shown, int width, int height);

/// Throws Error(kMissingComponent) if there is no display. To be called by the program's first thread.
void require_display();

/// What the module exports, through `extern "C" const WindowFunctions* kinora_functions()`.
struct WindowFunctions {
  decltype(&show) show_window;
  decltype(&kinora::player::window::require_display) require_display;
};

/// Thread-safe. Throws Error(kMissingComponent) if the module or a library that it needs is not installed.
const WindowFunctions& window_functions();

} // namespace kinora::player::window
