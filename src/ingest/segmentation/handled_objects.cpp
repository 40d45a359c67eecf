#include "ingest/segmentation/handled_objects.h"

#include "core/parallel.h"
#include "ingest/segmentation/flat_faces.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kMinSamples = 8;
constexpr double kSpeck = 0.0015; ///< square metres
constexpr std::size_t kSpeckPixels = 40;
constexpr double kMinArea = 0.002;     ///< square metres
constexpr double kMaxExtent = 0.8;     ///< metres across
constexpr double kMinBody = 0.5;       ///< metres across
constexpr double kRestDistance = 0.02; ///< metres that a thing at rest seems to move
constexpr double kThere = 0.05;        ///< metres from where it rests: the thing, perhaps pressed or tilted
constexpr double kRestShare = 0.1;     ///< of the samples
constexpr double kTouching = 0.1;      ///< metres: closer in depth, beside each other, two parts may be one body
constexpr double kFlatShare = 0.4;     ///< of the samples
constexpr double kMinFlatArea = 0.006; ///< square metres
constexpr float kDistinct = 0.5F;      ///< of the foreground that has a flat face's colours is the face itself
constexpr double kSameColor = 0.5;     ///< overlap of the colours of one thing at two times
constexpr int kBorder = 5;             ///< pixels around a thing that may be a part of it
constexpr double kMaxTruncated = 0.1;  ///< share of a thing's rim that may lie where nothing is ever measured
constexpr double kMinFill = 0.12;      ///< area over squared extent: less is a stripe
constexpr double kMinFlatShare = 0.4;  ///< share of flat faces of a thing that does not bend
constexpr double kMinPrior = -2;
constexpr double kPriorWeight = 0.6; ///< neighbouring pixels do not count as independent witnesses
constexpr std::size_t kMaxObjects = 8;

/// One sample taken apart.
struct SampleComponents {
  Mask foreground;
  SurfaceComponents parts;
  int body = -1; ///< number of the largest part, if it can be one
};

SampleComponents parts_of(const ReducedView& sample, const BackgroundMap& background) {
  SampleComponents result;
  result.foreground = foreground_mask(sample, LocalBackground(background, sample));
  result.parts = surface_components(sample.depth, result.foreground, sample.intrinsics);
  const int largest = result.parts.largest();
  if (largest >= 0 && result.parts.list[static_cast<std::size_t>(largest)].extent() >= kMinBody) result.body = largest;
  return result;
}

/// A surface that was seen alone at one place.
struct RestingObject {
  Eigen::Vector3d centroid; ///< world
  double first_area;
  std::vector<std::size_t> samples;
  std::vector<double> areas;
  double flat = 0; ///< square metres of flat faces, when first seen
  ColorCounts colors;
  Image<std::uint16_t> hits;
  RestingView first_view; ///< as the first of the samples sees it

  /// Calls use(ProjectedPoint) for all of it that lies in the view's picture, whatever hides it.
  template <class Use> void for_each_in(const ReducedView& view, const Use& use) const {
    const SE3 to_view = view.camera_to_world.inverse() * first_view.camera.camera_to_world;
    for (int v = 0; v < first_view.depth.height(); ++v) {
      for (int u = 0; u < first_view.depth.width(); ++u) {
        const float z = first_view.depth.at(u, v);
        if (!(z > 0)) continue;
        const auto seen = project_point(view.intrinsics, to_view * first_view.camera.intrinsics.unproject(u, v, z));
        if (seen) use(*seen);
      }
    }
  }
};

double flat_area(const ReducedView& view, const SurfaceComponents& parts, std::size_t number) {
  Mask mask(parts.map.width(), parts.map.height());
  for (std::size_t i = 0; i < mask.pixel_count(); ++i)
    mask.data()[i] = parts.map.data()[i] == static_cast<std::int32_t>(number) ? 1 : 0;
  const Mask faces = flat_faces(view.depth, mask, view.intrinsics);
  double area = 0;
  for (std::size_t i = 0; i < faces.pixel_count(); ++i)
    if (faces.data()[i] != 0) area += view.depth.data()[i] * view.depth.data()[i];
  return area / (view.intrinsics.fx * view.intrinsics.fy);
}

