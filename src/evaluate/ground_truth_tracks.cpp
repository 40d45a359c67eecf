#include "evaluate/ground_truth_tracks.h"

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include <zlib.h>

#include "core/error.h"

namespace kinora::evaluate {
namespace {

/// What a file of `file_bytes` may unpack to: such lists shrink to a third.
std::size_t max_text_bytes(std::size_t file_bytes) { return (std::size_t{8} << 20U) + 32 * file_bytes; }

} // namespace

GroundTruthTracks read_ground_truth_tracks(const std::filesystem::path& capture) {
  const std::filesystem::path path = capture / "gt" / "tracks.csv.gz";
  GroundTruthTracks tracks;
  if (!std::filesystem::exists(path)) return tracks;
  const auto fail = [&](const std::string& problem) {
    throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
  };
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (!file) fail("cannot be opened");
  const std::size_t max_bytes = max_text_bytes(std::filesystem::file_size(path));
  std::array<char, 256> line{};
  for (int number = 1; gzgets(file.get(), line.data(), static_cast<int>(line.size())) != nullptr; ++number) {
    if (static_cast<std::size_t>(gztell(file.get())) > max_bytes) fail("unpacks to far more than lists of tracks do");
    if (number == 1) continue; // the header
    int frame = 0;
    int id = 0;
    int visible = 0;
    TruePosition position{};
    Eigen::Vector3d& p = position.point;
    if (std::sscanf(line.data(), "%d,%d,%lf,%lf,%lf,%d", &frame, &id, &p.x(), &p.y(), &p.z(), &visible) != 6 ||
        !p.allFinite()) {
      fail("line " + std::to_string(number) + " must hold frame,id,x,y,z,visible");
    }
    position.visible = visible != 0;
    tracks[id][frame] = position;
  }
  int error = Z_OK;
  if (const char* text = gzerror(file.get(), &error); error != Z_OK && error != Z_STREAM_END) fail(text);
  return tracks;
}

} // namespace kinora::evaluate
