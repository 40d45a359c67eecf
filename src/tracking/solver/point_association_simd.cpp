#include "tracking/solver/point_association.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/solver/point_association_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "core/free_space_simd.h"
#include "core/sensor_noise_simd.h"
#include "core/vectors_simd.h"
#include "tracking/solver/texture_sampling_simd.h"
#include "tracking/view/visibility.h"

#ifndef KINORA_TRACKING_POINT_ASSOCIATION_ONCE
#define KINORA_TRACKING_POINT_ASSOCIATION_ONCE
namespace kinora::tracking {

/// Images of a view, row by row.
struct ViewImages {
  const float* depth;
  const float* weights; ///< of the planes
  const float* planes;  ///< four numbers each
  const std::uint8_t* mask;
  const std::int16_t* to_silhouette; ///< two numbers each; may be none
  std::int32_t width, height;
};

struct FloatGates {
  float plane, contour, silhouette_scale;
};

} // namespace kinora::tracking
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

constexpr auto kFacing = static_cast<float>(kFacingCosine);
constexpr DepthMargin kTextureMargin{0.015, 3}; // of a surface that shows a point's texture
constexpr float kSilhouetteMargin = 1;          // pixels that a silhouette may be wrong by

/// Some points side by side, and what is compared with them.
class AssociationLanes {
public:
  HWY_INLINE AssociationLanes(const motion::PosedPoint* points, std::size_t count, const ViewImages& view,
                              const TextureImage& image)
      : count_(count), view_(view), image_(image) {
    const Floats df;
    const Ints di;
    position_ = load_rows([&](std::size_t lane) { return points[item_of(lane, count)].position.data(); }).v;
    normal_ = load_rows([&](std::size_t lane) { return points[item_of(lane, count)].normal.data(); }).v;
    const F facing = dot(normal_, position_);
    const F least = hn::Mul(constant(kFacing * kFacing), dot(position_, position_));
    const Mask faces = hn::And(hn::Lt(facing, zero()), hn::Ge(hn::Mul(facing, facing), least));
    const Mask visible = hn::Gt(position_.z, constant(static_cast<float>(kNearestDepth)));
    const F inverse_depth = hn::Div(constant(1), hn::IfThenElse(visible, position_.z, constant(1)));
    const F u = hn::MulAdd(hn::Mul(constant(image.fx), position_.x), inverse_depth, constant(image.cx));
    const F v = hn::MulAdd(hn::Mul(constant(image.fy), position_.y), inverse_depth, constant(image.cy));
    const auto within = [&](F at, std::int32_t size) {
      return hn::And(hn::Gt(at, constant(-0.49F)), hn::Lt(at, constant(static_cast<float>(size) - 0.51F)));
    };
    in_view_ = hn::And(visible, hn::And(within(u, view.width), within(v, view.height)));
    visible_ = hn::And(in_view_, faces);
    u_ = hn::IfThenElseZero(in_view_, u);
    v_ = hn::IfThenElseZero(in_view_, v);
    const I column = hn::ConvertTo(di, hn::Add(u_, constant(0.5F)));
    const I row = hn::ConvertTo(di, hn::Add(v_, constant(0.5F)));
    pixel_u_ = hn::ConvertTo(df, column);
    pixel_v_ = hn::ConvertTo(df, row);
    pixel_ = hn::Add(hn::Mul(row, hn::Set(di, view.width)), column);
    hn::Store(pixel_, di, pixels_);
    plane_ = {{zero(), zero(), zero()}, zero()};
    plane_scale_ = label_ = zero();
    covered_ = on_surface_ = violates_free_space_ = shown_ = hn::Lt(zero(), zero());
  }

  HWY_INLINE void compare(const FloatGates& gates) {
    const Floats df;
    if (hn::AllFalse(df, in_view_)) return;
    label_ = read([&](std::size_t pixel) { return view_.mask[pixel]; });
    const F front = hn::GatherIndex(df, view_.depth, pixel_);
    covered_ = is_occluded(position_.z, front, kPoseMargin);
    const Mask off_label = hn::Eq(label_, zero());
    find_planes(hn::AndNot(off_label, visible_), gates.plane);
    const Mask away = hn::And(off_label, in_view_);
    if (view_.to_silhouette != nullptr && !hn::AllFalse(df, away)) find_contours(away, gates);
  }

