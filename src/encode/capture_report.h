// What was read, and what was found out about the camera and the streams, as the encoder's report says it.
#pragma once

#include <nlohmann/json.hpp>

#include "clip/exposure.h"
#include "encode/camera_refinement.h"
#include "encode/capture_preparation.h"
#include "encode/frame_pass.h"

namespace kinora::encode {

/// Of a capture that was read to its end: its format and size, frames used, held out, without mask and skipped.
nlohmann::json capture_json(const PreparedCapture& prepared, const FramePass& pass);
/// Of the clip as a whole; layers and timeline bring their own.
nlohmann::json clip_metadata(const ingest::CaptureInfo& info, const nlohmann::json& config,
                             const nlohmann::json& settings);
/// Whether the camera moves, and why.
nlohmann::json camera_json(const PreparedCapture& prepared);
nlohmann::json refinement_json(const CameraRefinement& refinement);
/// Exposure, delay (seconds, if it could be told) and registration of colour and depth, as estimated.
nlohmann::json streams_json(const clip::Exposure& exposure, std::optional<double> depth_delay,
                            const ingest::FoundRegistration& registration);

} // namespace kinora::encode
