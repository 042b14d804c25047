// composite_classified_batch: classified.h once more, with a ray in each lane of a vector. Compiled once for
// each instruction set.

#include "gvx/render/reference/classified.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/classified_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
#include "gvx/render/vectors/each_step_simd-inl.h"
#include "gvx/render/vectors/gradient_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// What goes with a colour that is lit.
HWY_INLINE Vec3v lit_by(const Shade& shade, const Vec3v& color) {
  return {hn::MulAdd(color.x, shade.body.x, shade.glint.x), hn::MulAdd(color.y, shade.body.y, shade.glint.y),
          hn::MulAdd(color.z, shade.body.z, shade.glint.z)};
}

/// composite_labels: what a step shows.
template <typename Voxel>
class Labels {
 public:
  static constexpr bool kWhole = true;

  HWY_INLINE Labels(const FrameView& frame, const StretchBatch& batch)
      : function_(frame.visibility.functions[0]),
        texels_(batch.fine.brick, static_cast<int>(batch.m)),
        edge_(static_cast<int>(batch.m)),
        units_(batch.units) {}

  GVX_PIECE void show(Float i, const StepRays<kWhole>& rays, Mask active, Shown& shown) const {
    const Vec3v p = rays.fine.at(i);
    const Int texel = TexelPlace::index_of(texel_at(p.x), texel_at(p.y), texel_at(p.z), edge_);
    const Float label = gather_pair(texels_.texels, texel).low;
    // Labels are the table's entries.
    const Matter matter = function_.nearest_matter(label);
    const Float extinction = matter.part[3];
    shown.seen = hn::And(active, hn::Gt(extinction, hn::Zero(kFloats)));
    if (none(shown.seen)) return;
    const Float share = hn::Div(all(1), hn::IfThenElse(shown.seen, extinction, all(1)));
    shown.color = scaled(share, {matter.part[0], matter.part[1], matter.part[2]});
    shown.opacity = opacity_of(hn::Mul(extinction, all(units_)));
    if (!rays.lit()) return;
    const Vec3v normal = region_gradient(p, label);
    const Float steep = hn::Mul(hn::Sqrt(dot(normal, normal)), all(kRegionSharpness));
    shown.color = lit_by(rays.shade_certain(i, normal, hn::Min(steep, all(1))), shown.color);
  }

 private:
  HWY_INLINE Float texel_at(Float position) const {
    const Float last = all(static_cast<float>(edge_ - 1));
    return hn::Add(hn::Min(hn::Floor(hn::Max(position, hn::Zero(kFloats))), last), all(1));
  }

  /// How much each label's own region changes: the gradient of what is 1 in it and 0 elsewhere.
  GVX_PIECE Vec3v region_gradient(const Vec3v& p, Float label) const {
    return SplineWindow<PlainTexels<Voxel>>(texels_, edge_, p).gradient_of([&](Float texel) HWY_ATTR {
      return hn::IfThenElseZero(hn::Eq(texel, label), all(1));
    });
  }

  const Function function_;
  const PlainTexels<Voxel> texels_;
  const int edge_;
  const float units_;
};

/// composite_colors: what a step shows.
template <bool kNormals>
class Colors {
 public:
  static constexpr bool kWhole = true;

  HWY_INLINE Colors(const FrameView& frame, const StretchBatch& batch)
      : fine_(batch.fine.brick, static_cast<int>(batch.m)),
        coarse_(batch.blended ? batch.coarse.brick : nullptr, static_cast<int>(batch.m)),
        blended_(batch.blended),
        edge_(static_cast<int>(batch.m)),
        voxels_per_step_(frame.voxels_per_step),
        thickness_(batch.coarse.voxels_across / batch.fine.voxels_across) {}

