// kinora track: where material points are at every frame of a clip.
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "bake/nearest_layer.h"
#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/output_file.h"
#include "cli/point_file.h"
#include "core/error.h"
#include "motion/point_track.h"

namespace kinora::cli {
namespace {

struct Options {
  std::filesystem::path clip;
  std::filesystem::path points;
  std::filesystem::path out;
  int frame = 0;
};

/// Per point, its place at every frame.
using Tracks = std::vector<std::vector<Eigen::Vector3d>>;

Tracks track_all(const clip::Clip& clip, int frame, std::span<const Eigen::Vector3d> points,
                 std::span<const std::optional<std::size_t>> layers) {
  std::map<std::optional<std::size_t>, std::vector<std::size_t>> points_of;
  for (std::size_t i = 0; i < points.size(); ++i) points_of[layers[i]].push_back(i);
  Tracks tracks(points.size());
  for (const auto& [layer, indices] : points_of) {
    // Without any surface there is nothing that could carry the point: it stays.
    const motion::Motion motion = layer ? clip.layers[*layer].motion : motion::Motion::still();
    std::vector<Eigen::Vector3d> layer_points;
    for (const std::size_t i : indices) layer_points.push_back(points[i]);
    Tracks layer_tracks =
        motion::track_points(motion, clip.times.size(), static_cast<std::size_t>(frame), layer_points);
    for (std::size_t k = 0; k < indices.size(); ++k) tracks[indices[k]] = std::move(layer_tracks[k]);
  }
  return tracks;
}

std::string csv_of(const std::vector<NamedPoint>& points, const Tracks& tracks, std::size_t frames) {
  std::string text = "frame,id,x,y,z\n";
  for (std::size_t frame = 0; frame < frames; ++frame) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d& p = tracks[i][frame];
      text += fmt::format("{},{},{:.6f},{:.6f},{:.6f}\n", frame, points[i].id, p.x(), p.y(), p.z());
    }
  }
  return text;
}

nlohmann::json summary_of(const clip::Clip& clip, std::span<const std::optional<std::size_t>> layers) {
  nlohmann::json counts = nlohmann::json::object();
  for (const clip::Layer& layer : clip.layers) counts[layer.name] = 0;
  for (const auto& layer : layers) {
    if (layer) counts[clip.layers[*layer].name] = counts[clip.layers[*layer].name].get<int>() + 1;
  }
  return counts;
}

void run(const Options& options, Context& context) {
  OutputFile out(options.out, context.shared.overwrite, {options.clip, options.points});
  require_input(options.points);
  const std::vector<NamedPoint> points = read_points(options.points);
  const clip::Clip clip = open_clip(options.clip, context.progress);
  const std::size_t count = clip.times.size();
  if (options.frame < 0 || static_cast<std::size_t>(options.frame) >= count) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--frame {}: the clip has frames 0 to {}; give one of them", options.frame, count - 1));
  }
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(points.size());
  for (const NamedPoint& point : points) positions.push_back(point.position);
  context.progress.stage("finding the points' layers", 0);
  const auto layers = bake::nearest_layers(clip, options.frame, positions, context.progress);
  context.progress.stage("tracking", 0);
  const Tracks tracks = track_all(clip, options.frame, positions, layers);
  write_text(out, csv_of(points, tracks, count));
  const nlohmann::json by_layer = summary_of(clip, layers);
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.track/1"},
                        {"output", options.out.string()},
                        {"points", points.size()},
                        {"frames", count},
                        {"points_of_layer", by_layer}});
    return;
  }
  std::string text = fmt::format("{}: {} points over {} frames (", options.out.string(), points.size(), count);
  const char* separator = "";
  for (const auto& [name, number] : by_layer.items()) {
    text += fmt::format("{}{} of {}", separator, number.get<int>(), name);
    separator = ", ";
  }
  context.print(text + ")\n");
}

} // namespace

void add_track(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "track", "Follow points of the scene through all frames",
                                          "  kinora track clip.mkv --points points.csv --frame 0 --out tracks.csv",
                                          [options, &context] { run(*options, context); });
  command.add_option("CLIP", options->clip, "The clip to read")->required()->type_name("FILE");
  command.add_option("--points", options->points, "CSV of points in the world, metres: id,x,y,z")
      ->required()
      ->type_name("FILE");
  command.add_option("--frame", options->frame, "The frame, from 0, at which the points are there")
      ->required()
      ->type_name("N");
  command.add_option("--out", options->out, "The CSV to write: frame,id,x,y,z for every frame and point")
      ->required()
      ->type_name("FILE");
  context.add_overwrite(command);
}

} // namespace kinora::cli