bool is_same_rest(const RestingObject& resting, const SurfaceComponent& part, const Eigen::Vector3d& centroid) {
  const double ratio = part.area / resting.first_area;
  return (centroid - resting.centroid).norm() < kRestDistance && ratio > 0.6 && ratio < 1.67;
}

/// True if a part is whole (not cut by the edge of what is measured) and nothing larger is close to it in space.
bool is_isolated(const ReducedView& view, const SurfaceComponents& parts, std::size_t number,
                 const LocalBackground& background) {
  const auto candidate = static_cast<std::int32_t>(number);
  int boundary = 0;
  int truncated = 0;
  for (int v = 0; v < parts.map.height(); ++v) {
    for (int u = 0; u < parts.map.width(); ++u) {
      if (parts.map.at(u, v) != candidate) continue;
      const float z = view.depth.at(u, v);
      for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        if (parts.map.contains(u + du, v + dv) && parts.map.at(u + du, v + dv) == candidate) continue;
        ++boundary;
        const int x = u + 3 * du;
        const int y = v + 3 * dv;
        if (!parts.map.contains(x, y) || !background.ever_measured(view.intrinsics.unproject(x, y, z))) ++truncated;
        for (int step = 1; step <= kBorder && parts.map.contains(u + step * du, v + step * dv); ++step) {
          const std::int32_t other = parts.map.at(u + step * du, v + step * dv);
          if (other < 0 || other == candidate ||
              parts.list[static_cast<std::size_t>(other)].area < parts.list[number].area)
            continue;
          if (std::abs(view.depth.at(u + step * du, v + step * dv) - z) < kTouching) return false;
        }
      }
    }
  }
  return truncated < kMaxTruncated * boundary;
}

/// Marks where a part of a sample lies, in the picture of the place where the thing was first seen.
void add_observation(const ReducedView& sample, const SurfaceComponents& surfaces, std::size_t number,
                     RestingObject& resting) {
  const SE3 to_first_view = resting.first_view.camera.camera_to_world.inverse() * sample.camera_to_world;
  for (int v = 0; v < surfaces.map.height(); ++v) {
    for (int u = 0; u < surfaces.map.width(); ++u) {
      if (surfaces.map.at(u, v) != static_cast<std::int32_t>(number)) continue;
      resting.colors.add(sample.color.pixel(u, v));
      const Eigen::Vector3d point = to_first_view * sample.intrinsics.unproject(u, v, sample.depth.at(u, v));
      const auto seen = project_point(resting.first_view.camera.intrinsics, point);
      if (!seen) continue;
      ++resting.hits.at(seen->u, seen->v);
      resting.first_view.depth.at(seen->u, seen->v) = static_cast<float>(seen->z);
    }
  }
}

