#include "common/usd_layer.h"

#include "common/number_text.h"

namespace kinora::formats {
namespace {

constexpr int kDecimals = 3; ///< of times and rates

void append_setting(std::string& text, const char* name, double value) {
  text.append("    ").append(name).append(" = ");
  append_number(text, value, kDecimals);
  text += "\n";
}

} // namespace

std::string usd_quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string usd_time_code(double seconds, double rate) {
  std::string text;
  append_number(text, seconds * rate, kDecimals);
  return text;
}

std::string usd_layer_head(const UsdLayer& layer) {
  std::string text = "#usda 1.0\n(\n";
  if (!layer.facts.empty()) {
    text += "    customLayerData = {\n";
    for (const auto& [name, value] : layer.facts) text += "        string " + name + " = " + usd_quoted(value) + "\n";
    text += "    }\n";
  }
  text += "    defaultPrim = \"clip\"\n    doc = \"Kinora: colours as the camera saw them\"\n";
  append_setting(text, "metersPerUnit", 1 / layer.axes.per_metre);
  text.append("    upAxis = ").append(layer.axes.z_up ? "\"Z\"" : "\"Y\"");
  text.append("\n    startTimeCode = 0\n    endTimeCode = ");
  text.append(usd_time_code(layer.last_time, layer.rate)).append("\n");
  append_setting(text, "timeCodesPerSecond", layer.rate);
  append_setting(text, "framesPerSecond", layer.rate);
  text += ")\n\n";
  return text;
}

} // namespace kinora::formats
