// In place of network_segmenter.cpp where OpenCV's dnn is not installed.
#include "core/error.h"
#include "ingest/network_segmenter.h"

namespace kinora::ingest {

std::unique_ptr<Segmenter> make_network_segmenter(const std::filesystem::path& network) {
  throw Error(ErrorCode::kMissingComponent, network.string() +
                                                ": networks cannot be run, for Kinora was built without OpenCV's dnn; "
                                                "install libopencv-dnn-dev and build it again");
}

} // namespace kinora::ingest
