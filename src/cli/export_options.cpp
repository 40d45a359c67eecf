#include "cli/export_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "host/plugin_table.h"

namespace kinora::cli {
namespace {

constexpr int kTexturePixels = 2048;      ///< per side and layer, at most
constexpr double kSimplification = 0.002; ///< metres that a textured surface may be off
constexpr double kStillSimplification = 0.005;
constexpr double kFlatSimplification = 0.025;
constexpr double kMaxRate = 1000; ///< frames per second

struct ExportOption {
  KinoraOption option;
  std::uint64_t needs;    ///< one of these capabilities
  std::uint64_t also = 0; ///< and all of these
};

constexpr std::uint64_t kMeshes = KINORA_WRITES_MESHES;
constexpr std::uint64_t kAny = KINORA_WRITES_MESHES | KINORA_WRITES_VOLUMES;

constexpr ExportOption kOptions[] = {
    {{"layers", "text", "", "Only these layers, by their names with commas between; nothing: all.", nullptr}, kAny},
    {{"fps", "number", "0",
      "So many files or keys per second: of the frames those nearest in time; 0: one for each frame.", nullptr},
     kAny},
    {{"origin", "text", "0,0,0",
      "This point becomes the origin: metres to the right of the first camera, above and behind it.", nullptr},
     kAny},
    {{"triangles", "int", "200000", "So many triangles per layer, before flat parts are simplified.", nullptr},
     kMeshes},
    {{"resolution", "int", "0", "Cells per side of a layer's box instead; 0: as triangles ask.", nullptr}, kMeshes},
    {{"error", "number", "0.002", "Metres by which a surface may be off, for fewer triangles where it is flat.",
      nullptr},
     kMeshes,
     KINORA_WRITES_TEXTURES},
    {{"error", "number", "0", "Metres by which a surface may be off, for fewer triangles where it is flat.", nullptr},
     kMeshes},
    {{"still-error", "number", "0.005", "The same for layers that do not move, such as rooms.", nullptr},
     kMeshes,
     KINORA_WRITES_TEXTURES},
    {{"still-error", "number", "0", "The same for layers that do not move, such as rooms.", nullptr}, kMeshes},
    {{"flat-error", "number", "0.025", "The same for those that are flat as a whole besides: floors.", nullptr},
     kMeshes,
     KINORA_WRITES_TEXTURES},
    {{"flat-error", "number", "0", "The same for those that are flat as a whole besides: floors.", nullptr}, kMeshes},
    {{"texture", "int", "2048", "Pixels per side of a layer's texture at most; 0: colours in the vertices.", nullptr},
     kMeshes,
     KINORA_WRITES_TEXTURES},
    {{"voxel", "number", "0.01", "Side of a voxel in metres.", nullptr}, KINORA_WRITES_VOLUMES},
    {{"index", "bool", "false", "One more file that shows the others in turn: of OpenVDB NAME.usda, a USD Volume.",
      nullptr},
     KINORA_WRITES_VOLUME_INDEX}};

bool is_among(const char* name, std::span<const KinoraOption> options) {
  return std::ranges::any_of(options, [&](const KinoraOption& o) { return std::string_view(o.name) == name; });
}

template <class Number> Number number_of(const std::string& name, const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && value >= Number{0} &&
      std::isfinite(static_cast<double>(value)))
    return value;
  throw Error(ErrorCode::kUsage, fmt::format("-O {}={}: the value must be a number that is not negative", name, text));
}

bool flag_of(const std::string& name, const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  throw Error(ErrorCode::kUsage, fmt::format("-O {}={}: the value must be true or false", name, text));
}

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

clip::LayerChoice layers_called(const clip::Clip& clip, const std::string& names, Context& context) {
  if (names.empty()) return clip::all_layers(clip);
  clip::LayerChoice chosen = clip::choose_layers(clip, split_at_commas(names), context.progress);
  if (!chosen.empty()) return chosen;
  throw Error(ErrorCode::kUsage, fmt::format("-O layers={}: the clip has none of these layers; it has: {}", names,
                                             clip::layer_names(clip)));
}

/// In Kinora's axes.
Eigen::Vector3d point_of(const std::string& text) {
  const std::vector<std::string> parts = split_at_commas(text);
  std::vector<double> numbers;
  for (const std::string& part : parts) {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error == std::errc{} && end == part.data() + part.size() && std::isfinite(value)) numbers.push_back(value);
  }
  if (parts.size() != 3 || numbers.size() != 3)
    throw Error(ErrorCode::kUsage,
                fmt::format("-O origin={}: give three numbers with commas between, such as 0,-1.2,-2", text));
  return {numbers[0], -numbers[1], -numbers[2]};
}

