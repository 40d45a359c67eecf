#include "cli/quality_text.h"

#include <fmt/format.h>

#include "cli/text.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

std::string number(const Json& group, const char* key, const char* format, double scale = 1) {
  const auto found = group.find(key);
  if (found == group.end() || !found->is_number()) return "-";
  return fmt::format(fmt::runtime(format), found->get<double>() * scale);
}

void add_rows(const Json& subject, Table& table) {
  for (const char* group : {"held_out", "trained"}) {
    const Json& means = subject.at(group);
    if (means.at("frames") == 0) continue;
    table.add({subject.at("name"), group == std::string("held_out") ? "held out" : "trained", means.at("frames").dump(),
               number(means, "psnr", "{:.2f}"), number(means, "ssim_box", "{:.3f}"), number(means, "mae", "{:.2f}"),
               number(means, "iou", "{:.3f}"), number(means, "coverage", "{:.1f}", 100),
               number(means, "depth_error_median", "{:.1f}", 1000)});
  }
}

std::string truth_text(const Json& truth) {
  std::string text;
  if (const Json& pose = truth.at("object_pose"); pose.is_object()) {
    text += fmt::format("Pose of {} against the truth: {} mm and {} degrees on average\n",
                        pose.at("layer").get<std::string>(), number(pose, "error_m_mean", "{:.2f}", 1000),
                        number(pose, "error_degrees_mean", "{:.2f}"));
  }
  if (const Json& tracks = truth.at("tracks"); tracks.is_object()) {
    const Json& visible = tracks.at("visible");
    text += fmt::format("Points of {} that are seen, against the truth: {} mm on average, 95 % within {} mm, {} of {} "
                        "places missing\n",
                        tracks.at("layer").get<std::string>(), number(visible, "error_m_mean", "{:.1f}", 1000),
                        number(visible, "error_m_p95", "{:.1f}", 1000), visible.at("missing").dump(),
                        visible.at("places").dump());
  }
  Table table({"camera", "layer", "n", "PSNR dB", "SSIM box", "MAE", "IoU", "depth error mm"});
  for (const Json& camera : truth.at("novel_cameras")) {
    for (const Json& means : camera.at("layers")) {
      table.add({camera.at("name"), means.at("name"), means.at("frames").dump(), number(means, "psnr", "{:.2f}"),
                 number(means, "ssim_box", "{:.3f}"), number(means, "mae", "{:.2f}"), number(means, "iou", "{:.3f}"),
                 number(means, "depth_error_median", "{:.1f}", 1000)});
    }
  }
  return truth.at("novel_cameras").empty() ? text : text + table.str();
}

} // namespace

std::string quality_table(const Json& evaluation) {
  Table table({"layer", "frames", "n", "PSNR dB", "SSIM box", "MAE", "IoU", "drawn %", "depth error mm"});
  for (const Json& layer : evaluation.at("layers")) add_rows(layer, table);
  for (const char* name : {"whole", "picture", "foreground", "moving", "still"}) {
    if (evaluation.contains(name)) add_rows(evaluation.at(name), table);
  }
  std::string text = table.str();
  if (evaluation.contains("ground_truth")) text += truth_text(evaluation.at("ground_truth"));
  return text;
}

} // namespace kinora::cli
