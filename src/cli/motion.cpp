// kinora motion: where every layer is at every frame, as JSON.
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/output_file.h"
#include "motion/first_frame.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

struct Options {
  std::filesystem::path clip;
  std::filesystem::path out;
};

Json matrix_json(const SE3& transform) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) {
    rows.push_back({transform(r, 0), transform(r, 1), transform(r, 2), transform(r, 3)});
  }
  return rows;
}

// A clip keeps a node to a tenth of a millimetre and a thousandth of a radian: six decimals are all that it knows.
double rounded(double value) { return std::round(value * 1e6) / 1e6; }

Json nodes_json(const motion::Motion& motion, std::size_t frame) {
  const motion::Warp warp = motion.warp(static_cast<double>(frame));
  Json nodes = Json::array();
  for (std::size_t i = 0; i < warp.node_positions().size(); ++i) {
    const Eigen::Vector3d& p = warp.node_positions()[i];
    const Eigen::Quaterniond& q = motion.deformations()[frame].node_to_world[i].real;
    nodes.push_back({{"position", {rounded(p.x()), rounded(p.y()), rounded(p.z())}},
                     {"rotation", {rounded(q.w()), rounded(q.x()), rounded(q.y()), rounded(q.z())}}});
  }
  return nodes;
}

Json joints_json(const motion::JointPaths& joints, std::size_t frame) {
  Json result = Json::array();
  for (std::size_t j = 0; j < joints.names.size(); ++j) {
    const Eigen::Vector3d& p = joints.positions[frame][j];
    result.push_back({{"name", joints.names[j]}, {"position", {rounded(p.x()), rounded(p.y()), rounded(p.z())}}});
  }
  return result;
}

Json layer_json(const clip::Layer& layer, const clip::Clip& clip) {
  const std::size_t count = clip.times.size();
  const bool rigid = layer.motion.kind() == motion::MotionKind::kRigid;
  const double first = static_cast<double>(motion::first_frame_of(layer.motion, count));
  const SE3 world_to_canonical = rigid ? layer.motion.canonical_to_world(first).inverse() : SE3::Identity();
  Json frames = Json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const double frame = static_cast<double>(i);
    Json entry = {{"frame", i},
                  {"capture_frame", clip.capture_frames[i]},
                  {"time", clip.times[i]},
                  {"health", motion::name_of(layer.motion.health(i))}};
    if (rigid) entry["transform"] = matrix_json(layer.motion.canonical_to_world(frame) * world_to_canonical);
    if (layer.motion.graph()) entry["nodes"] = nodes_json(layer.motion, i);
    if (layer.joints) entry["joints"] = joints_json(*layer.joints, i);
    if (clip.camera_to_world.size() > 1) {
      entry["camera_to_world"] = matrix_json(clip.capture_camera(frame).camera_to_world);
    }
    frames.push_back(std::move(entry));
  }
  Json out = {{"name", layer.name}, {"kind", motion::name_of(layer.motion.kind())}, {"frames", std::move(frames)}};
  if (!layer.births.are_at_the_start()) out["births"] = layer.births.frames();
  for (const motion::FrameSpan& span : layer.presence.away()) out["away"].push_back({span.begin, span.end});
  return out;
}

void run(const Options& options, Context& context) {
  OutputFile out(options.out, context.shared.overwrite, {options.clip});
  const clip::Clip clip = open_clip(options.clip, context.progress);
  Json motion = {{"schema", "kinora.motion/1"}, {"fps", frames_per_second(clip)}, {"layers", Json::array()}};
  for (const clip::Layer& layer : clip.layers) motion["layers"].push_back(layer_json(layer, clip));
  write_text(out, motion.dump() + "\n");
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.written/1"}, {"output", options.out.string()}});
  } else {
    context.print(fmt::format("{}: motion of {} layers over {} frames\n", options.out.string(), clip.layers.size(),
                              clip.times.size()));
  }
}

} // namespace

void add_motion(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "motion", "Write where every layer is at every frame, as JSON",
                                          "  kinora motion clip.mkv --out motion.json",
                                          [options, &context] { run(*options, context); });
  command.add_option("CLIP", options->clip, "The clip to read")->required()->type_name("FILE");
  command.add_option("--out", options->out, "The JSON file to write")->required()->type_name("FILE");
  context.add_overwrite(command);
}

} // namespace kinora::cli