  HWY_INLINE void write(DataTerm* terms, float* image) const {
    const Floats df;
    HWY_ALIGN float scales[kLanes];
    HWY_ALIGN float surface[kLanes];
    HWY_ALIGN float beyond_silhouette[kLanes];
    HWY_ALIGN float values[kLanes];
    hn::Store(plane_scale_, df, scales);
    hn::Store(hn::IfThenElseZero(on_surface_, constant(1)), df, surface);
    hn::Store(hn::IfThenElseZero(violates_free_space_, constant(1)), df, beyond_silhouette);
    F value = hn::NaN(df);
    if (!hn::AllFalse(df, shown_)) value = hn::IfThenElse(shown_, TextureLanes(image_, u_, v_).sample(0), value);
    hn::Store(value, df, values);
    store_rows(plane_, count_, [&](std::size_t lane) { return terms[lane].plane_normal.data(); });
    for (std::size_t lane = 0; lane < count_; ++lane) {
      terms[lane].expected = terms[lane].texture_scale = {};
      terms[lane].plane_scale = scales[lane];
      terms[lane].on_surface = surface[lane] != 0;
      terms[lane].violates_free_space = beyond_silhouette[lane] != 0;
      image[lane] = values[lane];
    }
  }

private:
  static constexpr std::size_t kLanes = hn::MaxLanes(Floats());

  /// Images of small numbers, as floats.
  template <class ValueOf> HWY_INLINE F read(const ValueOf& value_of) const {
    HWY_ALIGN float values[kLanes];
    for (std::size_t lane = 0; lane < hn::Lanes(Floats()); ++lane) {
      values[lane] = static_cast<float>(value_of(static_cast<std::size_t>(pixels_[lane])));
    }
    return hn::Load(Floats(), values);
  }

  HWY_INLINE void find_planes(Mask on_label, float gate) {
    const Floats df;
    const Mask measured = hn::And(on_label, hn::Gt(hn::GatherIndex(df, view_.weights, pixel_), zero()));
    const Quat plane = gather4(view_.planes, hn::ShiftLeft<2>(pixel_));
    const F one = constant(1);
    const Vec3 ray{hn::Mul(hn::Sub(pixel_u_, constant(image_.cx)), constant(1 / image_.fx)),
                   hn::Mul(hn::Sub(pixel_v_, constant(image_.cy)), constant(1 / image_.fy)), one};
    const F along = hn::IfThenElse(measured, dot(plane.v, ray), one);
    const Vec3 point = mul(hn::Neg(hn::Div(plane.w, along)), ray);
    const Vec3 away = sub(position_, point);
    Mask matches = hn::And(measured, hn::Le(dot(away, away), constant(gate * gate)));
    matches = hn::And(matches, hn::Ge(dot(normal_, plane.v), constant(static_cast<float>(kNormalCosine))));
    const F through = dot(plane.v, point);
    const F squared = hn::IfThenElse(measured, dot(point, point), one);
    const F incidence = hn::Div(hn::Abs(through), hn::Sqrt(squared));
    const F deviation = depth_sigma_across(point.z, incidence);
    plane_.v = choose(matches, plane.v, plane_.v);
    plane_.w = hn::IfThenElse(matches, hn::Neg(through), plane_.w);
    plane_scale_ = hn::IfThenElseZero(matches, hn::Div(one, hn::IfThenElse(matches, deviation, one)));
    on_surface_ = matches;
    // A surface that is measured elsewhere along the ray shows another point's texture.
    const Mask contradicted = hn::AndNot(matches, measured);
    violates_free_space_ = hn::AndNot(covered_, contradicted);
    const Mask well_within = hn::And(on_label, hn::Eq(label_, constant(MaskArea::kInterior)));
    shown_ = hn::AndNot(covered_, hn::AndNot(contradicted, well_within));
  }