std::vector<RestingObject> find_resting(std::span<const ReducedView> samples, std::span<const SampleComponents> parts,
                                        const BackgroundMap& background) {
  std::vector<RestingObject> all;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const SurfaceComponents& surfaces = parts[k].parts;
    const LocalBackground local_background(background, samples[k]);
    for (std::size_t n = 0; n < surfaces.list.size(); ++n) {
      const SurfaceComponent& part = surfaces.list[n];
      if (static_cast<int>(n) == parts[k].body || part.area < kMinArea || part.extent() > kMaxExtent ||
          part.area < kMinFill * part.extent() * part.extent() ||
          !is_isolated(samples[k], surfaces, n, local_background))
        continue;
      const Eigen::Vector3d centroid = samples[k].camera_to_world * part.centroid;
      auto found =
          std::find_if(all.begin(), all.end(), [&](const RestingObject& r) { return is_same_rest(r, part, centroid); });
      if (found == all.end()) {
        const Intrinsics& camera = samples[k].intrinsics;
        all.push_back({centroid,
                       part.area,
                       {},
                       {},
                       flat_area(samples[k], surfaces, n),
                       {},
                       {camera.width, camera.height},
                       {{camera, samples[k].camera_to_world}, {camera.width, camera.height}}});
        found = all.end() - 1;
      }
      found->samples.push_back(k);
      found->areas.push_back(part.area);
      add_observation(samples[k], surfaces, n, *found);
    }
  }
  const auto least =
      std::max<std::size_t>(3, static_cast<std::size_t>(kRestShare * static_cast<double>(samples.size())));
  std::erase_if(all, [&](const RestingObject& r) { return r.samples.size() < least; });
  for (RestingObject& resting : all)
    for (std::size_t i = 0; i < resting.hits.pixel_count(); ++i)
      if (2 * resting.hits.data()[i] < resting.samples.size()) resting.first_view.depth.data()[i] = 0;
  return all;
}

/// In how many samples the thing is gone (what is behind it is seen), or is there but hangs on something larger.
/// Something that only hides it does not disturb it.
std::size_t disturbances(const RestingObject& resting, std::span<const ReducedView> samples) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (std::find(resting.samples.begin(), resting.samples.end(), k) != resting.samples.end()) continue;
    std::size_t pixels = 0, same = 0, behind = 0;
    resting.for_each_in(samples[k], [&](const ProjectedPoint& rest) {
      const double seen = samples[k].depth.at(rest.u, rest.v);
      if (seen <= 0) return;
      ++pixels;
      if (std::abs(seen - rest.z) < kThere)
        ++same;
      else if (seen > rest.z)
        ++behind;
    });
    if (3 * same >= pixels || 2 * behind >= pixels) ++count;
  }
  return count;
}

HandledObject object_of(const RestingObject& resting) {
  HandledObject object;
  object.color = resting.colors.model();
  std::vector<double> areas = resting.areas;
  std::nth_element(areas.begin(), areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2), areas.end());
  object.area = areas[areas.size() / 2];
  object.is_flexible = resting.flat < kMinFlatShare * resting.first_area;
  object.resting_views = {resting.first_view};
  return object;
}

/// One thing at two places, or two pieces of one thing, have the same colours.
std::vector<HandledObject> merged(const std::vector<RestingObject>& all) {
  std::vector<HandledObject> objects;
  std::vector<std::size_t> last_resting;
  for (std::size_t r = 0; r < all.size(); ++r) {
    HandledObject object = object_of(all[r]);
    const auto same = std::find_if(objects.begin(), objects.end(), [&](const HandledObject& other) {
      return other.color.overlap(object.color) > kSameColor;
    });
    if (same == objects.end()) {
      objects.push_back(std::move(object));
      last_resting.push_back(r);
      continue;
    }
    const std::size_t index = static_cast<std::size_t>(same - objects.begin());
    same->resting_views.push_back(std::move(object.resting_views.front()));
    const std::vector<std::size_t>& before = all[last_resting[index]].samples;
    const bool together =
        std::find_first_of(before.begin(), before.end(), all[r].samples.begin(), all[r].samples.end()) != before.end();
    same->area = together ? same->area + object.area : std::max(same->area, object.area);
  }
  return objects;
}

/// A flat piece of a sample that does not look like the rest.
struct FlatComponent {
  std::size_t sample;
  std::vector<std::size_t> pixels;
  double area;
  ColorCounts colors;
};