/// Of `frames` those nearest to times that follow one another at `rate` from the first one on: one that is nearest to
/// several comes as often if `repeat`.
std::vector<int> frames_at_rate(const std::vector<double>& times, const std::vector<int>& frames, double rate,
                                bool repeat) {
  if (!(rate <= kMaxRate)) throw Error(ErrorCode::kUsage, fmt::format("-O fps={:g}: at most {:g}", rate, kMaxRate));
  const auto time = [&](std::size_t i) { return times[static_cast<std::size_t>(frames[i])]; };
  constexpr double kHalf = 0.5 - 1e-6; // half a step, less what times are rounded by
  std::vector<int> chosen;
  std::size_t at = 0;
  for (std::size_t tick = 0;; ++tick) {
    const double now = time(0) + static_cast<double>(tick) / rate;
    if (now >= time(frames.size() - 1) + kHalf / rate) return chosen;
    while (at + 1 < frames.size() && std::abs(time(at + 1) - now) <= std::abs(time(at) - now)) ++at;
    if (repeat || chosen.empty() || chosen.back() != frames[at]) chosen.push_back(frames[at]);
  }
}

} // namespace

std::vector<KinoraOption> export_options(const KinoraFormat& format) {
  std::vector<KinoraOption> options;
  const std::span<const KinoraOption> declared(format.options, format.option_count);
  for (const ExportOption& one : kOptions) {
    if ((format.capabilities & one.needs) == 0 || !host::supports(format, one.also)) continue;
    if (!is_among(one.option.name, declared) && !is_among(one.option.name, options)) options.push_back(one.option);
  }
  return options;
}

void apply_options(host::Options given, Conversion& conversion, Context& context) {
  const std::vector<KinoraOption> options = export_options(*conversion.format);
  std::vector<std::string> names;
  host::Options taken;
  for (const KinoraOption& option : options) {
    names.emplace_back(option.name);
    if (auto entry = given.extract(option.name)) taken.insert(std::move(entry));
  }
  host::check_options(*conversion.format, given, names);
  conversion.format_options = std::move(given);
  const auto text = [&](const char* name) {
    const auto found = taken.find(name);
    return found == taken.end() ? std::string() : found->second;
  };
  const auto take = [&](const char* name, auto& value) {
    if (const std::string word = text(name); !word.empty())
      value = number_of<std::remove_cvref_t<decltype(value)>>(name, word);
  };
  conversion.layers = layers_called(*conversion.clip, text("layers"), context);
  if (is_among("texture", options)) {
    conversion.surface.texture = kTexturePixels;
    conversion.surface.simplification = kSimplification;
    conversion.surface.still_simplification = kStillSimplification;
    conversion.surface.flat_simplification = kFlatSimplification;
  }
  take("triangles", conversion.surface.triangles);
  take("resolution", conversion.surface.resolution);
  take("texture", conversion.surface.texture);
  if (conversion.surface.texture == 0) // colours need the vertices
    conversion.surface.simplification = conversion.surface.still_simplification =
        conversion.surface.flat_simplification = 0;
  take("error", conversion.surface.simplification);
  take("still-error", conversion.surface.still_simplification);
  take("flat-error", conversion.surface.flat_simplification);
  take("voxel", conversion.volume.voxel);
  if (const std::string index = text("index"); !index.empty()) conversion.index = flag_of("index", index);
  if (const std::string origin = text("origin"); !origin.empty()) conversion.origin = point_of(origin);
  take("fps", conversion.fps);
  if (conversion.fps > 0)
    conversion.frames =
        frames_at_rate(conversion.clip->times, conversion.frames, conversion.fps, !is_one_file(*conversion.format));
}

} // namespace kinora::cli
