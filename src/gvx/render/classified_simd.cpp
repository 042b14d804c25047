// composite_classified_batch: classified.h once more, with a ray in each lane of a vector. Compiled once for
// each instruction set.

#include "gvx/render/classified.h"
#include "gvx/render/simd_targets.h"
#include "gvx/render/stretch_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/classified_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/batch_simd-inl.h"
#include "gvx/render/sample_simd-inl.h"
#include "gvx/render/shade_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// What the rays of a vector see in a step: nothing where `seen` is not.
struct Shown {
  Mask seen;
  Vec3v color;
  Float opacity;
  Vec3v gradient;   // where it is lit
  Float certainty;  // of a surface
};

HWY_INLINE Float opacity_of_depth(Float depth) {
  return hn::Sub(all(1), hn::Exp(kFloats, hn::Neg(depth)));
}

/// composite_labels: what a step shows.
template <typename Voxel>
class Labels {
 public:
  HWY_INLINE Labels(const FrameView& frame, const StretchBatch& batch)
      : function_(frame.visibility.functions[0]),
        texels_(batch.fine.brick),
        edge_(static_cast<int>(batch.m)),
        units_(batch.units) {}

  HWY_INLINE void show(Float i, const PathRows& fine, const PathRows&, Mask active, bool lit,
                       Shown& shown) const {
    const Vec3v p = fine.at(i);
    const Int texel = TexelPlace::index_of(texel_at(p.x), texel_at(p.y), texel_at(p.z), edge_);
    const Float label = gather_pair(texels_.texels, texel).low;
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    static_assert(sizeof(scene::Matter) == 16);
    const Float last = all(static_cast<float>(function_.entries - 1));
    store_offsets(hn::ShiftLeft<4>(whole(hn::Min(label, last))), offsets);
    Int matter[4];
    load_rows(reinterpret_cast<const std::byte*>(function_.matter), offsets, matter);
    const Float extinction = hn::BitCast(kFloats, matter[3]);
    shown.seen = hn::And(active, hn::Gt(extinction, hn::Zero(kFloats)));
    if (none(shown.seen)) return;
    const Float share = hn::Div(all(1), hn::IfThenElse(shown.seen, extinction, all(1)));
    shown.color = scaled(share, PathRows::vec3(matter));
    shown.opacity = opacity_of_depth(hn::Mul(extinction, all(units_)));
    if (!lit) return;
    shown.gradient = region_gradient(p, label);
    const Float steep = hn::Sqrt(dot(shown.gradient, shown.gradient));
    shown.certainty = hn::Min(hn::Mul(steep, all(kRegionSharpness)), all(1));
  }

 private:
  HWY_INLINE Float texel_at(Float position) const {
    const Float last = all(static_cast<float>(edge_ - 1));
    return hn::Add(hn::Min(hn::Floor(hn::Max(position, hn::Zero(kFloats))), last), all(1));
  }

  /// How much each label's own region changes: the gradient of what is 1 in it and 0 elsewhere.
  HWY_INLINE Vec3v region_gradient(const Vec3v& p, Float label) const {
    Around around;
    around.read(texels_, edge_, p);
    for (Triple& row : around.rows) {
      for (Float& texel : row.texel) texel = hn::IfThenElseZero(hn::Eq(texel, label), all(1));
    }
    return around.gradient(held(p, edge_));
  }

  const scene::TransferView& function_;
  const PlainTexels<Voxel> texels_;
  const int edge_;
  const float units_;
};

/// composite_colors: what a step shows.
template <bool kNormals>
class Colors {
 public:
  HWY_INLINE Colors(const FrameView& frame, const StretchBatch& batch)
      : fine_(batch.fine.brick),
        coarse_(batch.coarse.brick),
        blended_(batch.blended),
        edge_(static_cast<int>(batch.m)),
        voxels_per_step_(frame.voxels_per_step),
        thickness_(batch.coarse.voxels_across / batch.fine.voxels_across) {}

