#include "encode/setting_list.h"

#include <algorithm>

#include "core/edit_distance.h"
#include "core/error.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

constexpr const char* kHowToList = "kinora encode --help-settings lists all of them";

std::vector<std::string_view> names_in(std::string_view path) {
  std::vector<std::string_view> names;
  for (;;) {
    const std::size_t dot = path.find('.');
    names.push_back(path.substr(0, dot));
    if (dot == std::string_view::npos) return names;
    path.remove_prefix(dot + 1);
  }
}

// Whether `wanted` is `path` with names left out before the last.
bool abbreviates(std::string_view wanted, std::string_view path) {
  const auto some = names_in(wanted);
  const auto all = names_in(path);
  if (some.back() != all.back()) return false;
  std::size_t found = 0;
  for (const std::string_view name : all) found += found < some.size() && some[found] == name ? 1 : 0;
  return found == some.size();
}

// How much of each name has to be typed otherwise; of the last one, which names the setting, in the path's last place.
std::size_t unlikeness(std::string_view wanted, std::string_view path) {
  if (path.starts_with(std::string(wanted) + '.')) return 0; // a struct of several
  const auto some = names_in(wanted);
  const auto all = names_in(path);
  std::size_t sum = 2 * edit_distance(some.back(), all.back());
  for (std::size_t i = 0; i + 1 < some.size(); ++i) {
    std::size_t least = some[i].size();
    for (const std::string_view name : all) least = std::min(least, edit_distance(some[i], name));
    sum += least;
  }
  return sum;
}

std::string nearest_to(const std::string& wanted, const std::vector<Setting>& settings) {
  constexpr std::size_t kShown = 3;
  std::vector<std::pair<std::size_t, std::string>> ranked;
  ranked.reserve(settings.size());
  for (const Setting& setting : settings) ranked.emplace_back(unlikeness(wanted, setting.path), setting.path);
  const auto shown = static_cast<std::ptrdiff_t>(std::min(kShown, ranked.size()));
  std::partial_sort(ranked.begin(), ranked.begin() + shown, ranked.end());
  std::string text;
  for (auto it = ranked.begin(); it != ranked.begin() + shown; ++it) text += (text.empty() ? "" : ", ") + it->second;
  return text;
}

// As JSON, or as text if it is none. Commas stand between several values.
Json value_of(const std::string& text) {
  for (const std::string& form : {text, '[' + text + ']'}) {
    if (Json json = Json::parse(form, nullptr, false); !json.is_discarded()) return json;
  }
  return text;
}

} // namespace

std::string words_of_enumerator(std::string_view name) {
  std::string words;
  for (const char c : name.substr(name.starts_with('k') ? 1 : 0)) {
    const bool is_capital = c >= 'A' && c <= 'Z';
    if (is_capital && !words.empty()) words += '_';
    words += is_capital ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return words;
}

Json SettingList::json() const {
  Json out = Json::object();
  for (const Setting& setting : settings_) {
    Json* at = &out;
    for (const std::string_view name : names_in(setting.path)) at = &(*at)[std::string(name)];
    *at = setting.get();
  }
  return out;
}

const Setting& SettingList::find(const std::string& path) const {
  std::vector<const Setting*> meant;
  for (const Setting& setting : settings_) {
    if (setting.path == path) return setting;
    if (abbreviates(path, setting.path)) meant.push_back(&setting);
  }
  if (meant.size() == 1) return *meant.front();
  if (meant.empty()) {
    throw Error(ErrorCode::kUsage, fmt::format("there is no setting \"{}\"; the nearest are {}; {}", path,
                                               nearest_to(path, settings_), kHowToList));
  }
  throw Error(ErrorCode::kUsage,
              fmt::format("\"{}\" may mean {} or {}; write more of the path", path, meant[0]->path, meant[1]->path));
}

void SettingList::change(const std::string& assignment) const {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) {
    throw Error(ErrorCode::kUsage, fmt::format("\"{}\" changes no setting: write its path, \"=\" and a value; {}",
                                               assignment, kHowToList));
  }
  const Setting& setting = find(assignment.substr(0, equals));
  const std::string value = assignment.substr(equals + 1);
  if (setting.set(value_of(value)) || setting.set(value)) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("the setting {} is {}, not \"{}\"; {}", setting.path, setting.type, value, kHowToList));
}

std::string SettingList::text() const {
  std::size_t width = 0;
  for (const Setting& setting : settings_) width = std::max(width, setting.path.size());
  std::string text;
  for (const Setting& setting : settings_) {
    text += fmt::format("  {:<{}}  {:<10}  {}\n", setting.path, width, setting.get().dump(), setting.type);
  }
  return text;
}

} // namespace kinora::encode
