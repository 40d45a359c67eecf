// A synthetic capture as if its depth camera had no noise, no holes and no range: with gt/depth_clean instead of
// depth/.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include <fmt/format.h>

#include "core/image_codec.h"
#include "ingest/capture/capture.h"
#include "ingest/depth/depth_cleaning.h"

namespace kinora::bench {

class TrueDepthCapture final : public ingest::Capture {
public:
  TrueDepthCapture(std::unique_ptr<ingest::Capture> measured, const std::filesystem::path& folder)
      : measured_(std::move(measured)), truth_(folder / "gt/depth_clean") {}

  const ingest::CaptureInfo& info() const override { return measured_->info(); }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return measured_->skipped(); }

  std::optional<ingest::Frame> next() override {
    std::optional<ingest::Frame> frame = measured_->next();
    if (!frame) return frame;
    const std::filesystem::path path = truth_ / fmt::format("{:06}.png", frame->index);
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    const DepthImage16 millimetres = decode_depth16(std::as_bytes(std::span(bytes)), path.string());
    std::ranges::transform(millimetres.values(), frame->depth.data(),
                           [](std::uint16_t depth) { return 0.001F * static_cast<float>(depth); });
    frame->clean_depth = ingest::clean_depth(frame->depth, frame->camera.intrinsics);
    return frame;
  }

private:
  std::unique_ptr<ingest::Capture> measured_;
  std::filesystem::path truth_;
};

} // namespace kinora::bench