  /// Points where the camera sees past them: onto the plane through the camera and the rim of the silhouette.
  HWY_INLINE void find_contours(Mask off_label, const FloatGates& gates) {
    const F inwards_u = read([&](std::size_t pixel) { return view_.to_silhouette[2 * pixel]; });
    const F inwards_v = read([&](std::size_t pixel) { return view_.to_silhouette[2 * pixel + 1]; });
    const F squared = hn::MulAdd(inwards_u, inwards_u, hn::Mul(inwards_v, inwards_v));
    const Mask beyond_silhouette =
        hn::AndNot(covered_, hn::And(off_label, hn::Ge(squared, constant(kSilhouetteMargin * kSilhouetteMargin))));
    violates_free_space_ = hn::Or(violates_free_space_, beyond_silhouette);
    const F one = constant(1);
    const F per_length = hn::Div(one, hn::Sqrt(hn::IfThenElse(beyond_silhouette, squared, one)));
    const F outwards_u = hn::Neg(hn::Mul(inwards_u, per_length));
    const F outwards_v = hn::Neg(hn::Mul(inwards_v, per_length));
    const F contour_u =
        hn::MulAdd(constant(kSilhouetteMargin), outwards_u, hn::Add(hn::Sub(pixel_u_, constant(image_.cx)), inwards_u));
    const F contour_v =
        hn::MulAdd(constant(kSilhouetteMargin), outwards_v, hn::Add(hn::Sub(pixel_v_, constant(image_.cy)), inwards_v));
    Vec3 normal{hn::Mul(outwards_u, constant(image_.fx)), hn::Mul(outwards_v, constant(image_.fy)),
                hn::Neg(hn::MulAdd(outwards_u, contour_u, hn::Mul(outwards_v, contour_v)))};
    normal = mul(hn::Div(one, hn::Sqrt(hn::IfThenElse(beyond_silhouette, dot(normal, normal), one))), normal);
    const F distance = dot(normal, position_);
    const Mask beyond =
        hn::And(beyond_silhouette, hn::And(hn::Gt(distance, zero()), hn::Le(distance, constant(gates.contour))));
    plane_.v = choose(beyond, normal, plane_.v);
    const F scale = hn::Div(constant(gates.silhouette_scale * image_.fx), hn::IfThenElse(beyond, position_.z, one));
    plane_scale_ = hn::IfThenElse(beyond, scale, plane_scale_);
  }

  std::size_t count_;
  const ViewImages& view_;
  const TextureImage& image_;
  Vec3 position_, normal_;
  Mask in_view_, visible_; ///< whichever way they face; towards the camera
  F u_, v_, pixel_u_, pixel_v_;
  I pixel_; ///< 0 where a point is not in view
  HWY_ALIGN std::int32_t pixels_[kLanes];
  F label_;
  Mask covered_; ///< something stands before the point
  Quat plane_;
  F plane_scale_;
  Mask on_surface_, violates_free_space_;
  Mask shown_; ///< the texture is that of the point
};

