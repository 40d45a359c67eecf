#include "ingest/images/optical_flow.h"

#include <cmath>

#include "ingest/opencv/opencv_functions.h"

namespace kinora::ingest {

Image<float> optical_flow(const ColorImage& to, const ColorImage& from) {
  return opencv_functions().optical_flow(to, from);
}

Pixel origin_of(const Image<float>& flow, int u, int v) {
  return {static_cast<int>(std::lround(static_cast<float>(u) + flow.at(u, v, 0))),
          static_cast<int>(std::lround(static_cast<float>(v) + flow.at(u, v, 1)))};
}

} // namespace kinora::ingest