  GVX_PIECE void show(Float i, const StepRays<kWhole>& rays, Mask active, Shown& shown) const {
    const Vec3v p = rays.fine.at(i);
    Sample mixed = sample(fine_, p, active);
    Float extinction = extinction_of(mixed.opacity);
    if (blended_) {
      const Float blend = share_at(rays.coarse, i);
      const Sample other = sample(coarse_, rays.coarse.at(i), active);
      extinction = mix(extinction, hn::Mul(all(thickness_), extinction_of(other.opacity)), blend);
      mixed.opacity = mix(mixed.opacity, other.opacity, blend);
      mixed.color = mix(mixed.color, other.color, blend);
      if constexpr (kNormals) mixed.normal = mix(mixed.normal, other.normal, blend);
    }
    const Float zero = hn::Zero(kFloats);
    const Mask some = hn::And(hn::Gt(extinction, zero), hn::Gt(mixed.opacity, zero));
    shown.seen = hn::And(active, some);
    if (none(shown.seen)) return;
    const Float share = hn::Div(all(1), hn::IfThenElse(some, mixed.opacity, all(1)));
    shown.color = scaled(share, mixed.color);
    shown.opacity = opacity_of(hn::Mul(extinction, all(voxels_per_step_)));
    if (!rays.lit()) return;
    if constexpr (!kNormals) mixed.normal = gradient(plane(fine_, 3), edge_, p);
    const Float per_surface = kNormals ? share : all(1 / kSurfaceSlope);
    const Float steep = hn::Mul(hn::Sqrt(dot(mixed.normal, mixed.normal)), per_surface);
    shown.color = lit_by(rays.shade_certain(i, mixed.normal, hn::Min(steep, all(1))), shown.color);
  }

 private:
  using Texels = PlainTexels<std::uint8_t>;

  /// ColorSample.
  struct Sample {
    Float opacity;
    Vec3v color, normal;
  };

  HWY_INLINE Texels plane(const Texels& brick, std::size_t index) const {
    Texels texels = brick;
    texels.texels += index * plane_texels(static_cast<std::size_t>(edge_));
    return texels;
  }

  GVX_PIECE Sample sample(const Texels& brick, const Vec3v& p, Mask active) const {
    const TexelPlace place(p, edge_);
    const int row = row_of(edge_);
    const auto of_plane = [&](std::size_t index) HWY_ATTR {
      return trilinear(plane(brick, index).read(place.index, row, row * row), place.weight);
    };
    const Float zero = hn::Zero(kFloats);
    Sample s;
    s.opacity = hn::Mul(of_plane(3), all(1.0f / 255));
    s.color = s.normal = {zero, zero, zero};
    const Mask some = hn::Gt(s.opacity, zero);
    if (none(hn::And(some, active))) return s;
    const auto color = [&](std::size_t index) HWY_ATTR {
      return hn::IfThenElseZero(some, hn::Mul(of_plane(index), all(1.0f / 255)));
    };
    s.color = {color(0), color(1), color(2)};
    if constexpr (kNormals) {
      const auto normal = [&](std::size_t index) HWY_ATTR {
        return hn::IfThenElseZero(some, hn::Mul(hn::Sub(of_plane(index), all(127)), all(1.0f / 127)));
      };
      s.normal = {normal(4), normal(5), normal(6)};
    }
    return s;
  }

  HWY_INLINE static Float extinction_of(Float opacity) {
    const Float left = hn::Sub(all(1), hn::Min(opacity, all(kMostOpacity)));
    return hn::Neg(hn::Log(kFloats, left));
  }

  const Texels fine_, coarse_;
  const bool blended_;
  const int edge_;
  const float voxels_per_step_, thickness_;
};

}  // namespace

void labels_u8(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<Labels<std::uint8_t>>(frame, batch);
}
void labels_u16(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<Labels<std::uint16_t>>(frame, batch);
}
void colors(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<Colors<false>>(frame, batch);
}
void colors_with_normals(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<Colors<true>>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(labels_u8);
HWY_EXPORT(labels_u16);
HWY_EXPORT(colors);
HWY_EXPORT(colors_with_normals);

void composite_classified_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.content) {
    case VoxelContent::color:
      return HWY_DYNAMIC_DISPATCH(colors)(frame, batch);
    case VoxelContent::color_normal:
      return HWY_DYNAMIC_DISPATCH(colors_with_normals)(frame, batch);
    default:
      return frame.format.type == VoxelType::u8 ? HWY_DYNAMIC_DISPATCH(labels_u8)(frame, batch)
                                                : HWY_DYNAMIC_DISPATCH(labels_u16)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
