// Pictures of one stream, decoded by libavcodec.
#pragma once

#include <filesystem>
#include <string>

#include "common/video_file.h"
#include "video/libav_input.h"

struct SwsContext;

namespace kinora::formats {

/// See VideoReader.
class LibavVideoReader : public VideoReader {
public:
  /// Throws Error: kCorruptInput, kMissingComponent without a decoder.
  LibavVideoReader(const std::filesystem::path& path, VideoStream stream);
  VideoPicture read(std::size_t number) override;

private:
  struct ReleaseScaler {
    void operator()(SwsContext* scaler) const;
  };

  void open();
  void open_decoder();
  void go_to(std::size_t number);
  bool next_packet();
  bool next_frame();
  VideoPicture read_jpeg(std::size_t number);
  VideoPicture picture_of(const AVFrame& frame);
  [[noreturn]] void fail(const std::string& problem) const;
  [[noreturn]] void fail_at(std::size_t number) const;

  std::filesystem::path path_;
  VideoStream stream_;
  libav::Input input_;
  libav::Codec decoder_; ///< none for Motion JPEG that is not turned
  libav::Packet packet_;
  libav::Frame frame_;
  std::unique_ptr<SwsContext, ReleaseScaler> scaler_;
  std::size_t next_ = 0;
  bool picture_waits_ = false; ///< in frame_, or as JPEG in packet_, and is not asked for yet
  bool drained_ = false;       ///< the decoder was told that there are no more packets
};

} // namespace kinora::formats
