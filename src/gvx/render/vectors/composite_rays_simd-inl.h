/// \file
/// A vector of rays that are composited pre-integrated: what they sample, what of it is seen, and its light.
/// Formulas are those of formula/. Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_COMPOSITE_RAYS_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_COMPOSITE_RAYS_SIMD_INL_H
#undef GVX_RENDER_COMPOSITE_RAYS_SIMD_INL_H
#else
#define GVX_RENDER_COMPOSITE_RAYS_SIMD_INL_H
#endif

// Before any of Highway.
// clang-format off
#include "gvx/render/vectors/simd_targets.h"
// clang-format on

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/render/reference/composite.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/batch_simd-inl.h"
#include "gvx/render/vectors/deviation_simd-inl.h"
#include "gvx/render/vectors/gradient_simd-inl.h"
#include "gvx/render/vectors/quads_simd-inl.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/shade_simd-inl.h"
#include "gvx/render/vectors/transfer_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

HWY_INLINE Mask no_lanes() {
  return hn::Lt(all(1), all(0));
}

#include "gvx/render/formula/preintegrated.inc"

/// Seen.
struct Seen {
  Vec3v color;
  Float weight, moment;

  HWY_INLINE static Seen nothing() {
    const Float zero = hn::Zero(kFloats);
    return {{zero, zero, zero}, zero, zero};
  }
};

/// The gradient, in stored values a voxel of the levels that are blended.
struct Slope {
  Vec3v gradient;
  Float blend;
};

/// How bricks lie in memory: as they are stored.
template <typename Voxel_>
struct AsStored {
  using Voxel = Voxel_;
  using Texels = PlainTexels<Voxel>;
  using Deviations = PlainDeviations;

  HWY_INLINE static Texels texels(const StretchBatch& batch, const StretchBatch::Path& path) {
    return {path.brick, static_cast<int>(batch.m)};
  }
  HWY_INLINE static Deviations deviations(const StretchBatch& batch, const StretchBatch::Path& path) {
    return {stored(batch, path), static_cast<int>(batch.m)};
  }
  HWY_INLINE static const std::uint8_t* stored(const StretchBatch& batch, const StretchBatch::Path& path) {
    const std::byte* behind = path.brick + plane_texels(batch.m) * sizeof(Voxel);
    return path.deviates ? reinterpret_cast<const std::uint8_t*>(behind) : nullptr;
  }
};

/// Laid out anew: make() must have been called.
template <typename Voxel_>
struct LaidOut {
  using Voxel = Voxel_;
  static constexpr bool kQuads = std::is_same_v<Voxel, std::uint8_t>;
  using Texels = std::conditional_t<kQuads, QuadTexels, PlainTexels<Voxel>>;
  using Deviations = DeviationQuads;

  static void make(const StretchBatch& batch, bool gradients, StretchBatch::Path& path) {
    if constexpr (kQuads) make_quads(batch.m, gradients, path);
    const Deviations deviates = deviations(batch, path);
    if (deviates.some()) deviates.make(path);
  }
  HWY_INLINE static Texels texels(const StretchBatch& batch, const StretchBatch::Path& path) {
    if constexpr (kQuads) {
      return quads_of(batch.m, path);
    } else {
      return {path.brick, static_cast<int>(batch.m)};
    }
  }
  HWY_INLINE static Deviations deviations(const StretchBatch& batch, const StretchBatch::Path& path) {
    return {AsStored<Voxel>::stored(batch, path), static_cast<int>(batch.m), path.deviations};
  }
};

/// One of the bricks that all rays of a batch go through.
template <typename Layout>
struct BrickOf {
  using Samples = SamplesInside<typename Layout::Texels, false>;

  HWY_INLINE BrickOf(const StretchBatch& batch, const StretchBatch::Path& path)
      : texels(Layout::texels(batch, path)),
        samples(texels, static_cast<int>(batch.m)),
        deviations(Layout::deviations(batch, path)) {}

  HWY_INLINE Float deviation_at(const Vec3v& texel) const {
    return deviations.some() ? deviations.at(texel) : hn::Zero(kFloats);
  }

  const typename Layout::Texels texels;
  const Samples samples;
  const typename Layout::Deviations deviations;
};

/// What all rays of a batch go through: its bricks, and what their values are in the function.
template <typename Layout>
struct Bricks {
  using Samples = typename BrickOf<Layout>::Samples;

  HWY_INLINE Bricks(const FrameView& frame, const StretchBatch& batch)
      : edge(static_cast<int>(batch.m)),
        fine(batch, batch.fine),
        coarse(batch, batch.blended ? batch.coarse : batch.fine),
        function(frame.visibility.functions[0]),
        places(edge),
        to_entry_scale(all(function.entries_per_value() * Samples::kUnit)),
        to_entry_offset(all(function.first_entry())) {}

