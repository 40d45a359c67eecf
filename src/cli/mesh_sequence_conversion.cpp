#include <system_error>

#include <fmt/format.h>

#include "bake/born_parts.h"
#include "bake/posed_mesh.h"
#include "cli/conversion.h"
#include "cli/export_facts.h"
#include "cli/output_file.h"
#include "clip/shown_frames.h"
#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

/// A part of a layer that is there from one frame on.
struct Part {
  motion::Presence shown;
  host::Mesh mesh; ///< canonical
};

struct Surface {
  const clip::Layer* layer;
  std::size_t vertices, triangles; ///< of all parts
  std::vector<Part> parts;
};

std::vector<Surface> extract_surfaces(const Conversion& conversion, Context& context) {
  std::vector<Surface> surfaces;
  context.progress.stage("surfaces", conversion.layers.size());
  for (std::size_t i = 0; i < conversion.layers.size(); ++i) {
    const clip::Layer& layer = conversion.clip->layers[conversion.layers[i]];
    auto mesh = bake::extract_mesh(layer, conversion.surface, context.progress);
    context.progress.advance(i + 1, layer.name);
    if (!mesh) {
      report_no_surface(conversion, layer, context);
      continue;
    }
    report_lost_frames(conversion, layer, context);
    const std::size_t frames = conversion.clip->times.size();
    Surface& surface = surfaces.emplace_back(Surface{&layer, mesh->positions.size(), mesh->faces.size(), {}});
    for (bake::BornPart& part : bake::born_parts(*std::move(mesh), layer, frames + 1))
      surface.parts.push_back({clip::shown_frames(layer, frames, part.birth), std::move(part.mesh)});
  }
  if (surfaces.empty()) {
    throw Error(ErrorCode::kFailure, fmt::format("{}: no layer has a surface", conversion.input.string()));
  }
  return surfaces;
}

void write_frame(const Conversion& conversion, const std::vector<Surface>& surfaces, int frame, const fs::path& path) {
  host::Facts facts = facts_of(conversion);
  facts.emplace_back("frame", std::to_string(frame));
  host::MeshWriter writer(*conversion.format, path, conversion.format_options, facts);
  for (const Surface& surface : surfaces) {
    const motion::Warp warp = surface.layer->motion.warp(frame);
    for (const Part& part : surface.parts) {
      if (part.shown.at(frame)) writer.add(shifted(bake::posed_mesh(part.mesh, warp), -conversion.origin));
    }
  }
  writer.finish();
}

} // namespace

Json convert_to_mesh_sequence(const Conversion& conversion, Context& context) {
  check_numbered_outputs(conversion, context.shared.overwrite);
  const std::vector<Surface> surfaces = extract_surfaces(conversion, context);
  std::uintmax_t bytes = 0;
  context.progress.stage("writing", conversion.frames.size());
  for (std::size_t i = 0; i < conversion.frames.size(); ++i) {
    context.progress.check();
    const fs::path path = numbered_path(conversion.output, i);
    if (is_done(conversion, path)) continue;
    OutputFile out(path, context.shared.overwrite, {conversion.input});
    write_frame(conversion, surfaces, conversion.frames[i], out.writing_path());
    std::error_code ignored;
    if (out.can_be_read_back()) bytes += fs::file_size(out.writing_path(), ignored);
    out.commit();
    context.progress.advance(i + 1, "");
  }
  Json layers = Json::array();
  for (const Surface& surface : surfaces) {
    layers.push_back({{"name", surface.layer->name},
                      {"motion", motion::name_of(surface.layer->motion.kind())},
                      {"vertices", surface.vertices},
                      {"triangles", surface.triangles}});
  }
  return {{"layers", std::move(layers)}, {"files", conversion.frames.size()}, {"bytes", bytes}};
}

} // namespace kinora::cli