/// What the levels show of some points.
HWY_INLINE void sample_textures_in_lanes(const motion::PosedPoint* points, std::size_t count, const ViewImages& view,
                                         const std::array<TextureImage, LayerView::kLevels>& levels,
                                         std::array<float, LayerView::kLevels>* shown) {
  const Floats df;
  const Ints di;
  const TextureImage& camera = levels[0];
  const F one = constant(1);
  const Vec3 position = load_rows([&](std::size_t lane) { return points[item_of(lane, count)].position.data(); }).v;
  Mask inside = hn::Gt(position.z, zero());
  const F inverse_depth = hn::Div(one, hn::IfThenElse(inside, position.z, one));
  F u = hn::MulAdd(hn::Mul(constant(camera.fx), position.x), inverse_depth, constant(camera.cx));
  F v = hn::MulAdd(hn::Mul(constant(camera.fy), position.y), inverse_depth, constant(camera.cy));
  const auto within = [&](F at, std::int32_t size) {
    return hn::And(hn::Ge(at, zero()), hn::Lt(at, constant(static_cast<float>(size - 1))));
  };
  inside = hn::And(inside, hn::And(within(u, view.width), within(v, view.height)));
  HWY_ALIGN float values[LayerView::kLevels][hn::MaxLanes(df)];
  for (auto& level : values) hn::Store(hn::NaN(df), df, level);
  if (!hn::AllFalse(df, inside)) {
    u = hn::IfThenElseZero(inside, u);
    v = hn::IfThenElseZero(inside, v);
    const I column = hn::ConvertTo(di, hn::Add(u, constant(0.5F)));
    const I row = hn::ConvertTo(di, hn::Add(v, constant(0.5F)));
    const I pixel = hn::Add(hn::Mul(row, hn::Set(di, view.width)), column);
    HWY_ALIGN std::int32_t pixels[hn::MaxLanes(df)];
    HWY_ALIGN float labels[hn::MaxLanes(df)];
    hn::Store(pixel, di, pixels);
    for (std::size_t lane = 0; lane < hn::Lanes(df); ++lane) labels[lane] = static_cast<float>(view.mask[pixels[lane]]);
    const Mask on_label = hn::And(inside, hn::Eq(hn::Load(df, labels), constant(MaskArea::kInterior)));
    const Mask measured = hn::And(on_label, hn::Gt(hn::GatherIndex(df, view.weights, pixel), zero()));
    const Quat plane = gather4(view.planes, hn::ShiftLeft<2>(pixel));
    const Vec3 ray{hn::Mul(hn::Sub(hn::ConvertTo(df, column), constant(camera.cx)), constant(1 / camera.fx)),
                   hn::Mul(hn::Sub(hn::ConvertTo(df, row), constant(camera.cy)), constant(1 / camera.fy)), one};
    const F depth = hn::Neg(hn::Div(plane.w, hn::IfThenElse(measured, dot(plane.v, ray), one)));
    const F away = hn::Abs(hn::Sub(depth, position.z));
    const Mask there = hn::And(measured, hn::Le(away, margin_at(kTextureMargin, position.z)));
    for (std::size_t level = 0; level < levels.size() && !hn::AllFalse(df, there); ++level) {
      const F value = TextureLanes(levels[level], u, v).sample(0);
      hn::Store(hn::IfThenElse(there, value, hn::NaN(df)), df, values[level]);
    }
  }
  for (std::size_t lane = 0; lane < count; ++lane) {
    for (std::size_t level = 0; level < levels.size(); ++level) shown[lane][level] = values[level][lane];
  }
}

void sample_all_textures_in_lanes(const motion::PosedPoint* points, std::size_t count, const ViewImages& view,
                                  const std::array<TextureImage, LayerView::kLevels>& levels,
                                  std::array<float, LayerView::kLevels>* shown) {
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(Floats())) {
    sample_textures_in_lanes(points + begin, HWY_MIN(count - begin, hn::Lanes(Floats())), view, levels, shown + begin);
  }
}

void associate_in_lanes(const motion::PosedPoint* points, std::size_t count, const ViewImages& view,
                        const TextureImage& texture, const FloatGates& gates, DataTerm* terms, float* image) {
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(Floats())) {
    AssociationLanes lanes(points + begin, HWY_MIN(count - begin, hn::Lanes(Floats())), view, texture);
    lanes.compare(gates);
    lanes.write(terms + begin, image + begin);
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

namespace {

HWY_EXPORT(associate_in_lanes);
HWY_EXPORT(sample_all_textures_in_lanes);

ViewImages images_of(const LayerView& view) {
  return {view.depth.data(),
          view.planes.weights.data(),
          view.planes.planes.data(),
          view.mask.data(),
          view.to_silhouette.empty() ? nullptr : view.to_silhouette.data(),
          view.intrinsics.width,
          view.intrinsics.height};
}

} // namespace

void associate_points(std::span<const motion::PosedPoint> points, const LayerView& view, int level,
                      const AssociationGates& gates, std::span<DataTerm> terms, std::span<float> image) {
  const FloatGates floats{static_cast<float>(gates.plane), static_cast<float>(gates.contour),
                          static_cast<float>(std::sqrt(gates.silhouette_weight))};
  HWY_DYNAMIC_DISPATCH(associate_in_lanes)
  (points.data(), points.size(), images_of(view), texture_image(view, level), floats, terms.data(), image.data());
}

void sample_textures(std::span<const motion::PosedPoint> points, const LayerView& view,
                     std::span<std::array<float, LayerView::kLevels>> shown) {
  std::array<TextureImage, LayerView::kLevels> levels;
  for (std::size_t level = 0; level < levels.size(); ++level)
    levels[level] = texture_image(view, static_cast<int>(level));
  HWY_DYNAMIC_DISPATCH(sample_all_textures_in_lanes)
  (points.data(), points.size(), images_of(view), levels, shown.data());
}

} // namespace kinora::tracking
#endif