  HWY_INLINE Float entry_of(Float value) const {
    return entry_or_none<kMayLack<typename Layout::Voxel>>(
        hn::MulAdd(value, to_entry_scale, to_entry_offset));
  }

  const int edge;
  const BrickOf<Layout> fine, coarse;
  const Function function;
  const PlacesInside places;
  const Float to_entry_scale, to_entry_offset;
};

/// The rays of a vector, and what they go through. kPlain_: one brick whose voxels deviate from nothing.
template <typename Layout, bool kPlain_>
class Rays {
 public:
  static constexpr bool kPlain = kPlain_, kLacks = kMayLack<typename Layout::Voxel>;

  using Lights = Shading<std::is_integral_v<typename Layout::Voxel>>;

  HWY_INLINE Rays(const FrameView& frame, const Lights& lights, StretchBatch& batch, const StepRuns& runs,
                  const Bricks<Layout>& bricks, const std::int32_t* rows, std::size_t count)
      : frame_(frame),
        lights_(lights),
        batch_(batch),
        bricks_(bricks),
        lanes_(batch, rows, count),
        fine_(lanes_.fine(batch)),
        first_texel_(in_texels(fine_.first)),
        coarse_(!kPlain && batch.blended ? lanes_.coarse(batch) : fine_),
        first_coarse_texel_(in_texels(coarse_.first)),
        to_eye_(lights.lit() ? lanes_.to_eye(batch) : fine_.first) {
    lanes_.find_ends(batch, runs, fine_, first_step_, end_);
    lanes_.load(batch, color_, opacity_);
    if (lights.lit()) lights.find_halves(to_eye_, halves_);
  }

  HWY_INLINE const BatchLanes& lanes() const { return lanes_; }
  /// Steps: the first, and the one behind the last.
  HWY_INLINE Float first() const { return first_step_; }
  HWY_INLINE Float end() const { return end_; }
  HWY_INLINE Mask going() const { return hn::Lt(opacity_, all(kOpaque)); }
  HWY_INLINE void count_samples(Mask mask) {
    samples_ = hn::Sub(samples_, hn::VecFromMask(kInts, hn::RebindMask(kInts, mask)));
  }
  HWY_INLINE void store() { lanes_.store(batch_, color_, opacity_, samples_); }

  /// The places i of several vectors of rays.
  template <int kVectors>
  HWY_INLINE static void sample_all(const Rays (&rays)[kVectors], const Float (&i)[kVectors],
                                    EntrySample (&places)[kVectors]) {
    Vec3v texel[kVectors];
    for (int k = 0; k < kVectors; ++k) texel[k] = rays[k].texel_at(i[k]);
    CellSample samples[kVectors];
    rays[0].bricks_.fine.samples.find(texel, samples);
    for (int k = 0; k < kVectors; ++k) places[k] = rays[k].place_of(i[k], texel[k], samples[k].value);
  }
  HWY_NOINLINE EntrySample at(Float i) const {
    const Vec3v texel[1] = {texel_at(i)};
    CellSample samples[1];
    bricks_.fine.samples.find(texel, samples);
    return place_of(i, texel[0], samples[0].value);
  }

  /// Function::length.
  HWY_INLINE Float length(const EntrySample& from, const EntrySample& to) const {
    return bricks_.function.length(from.entry, to.entry);
  }
  /// By a step's or a span's matter and how far it goes through the function.
  HWY_INLINE Pieces cuts(Float extinction, Float longest) const {
    return cuts_of(adds_in_step(extinction), longest);
  }
  HWY_INLINE Pieces parts(Float extinction, Float units, Float longest) const {
    return parts_of(adds_in(extinction, units), longest);
  }
  /// Steps of more than one piece.
  HWY_INLINE Mask is_cut(Float extinction, Float units, Float longest) const {
    return hn::Gt(hn::Max(cuts_wanted(adds_in_step(extinction), longest),
                          parts_wanted(adds_in(extinction, units), longest)),
                  all(1));
  }

  /// see_span of one part, whose middle is at place i: of the lanes of `mask`.
  HWY_INLINE void see(const Matter& m, Float units, Float i, Mask mask, Seen& seen) {
    mask = hn::And(hn::And(mask, going()), hn::Gt(m.part[3], hn::Zero(kFloats)));
    const Float weight = hn::IfThenElseZero(mask, hn::Mul(left(), opacity_of(hn::Mul(m.part[3], units))));
    const Float of_color = hn::Div(weight, hn::IfThenElse(mask, m.part[3], all(1)));
    seen.color = {hn::MulAdd(of_color, m.part[0], seen.color.x),
                  hn::MulAdd(of_color, m.part[1], seen.color.y),
                  hn::MulAdd(of_color, m.part[2], seen.color.z)};
    seen.weight = hn::Add(seen.weight, weight);
    seen.moment = hn::MulAdd(weight, i, seen.moment);
    opacity_ = hn::Add(opacity_, weight);
  }

