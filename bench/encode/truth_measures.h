// A clip of a synthetic capture against what is known of it: every tenth frame held out, the truth's other cameras,
// tracks.
#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <vector>

#include "evaluate/evaluate.h"
#include "host/plugin_table.h"

namespace kinora::bench {

inline double mean(const std::vector<double>& values) {
  return values.empty() ? std::nan("")
                        : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Of everything that is labelled; one value for each clip, or for each of its cameras.
struct TruthMeasures {
  std::vector<double> held_out;     ///< PSNR over its box, frames that were not trained on
  std::vector<double> novel_box;    ///< the same from other cameras
  std::vector<double> novel_inside; ///< within the silhouette
  std::vector<double> points;       ///< error of seen points, mm

  void add(const std::filesystem::path& capture, clip::Clip clip, Progress& progress) {
    evaluate::EvaluateOptions options;
    options.max_trained_frames = 1;
    options.ground_truth = true;
    const player::Player player(std::move(clip));
    const nlohmann::json report =
        evaluate::evaluate_against(capture, host::PluginTable::builtin(), player, options, progress);
    held_out.push_back(report.at("foreground").at("held_out").at("psnr_box"));
    for (const nlohmann::json& camera : report.at("ground_truth").at("novel_cameras")) {
      for (const nlohmann::json& layer : camera.at("layers")) {
        if (layer.at("name") != "foreground") continue;
        novel_box.push_back(layer.at("psnr_box"));
        novel_inside.push_back(layer.at("psnr_inside"));
      }
    }
    const nlohmann::json& tracks = report.at("ground_truth").at("tracks");
    if (!tracks.is_null()) points.push_back(1000 * tracks.at("visible").at("error_m_mean").get<double>());
  }

  /// A row of a table in Markdown, with the means.
  void print(const char* name) const {
    std::printf("| %s | %.2f | %.2f | %.2f | %.1f |\n", name, mean(held_out), mean(novel_box), mean(novel_inside),
                mean(points));
    std::fflush(stdout);
  }
};

} // namespace kinora::bench
