// find_surface_batch: what isosurface.h does, with a ray in each lane of a vector. Compiled once for each
// instruction set.

#include "gvx/render/reference/stretch.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/isosurface_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/batch_simd-inl.h"
#include "gvx/render/vectors/gradient_simd-inl.h"
#include "gvx/render/vectors/shade_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/isosurface.inc"

template <typename Voxel>
class SurfaceFinder {
  static constexpr bool kLacks = kMayLack<Voxel>;

 public:
  using Lights = Shading<std::is_integral_v<Voxel>>;

  HWY_INLINE SurfaceFinder(const FrameView& frame, const Lights& lights, StretchBatch& batch,
                           std::size_t lane)
      : frame_(frame),
        lights_(lights),
        batch_(batch),
        lanes_(batch, lane),
        edge_(static_cast<int>(batch.m)),
        fine_(lanes_.fine(batch)),
        coarse_(batch.blended ? lanes_.coarse(batch) : fine_) {}

  HWY_INLINE void run() {
    const Float end = lanes_.steps(fine_), zero = hn::Zero(kFloats);
    const float last = hn::GetLane(hn::MaxOfLanes(kFloats, end));
    Int samples = hn::Zero(kInts);
    Mask found = hn::Lt(zero, zero);
    Float step_found = zero, front_found = zero, back_found = zero;
    Float front = value_at(all(-0.5f));
    for (float step = 0; step < last; step += 1) {
      const Mask active = hn::AndNot(found, hn::Lt(all(step), end));
      if (none(active)) break;
      const Float back = value_at(all(step + 0.5f));
      samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, active)));
      const Mask crossed = hn::And(active, crosses<kLacks>(front, back));
      step_found = hn::IfThenElse(crossed, all(step), step_found);
      front_found = hn::IfThenElse(crossed, front, front_found);
      back_found = hn::IfThenElse(crossed, back, back_found);
      found = hn::Or(found, crossed);
      front = back;
    }
    Vec3v color;
    Float opacity;
    lanes_.load(batch_, color, opacity);
    if (!none(found)) {
      const Float hit = crossing<kLacks>(step_found, front_found, back_found, found,
                                         [&](Float i) HWY_ATTR { return value_at(i); });
      const Vec3f& iso = frame_.iso_color;
      const Vec3v shown = lit_by(shade_at(step_found, hit), {all(iso.x), all(iso.y), all(iso.z)});
      put_behind(found, shown, all(1), color, opacity);
    }
    lanes_.store(batch_, color, opacity, samples);
  }

 private:
  /// Above the isovalue.
  GVX_PIECE Float value_at(Float i) const {
    Float value = sample(PlainTexels<Voxel>(batch_.fine.brick, edge_), edge_, fine_.at(i));
    if (batch_.blended) {
      const Float coarse = sample(PlainTexels<Voxel>(batch_.coarse.brick, edge_), edge_, coarse_.at(i));
      value = blended<kLacks>(value, coarse, share_at(coarse_, i));
    }
    return hn::Sub(value, all(frame_.visibility.isovalue));
  }

  HWY_INLINE Shade shade_at(Float centre, Float hit) const {
    const Float zero = hn::Zero(kFloats), one = all(1);
    if (!lights_.lit()) return {{one, one, one}, {zero, zero, zero}};
    const Float lit = held_in_voxel<kLacks>(fine_, centre, hit);
    Vec3v g = gradient(PlainTexels<Voxel>(batch_.fine.brick, edge_), edge_, fine_.at(lit));
    if (batch_.blended) {
      const Vec3v coarse = gradient(PlainTexels<Voxel>(batch_.coarse.brick, edge_), edge_, coarse_.at(lit));
      g = blended<kLacks>(g, coarse, share_at(coarse_, lit));
    }
    g = or_none<kLacks>(g);
    const Vec3v to_eye = lanes_.to_eye(batch_);
    typename Lights::FarHalves halves;
    lights_.find_halves(to_eye, halves);
    // A surface for certain.
    return lights_.shade(0, g, all(1e15f), to_eye, halves,
                         [&]() HWY_ATTR { return lanes_.places(batch_).at(hit); });
  }

  const FrameView& frame_;
  const Lights& lights_;
  StretchBatch& batch_;
  const BatchLanes lanes_;
  const int edge_;
  const PathRows fine_, coarse_;
};

template <typename Voxel>
void find_surfaces(const FrameView& frame, StretchBatch& batch) {
  batch.opaque_count = 0;
  batch.put_in_order();
  const typename SurfaceFinder<Voxel>::Lights lights(frame);
  for (std::size_t lane = 0; lane < batch.count; lane += hn::Lanes(kFloats)) {
    SurfaceFinder<Voxel>(frame, lights, batch, lane).run();
  }
}

}  // namespace

void find_surfaces_u8(const FrameView& frame, StretchBatch& batch) {
  find_surfaces<std::uint8_t>(frame, batch);
}
void find_surfaces_u16(const FrameView& frame, StretchBatch& batch) {
  find_surfaces<std::uint16_t>(frame, batch);
}
void find_surfaces_f32(const FrameView& frame, StretchBatch& batch) {
  find_surfaces<float>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(find_surfaces_u8);
HWY_EXPORT(find_surfaces_u16);
HWY_EXPORT(find_surfaces_f32);

void find_surface_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return HWY_DYNAMIC_DISPATCH(find_surfaces_u8)(frame, batch);
    case VoxelType::u16:
      return HWY_DYNAMIC_DISPATCH(find_surfaces_u16)(frame, batch);
    case VoxelType::f32:
      return HWY_DYNAMIC_DISPATCH(find_surfaces_f32)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
