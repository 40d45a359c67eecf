#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#define GLFW_INCLUDE_GLCOREARB // textures only: what every OpenGL library exports
#define GL_GLEXT_PROTOTYPES
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "core/error.h"
#include "player/window/panel.h"
#include "player/window/window_functions.h"

namespace kinora::player::window {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void fail(const std::string& what) {
  const char* description = nullptr;
  glfwGetError(&description);
  throw Error(ErrorCode::kMissingComponent,
              fmt::format("{} ({}); play where there is a screen with OpenGL 3.0, or draw pictures with kinora render",
                          what, description != nullptr ? description : "no reason is given"));
}

/// The library GLFW.
class Library {
public:
  Library() {
    if (glfwInit() != GLFW_TRUE) fail("there is no display to open a window on");
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() { glfwTerminate(); }
};

/// A window and its OpenGL.
class Window {
public:
  Window(Shown& shown, int width, int height) : shown_(&shown) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
    handle_ = glfwCreateWindow(width, height, "Kinora", nullptr, nullptr);
    if (handle_ == nullptr) fail("no window with OpenGL 3.0 can be opened on this display");
    glfwMakeContextCurrent(handle_);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(handle_, this);
    glfwSetKeyCallback(handle_, [](GLFWwindow* window, int key, int, int action, int) { of(window).key(key, action); });
    glfwSetCharCallback(handle_, [](GLFWwindow* window, unsigned character) { of(window).character(character); });
    glfwSetDropCallback(handle_, [](GLFWwindow* window, int count, const char** paths) {
      of(window).stir();
      if (count > 0) of(window).shown_->open(paths[0]);
    });
    glfwSetCursorPosCallback(handle_, [](GLFWwindow* window, double, double) { of(window).stir(); });
    glfwSetMouseButtonCallback(handle_, [](GLFWwindow* window, int, int, int) { of(window).stir(); });
    glfwSetScrollCallback(handle_, [](GLFWwindow* window, double, double) { of(window).stir(); });
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window() { glfwDestroyWindow(handle_); }

  GLFWwindow* handle() const { return handle_; }
  void stir() { stirred_ = Clock::now(); }
  /// Events come soon after one another.
  bool stirring() const { return Clock::now() - stirred_ < std::chrono::milliseconds(600); }

private:
  static Window& of(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

  void character(unsigned value) {
    stir();
    if (const auto action = action_of(static_cast<char32_t>(value))) shown_->act(*action);
  }
  void key(int key, int action) {
    if (action == GLFW_RELEASE) return;
    stir();
    if (key == GLFW_KEY_ESCAPE) shown_->act(action_of(SpecialKey::kEscape));
    if (key == GLFW_KEY_HOME) shown_->act(action_of(SpecialKey::kHome));
    if (key == GLFW_KEY_LEFT) shown_->act(action_of(SpecialKey::kLeft));
    if (key == GLFW_KEY_RIGHT) shown_->act(action_of(SpecialKey::kRight));
    if (key == GLFW_KEY_TAB) shown_->act(action_of(SpecialKey::kTab));
  }

  Shown* shown_;
  GLFWwindow* handle_ = nullptr;
  Clock::time_point stirred_ = Clock::now();
};

/// Dear ImGui in that window, after the window's own callbacks, which it calls in turn.
class Gui {
public:
  explicit Gui(GLFWwindow* window) {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // leaves no file behind
    ImGui::StyleColorsDark();
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    if (!ImGui_ImplOpenGL3_Init("#version 130")) fail("this OpenGL cannot draw");
  }
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;
  ~Gui() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
};

/// The picture behind everything.
class Backdrop {
public:
  Backdrop() {
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  Backdrop(const Backdrop&) = delete;
  Backdrop& operator=(const Backdrop&) = delete;
  ~Backdrop() { glDeleteTextures(1, &texture_); }

  void draw(std::shared_ptr<const ColorImage> picture) {
    if (picture && picture != picture_) {
      glBindTexture(GL_TEXTURE_2D, texture_);
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, picture->width(), picture->height(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                   picture->data());
      picture_ = std::move(picture);
    }
    if (!picture_) return;
    auto* const id = reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture_));
    ImGui::GetBackgroundDrawList()->AddImage(id, {0, 0}, ImGui::GetIO().DisplaySize);
  }

private:
  GLuint texture_ = 0;
  std::shared_ptr<const ColorImage> picture_;
};

void follow_mouse(Shown& shown) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse || io.DisplaySize.y <= 0) return;
  const double right = io.MouseDelta.x / io.DisplaySize.y;
  const double down = io.MouseDelta.y / io.DisplaySize.y;
  const bool dragged = right != 0 || down != 0;
  const bool left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (dragged && (ImGui::IsMouseDown(ImGuiMouseButton_Middle) || (left && io.KeyShift))) {
    shown.pan(right, down);
  } else if (dragged && left) {
    shown.orbit(right, down);
  }
  if (io.MouseWheel != 0) shown.zoom(io.MouseWheel);
}

void draw(Shown& shown, GLFWwindow* window, Backdrop& backdrop, const Panel& panel) {
  int width = 0;
  int height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  follow_mouse(shown);
  backdrop.draw(shown.picture());
  draw_panel(shown, panel);
  ImGui::Render();
  glViewport(0, 0, width, height);
  glClearColor(0.12F, 0.12F, 0.13F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window);
}

} // namespace

void require_display() { const Library library; }

void show(Shown& shown, int width, int height) {
  constexpr double kSoon = 1.0 / 90, kIdle = 0.1; // seconds
  const Library library;
  Window window(shown, width, height);
  const Gui gui(window.handle());
  Backdrop backdrop;
  std::string title;
  bool playing = true;
  while (!shown.ended() && glfwWindowShouldClose(window.handle()) == GLFW_FALSE) {
    glfwWaitEventsTimeout(playing || window.stirring() ? kSoon : kIdle);
    glfwGetFramebufferSize(window.handle(), &width, &height);
    const bool minimised = width < 1 || height < 1; // its sound goes on
    const Panel& panel = shown.panel(std::max(width, 1), std::max(height, 1));
    playing = panel.playing;
    if (title != panel.title)
      glfwSetWindowTitle(window.handle(), fmt::format("{} - Kinora", title = panel.title).c_str());
    if (!minimised) draw(shown, window.handle(), backdrop, panel);
  }
}

} // namespace kinora::player::window
