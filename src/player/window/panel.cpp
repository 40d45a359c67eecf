#include "player/window/panel.h"

#include <array>

#include <imgui.h>

namespace kinora::player::window {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar;

void draw_bar(Shown& shown, const Panel& panel) {
  using enum Action::Kind;
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  const float height = ImGui::GetFrameHeightWithSpacing() + 2 * ImGui::GetStyle().WindowPadding.y;
  ImGui::SetNextWindowPos({0, window.y - height});
  ImGui::SetNextWindowSize({window.x, height});
  ImGui::Begin("bar", nullptr, kFixed);
  if (ImGui::Button(panel.playing ? "Pause" : "Play ")) shown.act({kPlayPause});
  ImGui::SameLine();
  if (ImGui::Button("<")) shown.act({kStep, -1});
  ImGui::SameLine();
  if (ImGui::Button(">")) shown.act({kStep, 1});
  ImGui::SameLine();
  bool loop = panel.loop;
  if (ImGui::Checkbox("Loop", &loop)) shown.act({kLoop});
  ImGui::SameLine();
  bool sound = !panel.muted;
  if (panel.has_sound && ImGui::Checkbox("Sound", &sound)) shown.act({kMute});
  if (panel.has_sound) ImGui::SameLine();
  ImGui::Text("%.3gx", panel.speed);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1);
  auto seconds = static_cast<float>(panel.seconds);
  const auto first = static_cast<float>(panel.first_seconds);
  const auto last = static_cast<float>(panel.last_seconds);
  if (ImGui::SliderFloat("##time", &seconds, first, last, "%.2f s", ImGuiSliderFlags_NoInput)) {
    shown.act({kSeek, seconds});
  }
  ImGui::End();
}

void draw_box(Shown& shown, const Panel& panel) {
  using enum Action::Kind;
  constexpr std::array<const char*, 5> kViews{"colour", "depth", "normal", "confidence", "health"};
  ImGui::SetNextWindowPos({8, 8});
  ImGui::SetNextWindowBgAlpha(0.6F);
  ImGui::Begin("box", nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextUnformatted(panel.title.c_str());
  ImGui::Text("frame %zu of %zu", panel.frame, panel.frame_count);
  ImGui::TextUnformatted(panel.statistics.c_str());
  ImGui::Separator();
  for (std::size_t i = 0; i < panel.layers.size(); ++i) {
    bool visible = panel.layers[i].second;
    if (ImGui::Checkbox(panel.layers[i].first.c_str(), &visible)) shown.act({kLayer, static_cast<double>(i)});
  }
  ImGui::Separator();
  for (std::size_t i = 0; i < kViews.size(); ++i) {
    if (ImGui::RadioButton(kViews[i], panel.view == static_cast<int>(i))) shown.act({kView, static_cast<double>(i)});
  }
  ImGui::Separator();
  if (ImGui::Button("Screenshot")) shown.act({kScreenshot});
  ImGui::SameLine();
  if (ImGui::Button(panel.recording ? "End recording" : "Record camera")) shown.act({kRecord});
  if (ImGui::Button("Capture view")) shown.act({kHome});
  if (!panel.message.empty()) {
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 20);
    ImGui::TextUnformatted(panel.message.c_str());
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

} // namespace

void draw_panel(Shown& shown, const Panel& panel) {
  if (!panel.shown) return;
  draw_bar(shown, panel);
  draw_box(shown, panel);
}

} // namespace kinora::player::window