  HWY_INLINE void show(Float i, const PathRows& fine, const PathRows& coarse, Mask active, bool lit,
                       Shown& shown) const {
    const Vec3v p = fine.at(i);
    Sample mixed = sample(fine_, p, active);
    Float extinction = extinction_of(mixed.opacity);
    if (blended_) {
      const Float asked = hn::MulAdd(i, coarse.eighth, coarse.fourth);
      const Float blend = hn::Min(hn::Max(asked, hn::Zero(kFloats)), all(1));
      const Sample other = sample(coarse_, coarse.at(i), active);
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
    shown.opacity = opacity_of_depth(hn::Mul(extinction, all(voxels_per_step_)));
    if (!lit) return;
    Float steep;
    if constexpr (kNormals) {
      shown.gradient = mixed.normal;
      steep = hn::Mul(hn::Sqrt(dot(mixed.normal, mixed.normal)), share);
    } else {
      shown.gradient = gradient(plane(fine_, 3), edge_, p);
      steep = hn::Mul(hn::Sqrt(dot(shown.gradient, shown.gradient)), all(1 / kSurfaceSlope));
    }
    shown.certainty = hn::Min(steep, all(1));
  }

 private:
  using Texels = PlainTexels<std::uint8_t>;

  /// ColorSample.
  struct Sample {
    Float opacity;
    Vec3v color, normal;
  };

  HWY_INLINE static Vec3v mix(const Vec3v& a, const Vec3v& b, Float weight) {
    return {mix(a.x, b.x, weight), mix(a.y, b.y, weight), mix(a.z, b.z, weight)};
  }
  HWY_INLINE static Float mix(Float a, Float b, Float weight) { return HWY_NAMESPACE::mix(a, b, weight); }

  HWY_INLINE Texels plane(const Texels& brick, std::size_t index) const {
    Texels texels = brick;
    texels.texels += index * plane_texels(static_cast<std::size_t>(edge_));
    return texels;
  }

  HWY_INLINE Sample sample(const Texels& brick, const Vec3v& p, Mask active) const {
    const TexelPlace place(p, edge_);
    const int row = edge_ + 2;
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

template <typename Content>
void composite_content(const FrameView& frame, StretchBatch& batch) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  const Shading<true> lights(frame);
  const Content content(frame, batch);
  const bool lit = lights.lit();
  batch.opaque_count = 0;
  for (std::size_t lane = 0; lane < batch.count; lane += kLanes) {
    const BatchLanes lanes(batch, lane);
    const PathRows fine = lanes.fine(batch), coarse = batch.blended ? lanes.coarse(batch) : fine;
    const Float end = lanes.steps(fine);
    const Vec3v to_eye = lit ? lanes.to_eye(batch) : fine.first;
    typename Shading<true>::FarHalves halves;
    if (lit) lights.find_halves(to_eye, halves);
    Vec3v color;
    Float opacity;
    lanes.load(batch, color, opacity);
    Int samples = hn::Zero(kInts);
    const float last = hn::GetLane(hn::MaxOfLanes(kFloats, end));
    for (float step = 0; step < last; step += 1) {
      const Float i = all(step);
      const Mask active = hn::And(hn::Lt(i, end), hn::Lt(opacity, all(kOpaque)));
      if (none(active)) break;
      samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, active)));
      Shown shown;
      content.show(i, fine, coarse, active, lit, shown);
      if (none(shown.seen)) continue;
      Vec3v more = shown.color;
      if (lit) {
        const auto point_at = [&]() HWY_ATTR { return lanes.places(batch).at(i); };
        const Shade shade = lights.shade_certain(shown.gradient, shown.certainty, to_eye, halves, point_at);
        more = {hn::MulAdd(more.x, shade.body.x, shade.glint.x),
                hn::MulAdd(more.y, shade.body.y, shade.glint.y),
                hn::MulAdd(more.z, shade.body.z, shade.glint.z)};
      }
      const Float weight = hn::Mul(hn::Sub(all(1), opacity), shown.opacity);
      const auto add = [&](Float more_color, Float& sum) HWY_ATTR {
        sum = hn::IfThenElse(shown.seen, hn::MulAdd(weight, more_color, sum), sum);
      };
      add(more.x, color.x);
      add(more.y, color.y);
      add(more.z, color.z);
      opacity = hn::IfThenElse(shown.seen, hn::Add(opacity, weight), opacity);
    }
    lanes.store(batch, color, opacity, samples);
  }
}

}  // namespace

void labels_u8(const FrameView& frame, StretchBatch& batch) {
  composite_content<Labels<std::uint8_t>>(frame, batch);
}
void labels_u16(const FrameView& frame, StretchBatch& batch) {
  composite_content<Labels<std::uint16_t>>(frame, batch);
}
void colors(const FrameView& frame, StretchBatch& batch) {
  composite_content<Colors<false>>(frame, batch);
}
void colors_with_normals(const FrameView& frame, StretchBatch& batch) {
  composite_content<Colors<true>>(frame, batch);
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