void find_flat_components(const ReducedView& view, const SampleComponents& parts, std::size_t sample,
                          std::vector<FlatComponent>& pieces) {
  const Mask faces = flat_faces(view.depth, parts.foreground, view.intrinsics);
  const SurfaceComponents surfaces = surface_components(view.depth, faces, view.intrinsics);
  std::vector<FlatComponent> found(surfaces.list.size());
  for (std::size_t i = 0; i < surfaces.map.pixel_count(); ++i) {
    if (surfaces.map.data()[i] < 0) continue;
    FlatComponent& piece = found[static_cast<std::size_t>(surfaces.map.data()[i])];
    piece.pixels.push_back(i);
    piece.colors.add(&view.color.data()[3 * i]);
  }
  for (std::size_t n = 0; n < found.size(); ++n) {
    FlatComponent& piece = found[n];
    piece.sample = sample;
    piece.area = surfaces.list[n].area;
    if (piece.area < kMinFlatArea) continue;
    ColorCounts rest;
    for (std::size_t i = 0; i < surfaces.map.pixel_count(); ++i)
      if (parts.foreground.data()[i] != 0 && surfaces.map.data()[i] != static_cast<std::int32_t>(n))
        rest.add(&view.color.data()[3 * i]);
    float sum = 0;
    for (const std::size_t i : piece.pixels) sum += piece.colors.share_against(rest, &view.color.data()[3 * i]);
    if (sum >= kDistinct * static_cast<float>(piece.pixels.size())) pieces.push_back(std::move(piece));
  }
}

/// Flat pieces of the same colours in many samples are one thing. `marks` gets its pixels.
std::vector<HandledObject> find_flat_objects(std::span<const ReducedView> samples,
                                             std::span<const SampleComponents> parts,
                                             const std::vector<HandledObject>& resting, std::vector<Mask>& marks) {
  std::vector<std::vector<FlatComponent>> by_sample(samples.size());
  parallel_for(samples.size(), 1, [&](const Chunk& chunk) {
    find_flat_components(samples[chunk.index], parts[chunk.index], chunk.index, by_sample[chunk.index]);
  });
  struct Cluster {
    ColorCounts colors;
    std::vector<const FlatComponent*> pieces;
  };
  std::vector<Cluster> clusters;
  for (const std::vector<FlatComponent>& pieces : by_sample) {
    for (const FlatComponent& piece : pieces) {
      const ColorModel candidate = piece.colors.model();
      auto same = std::find_if(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
        return cluster.colors.model().overlap(candidate) > kSameColor;
      });
      if (same == clusters.end()) same = clusters.insert(clusters.end(), Cluster{});
      same->colors.add(piece.colors);
      same->pieces.push_back(&piece);
    }
  }
  std::vector<HandledObject> objects;
  for (const Cluster& cluster : clusters) {
    std::vector<double> area_in(samples.size(), 0);
    for (const FlatComponent* piece : cluster.pieces) area_in[piece->sample] += piece->area;
    std::erase(area_in, 0.0);
    if (static_cast<double>(area_in.size()) < kFlatShare * static_cast<double>(samples.size())) continue;
    HandledObject object;
    object.flat = true;
    object.color = cluster.colors.model();
    std::nth_element(area_in.begin(), area_in.begin() + static_cast<std::ptrdiff_t>(area_in.size() / 2), area_in.end());
    object.area = area_in[area_in.size() / 2];
    const bool known = std::any_of(resting.begin(), resting.end(), [&](const HandledObject& other) {
      return other.color.overlap(object.color) > kSameColor;
    });
    if (known) continue;
    for (const FlatComponent* piece : cluster.pieces)
      for (const std::size_t i : piece->pixels) marks[piece->sample].data()[i] = 1;
    objects.push_back(std::move(object));
  }
  return objects;
}

