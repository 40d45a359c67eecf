#include "ingest/frame/reduced_view.h"
#include "ingest/images/plane_finder.h"
#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {
namespace {

class PlaneSegmenter final : public Segmenter {
public:
  void prepare(const CaptureFactory& /*open*/, const FrameRange& /*range*/, Progress& /*progress*/) override {}

  void label(Frame& frame) override {
    const ReducedView view = reduced_view(frame, reduction_factor(frame.depth.width()));
    PlaneSearch search;
    search.min_extent = search.wide;
    const std::vector<Plane> planes = find_planes(view.depth, view.intrinsics, search);
    frame.labels = LabelImage(frame.depth.width(), frame.depth.height());
    for (int v = 0; v < frame.depth.height(); ++v) {
      for (int u = 0; u < frame.depth.width(); ++u) {
        const double z = frame.depth.at(u, v);
        if (!(z > 0)) continue;
        const Eigen::Vector3d point = frame.camera.intrinsics.unproject(u, v, z);
        const bool on_plane = std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) {
          return std::abs(plane.distance(point)) <= same_surface_tolerance(z);
        });
        frame.labels.at(u, v) = on_plane ? 0 : 1;
      }
    }
  }

  const std::map<int, LabelInfo>& labels() const override { return labels_; }

private:
  std::map<int, LabelInfo> labels_{{0, {"background", "still", "planes"}},
                                   {1, {"rest", "deforming", "what lies on no plane"}}};
};

} // namespace

std::unique_ptr<Segmenter> make_plane_segmenter() { return std::make_unique<PlaneSegmenter>(); }

} // namespace kinora::ingest