  HWY_INLINE bool is_lit() const { return lights_.lit(); }
  HWY_INLINE bool by_gradient() const { return frame_.visibility.functions[0].gradient_factor != nullptr; }

  HWY_INLINE void add_lit(Float i, const Slope& slope, const Seen& seen) {
    if (!is_lit()) return add(seen);
    const Shade light = shade_at(i, slope);
    // Where nothing is seen shades may be anything.
    const Mask some = hn::Gt(seen.weight, hn::Zero(kFloats));
    HWY_NAMESPACE::add_lit(some, seen.color, seen.weight, light, color_);
  }
  HWY_INLINE void add(const Seen& seen) {
    color_ = {hn::Add(color_.x, seen.color.x), hn::Add(color_.y, seen.color.y),
              hn::Add(color_.z, seen.color.z)};
  }

  /// Place i of the steps with these centres, or the last on the way there that is in the centre's voxel.
  HWY_INLINE Float held(Float centre, Float i) const { return held_in_voxel<kLacks>(fine_, centre, i); }
  HWY_NOINLINE Slope slope_at(Float i) const {
    Slope slope{gradient(bricks_.fine.texels, bricks_.edge, fine_.at(i)), hn::Zero(kFloats)};
    if constexpr (!kPlain) {
      if (batch_.blended) blend_in(gradient(bricks_.coarse.texels, bricks_.edge, coarse_.at(i)), i, slope);
    }
    slope.gradient = or_none<kLacks>(slope.gradient);
    return slope;
  }

  HWY_NOINLINE Float factor_of(const Slope& slope) const {
    Float across = all(batch_.fine.voxels_across);
    if constexpr (!kPlain) {
      if (batch_.blended) across = mix(across, all(batch_.coarse.voxels_across), slope.blend);
    }
    const Float length = hn::Sqrt(lights_.world_length2(slope.gradient));
    return bricks_.function.factor_of_gradient(hn::Mul(length, across));
  }

 private:
  /// Place i, in texels of a plain brick: in it, or the nearest to it that is.
  HWY_INLINE Vec3v texel_at(Float i) const {
    return bricks_.places.held(along(first_texel_, fine_.per_step, i));
  }
  /// Place i, which is at this texel of the fine brick and has this value there.
  HWY_INLINE EntrySample place_of(Float i, const Vec3v& texel, Float value) const {
    if constexpr (kPlain) return {bricks_.entry_of(value), hn::Zero(kFloats)};
    Float deviates = bricks_.fine.deviation_at(texel);
    if (batch_.blended) {
      const Vec3v coarse_texel[1] = {bricks_.places.held(along(first_coarse_texel_, coarse_.per_step, i))};
      CellSample coarse[1];
      bricks_.coarse.samples.find(coarse_texel, coarse);
      const Float blend = share_at(coarse_, i);
      value = blended<kLacks>(value, coarse[0].value, blend);
      deviates = mix(deviates, bricks_.coarse.deviation_at(coarse_texel[0]), blend);
    }
    return {bricks_.entry_of(value), bricks_.function.to_entries(deviates)};
  }
  /// How much opacity, about.
  HWY_INLINE Float adds_in_step(Float extinction) const {
    return hn::Mul(left(), hn::Min(hn::Mul(extinction, all(batch_.units)), all(1)));
  }
  HWY_INLINE Float adds_in(Float extinction, Float units) const {
    return hn::Mul(left(), hn::Mul(extinction, units));
  }
  HWY_INLINE Float left() const { return hn::Sub(all(1), opacity_); }

  HWY_INLINE void blend_in(const Vec3v& coarse, Float i, Slope& slope) const {
    slope.blend = share_at(coarse_, i);
    slope.gradient = blended<kLacks>(slope.gradient, coarse, slope.blend);
  }

  HWY_NOINLINE Shade shade_at(Float i, const Slope& slope) const {
    Float scale = all(batch_.fine.gradient_scale);
    if constexpr (!kPlain) {
      if (batch_.blended) scale = mix(scale, all(batch_.coarse.gradient_scale), slope.blend);
    }
    return lights_.shade(0, slope.gradient, scale, to_eye_, halves_,
                         [&]() HWY_ATTR { return lanes_.places(batch_).at(i); });
  }

  const FrameView& frame_;
  const Lights& lights_;
  StretchBatch& batch_;
  const Bricks<Layout>& bricks_;
  const BatchLanes lanes_;
  const PathRows fine_;
  const Vec3v first_texel_;  // fine_.first
  const PathRows coarse_;
  const Vec3v first_coarse_texel_;  // coarse_.first
  const Vec3v to_eye_;
  typename Lights::FarHalves halves_;
  Float first_step_, end_;
  Vec3v color_;
  Float opacity_;
  Int samples_ = hn::Zero(kInts);
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