/// Colours of what is farther than `kBorder` pixels from every thing, and how much there is of it in a sample.
ColorModel colors_of_others(std::span<const ReducedView> samples, std::span<const SampleComponents> parts,
                            const std::vector<Mask>& marks, double& area) {
  ColorCounts others;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Mask& mark = marks[k];
    Mask near = mark;
    for (int v = 0; v < mark.height(); ++v)
      for (int u = 0; u < mark.width(); ++u)
        if (mark.at(u, v) != 0)
          for (int y = std::max(0, v - kBorder); y <= std::min(mark.height() - 1, v + kBorder); y += 2)
            for (int x = std::max(0, u - kBorder); x <= std::min(mark.width() - 1, u + kBorder); x += 2)
              near.at(x, y) = 1;
    for (std::size_t i = 0; i < mark.pixel_count(); ++i)
      if (parts[k].foreground.data()[i] != 0 && near.data()[i] == 0) {
        others.add(&samples[k].color.data()[3 * i]);
        area += samples[k].depth.data()[i] * samples[k].depth.data()[i];
      }
  }
  const Intrinsics& intrinsics = samples.front().intrinsics;
  area /= intrinsics.fx * intrinsics.fy * static_cast<double>(samples.size());
  return others.model();
}

} // namespace

Mask foreground_mask(const ReducedView& view, const LocalBackground& background) {
  const Image<Ground> ground = background.ground_of(view);
  Mask mask(view.depth.width(), view.depth.height());
  for (std::size_t i = 0; i < mask.pixel_count(); ++i) mask.data()[i] = ground.data()[i] == Ground::kForeground ? 1 : 0;
  const SurfaceComponents parts = surface_components(view.depth, mask, view.intrinsics);
  struct Clear {
    std::size_t pixels = 0;
    double area = 0;
  };
  std::vector<Clear> clear(parts.list.size());
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      const double z = view.depth.at(u, v);
      if (mask.at(u, v) == 0 || !background.is_clear_foreground(view.intrinsics.unproject(u, v, z))) continue;
      Clear& part = clear[static_cast<std::size_t>(parts.map.at(u, v))];
      ++part.pixels;
      part.area += z * z / (view.intrinsics.fx * view.intrinsics.fy);
    }
  }
  for (std::size_t i = 0; i < mask.pixel_count(); ++i) {
    if (mask.data()[i] == 0) continue;
    const Clear& part = clear[static_cast<std::size_t>(parts.map.data()[i])];
    if (part.area < kSpeck || part.pixels < kSpeckPixels) mask.data()[i] = 0;
  }
  return mask;
}

SceneObjects find_handled_objects(std::span<const ReducedView> samples, const BackgroundMap& background) {
  SceneObjects result;
  if (samples.size() < kMinSamples) return result;
  std::vector<SampleComponents> parts(samples.size());
  parallel_for(samples.size(), 1,
               [&](const Chunk& chunk) { parts[chunk.index] = parts_of(samples[chunk.index], background); });
  const int width = samples.front().depth.width();
  const int height = samples.front().depth.height();
  std::vector<Mask> marks(samples.size(), Mask(width, height));
  std::vector<RestingObject> resting = find_resting(samples, parts, background);
  const auto least = kRestShare * static_cast<double>(samples.size());
  std::erase_if(resting, [&](const RestingObject& r) { return static_cast<double>(disturbances(r, samples)) < least; });
  for (const RestingObject& r : resting)
    for (const std::size_t k : r.samples)
      r.for_each_in(samples[k], [&](const ProjectedPoint& seen) { marks[k].at(seen.u, seen.v) = 1; });
  result.objects = merged(resting);
  std::vector<HandledObject> flat = find_flat_objects(samples, parts, result.objects, marks);
  std::move(flat.begin(), flat.end(), std::back_inserter(result.objects));
  std::stable_sort(result.objects.begin(), result.objects.end(),
                   [](const HandledObject& a, const HandledObject& b) { return a.area > b.area; });
  if (result.objects.size() > kMaxObjects) result.objects.resize(kMaxObjects);
  double others_area = 0;
  result.others = colors_of_others(samples, parts, marks, others_area);
  for (HandledObject& object : result.objects)
    object.prior = static_cast<float>(
        std::clamp(kPriorWeight * std::log(object.area / std::max(others_area, 1e-6)), kMinPrior, 0.0));
  return result;
}

} // namespace kinora::ingest
