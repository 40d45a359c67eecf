// What an ONNX file says that its network takes, which OpenCV does not tell.
// Sources: onnx.proto of ONNX (ModelProto, GraphProto, ValueInfoProto); Protocol Buffers' encoding.
#pragma once

#include <optional>
#include <string_view>

namespace kinora::ingest {

struct PictureSize {
  int width = 0, height = 0;
};

/// The first input of 1 × 3 × height × width (or of any count of such pictures) whose sides the file gives; nothing if
/// there is none. Safe for untrusted input.
std::optional<PictureSize> onnx_picture_input(std::string_view file);

} // namespace kinora::ingest
