// A clip against the capture it was made from: how well each layer looks, in frames it was trained on and in others.
#pragma once

#include <nlohmann/json.hpp>

#include "core/progress.h"
#include "evaluate/moving_pixels.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "player/player.h"

namespace kinora::evaluate {

struct EvaluateOptions {
  int max_trained_frames =
      0; ///< at most this many, evenly spread over the clip; 0: all. Held-out ones all are compared.
  bool ground_truth =
      false; ///< also compare with what stands beside the capture (ground_truth_comparison.h), under `ground_truth`
  std::string format;           ///< name of the format to read the capture with; empty: whoever recognises it
  host::Options format_options; ///< of that format
};

/// Draws the clip as the capture camera saw it and compares frame by frame (core/metrics.h): per image, then averaged.
///
/// The report: `schema` ("kinora.evaluation/1"), `layers`: per layer `name`, `region` (in words) and the groups
/// `held_out` and `trained`, each with `frames` and the means of
/// - `psnr`, `mae`: over the region, the layer drawn alone and composited on black. The region is the layer's label;
///   for the background, and for everything in a capture without masks, only pixels with measured depth;
/// - `coverage`: mean opacity of what is drawn over the region;
/// - `psnr_box ssim_box mae_box psnr_full ssim_full psnr_inside iou`: as the metrics define them;
/// - `depth_error_median`: metres, |drawn − measured| over the region's measured pixels, an undrawn one counting as
///   infinitely wrong (null if most are); `depth_coverage`: the share of them that is drawn;
/// and `trained_minus_held_out_db`, of `psnr`. `whole` is the same for all layers drawn together, where masks tell
/// which pixels are modelled; `picture` over every pixel, with nothing drawn counting as black, and with it how many
/// pixels what is drawn lies beside what is true (`shift_median`, `shift_95`: picture_shift.h); `foreground` for the
/// labelled layers against everything that is labelled. Without masks there are no layers to tell apart if the clip has
/// several; a still camera's capture then has `moving` and `still`, all layers over the pixels of each kind (`moving`,
/// if not null). Throws Error(kUsage) if the capture is not the clip's.
nlohmann::json evaluate(const player::Player& player, ingest::Capture& capture, const MovingPixels* moving,
                        const EvaluateOptions& options, Progress& progress);

/// Opens the capture, with its masks if it has some and with colour and depth registered as when the clip was made,
/// tells moving pixels from still ones if it has none, and evaluates.
nlohmann::json evaluate_against(const std::filesystem::path& capture, const host::PluginTable& plugins,
                                const player::Player& player, const EvaluateOptions& options, Progress& progress);

} // namespace kinora::evaluate
