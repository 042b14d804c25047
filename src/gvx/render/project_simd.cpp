// project_batch: projection.h once more, with a ray in each lane of a vector. Compiled once for each
// instruction set.

#include "gvx/render/simd_targets.h"
#include "gvx/render/stretch.h"
#include "gvx/render/stretch_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/project_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/batch_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// One channel of the rays of two vectors, whose `gathered` it goes on from; `first`: nothing was gathered
/// yet.
template <scene::Mode kMode, typename Texels>
HWY_INLINE void project_channel(const FrameView& frame, const StretchBatch& batch,
                                const BatchLanes (&lanes)[2], const Texels& fine, const Texels& coarse,
                                const Mask (&first)[2], Float (&gathered)[2]) {
  const int edge = static_cast<int>(batch.m);
  const Float ticks = all(static_cast<float>(frame.stride[batch.level]));
  const PathRows path[2] = {lanes[0].fine(batch), lanes[1].fine(batch)};
  const Float end[2] = {lanes[0].steps(path[0]), lanes[1].steps(path[1])};
  const float last = hn::GetLane(hn::MaxOfLanes(kFloats, hn::Max(end[0], end[1])));
  for (float step = 0; step < last; step += 1) {
    const Float i = all(step);
    for (int k = 0; k < 2; ++k) {
      Float value = sample(fine, edge, path[k].at(i));
      if (batch.blended) {
        const PathRows coarse_path = lanes[k].coarse(batch);
        const Float share = hn::MulAdd(i, coarse_path.eighth, coarse_path.fourth);
        const Float blend = hn::Min(hn::Max(share, hn::Zero(kFloats)), all(1));
        value = mix(value, sample(coarse, edge, coarse_path.at(i)), blend);
      }
      Float taken;
      if constexpr (kMode == scene::Mode::mean) {
        taken = hn::Add(gathered[k], hn::Mul(ticks, value));
      } else {
        const Mask begins = step == 0 ? first[k] : hn::Lt(end[k], hn::Zero(kFloats));
        taken = kMode == scene::Mode::maximum ? hn::Max(gathered[k], value) : hn::Min(gathered[k], value);
        taken = hn::IfThenElse(begins, value, taken);
      }
      gathered[k] = hn::IfThenElse(hn::Lt(i, end[k]), taken, gathered[k]);
    }
  }
}

template <scene::Mode kMode, typename Voxel>
void project_mode(const FrameView& frame, StretchBatch& batch) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  const std::size_t plane_bytes = plane_texels(batch.m) * sizeof(Voxel);
  batch.opaque_count = 0;
  batch.put_in_order();
  for (std::size_t lane = 0; lane < batch.count; lane += 2 * kLanes) {
    const BatchLanes lanes[2] = {{batch, lane}, {batch, lane + kLanes}};
    Float gathered[4][2];
    Mask first[2];
    Int samples[2];
    for (int k = 0; k < 2; ++k) {
      Vec3v color;
      lanes[k].load(batch, color, gathered[3][k]);
      gathered[0][k] = color.x;
      gathered[1][k] = color.y;
      gathered[2][k] = color.z;
      first[k] = lanes[k].without_samples(batch);
      samples[k] = hn::ConvertTo(kInts, lanes[k].steps(lanes[k].fine(batch)));
    }
    for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
      const PlainTexels<Voxel> fine(batch.fine.brick + c * plane_bytes);
      const PlainTexels<Voxel> coarse(batch.blended ? batch.coarse.brick + c * plane_bytes : nullptr);
      project_channel<kMode>(frame, batch, lanes, fine, coarse, first, gathered[c]);
    }
    for (int k = 0; k < 2; ++k) {
      lanes[k].store(batch, {gathered[0][k], gathered[1][k], gathered[2][k]}, gathered[3][k], samples[k]);
    }
  }
  batch.opaque_count = 0;  // what was gathered is no opacity
}

template <typename Voxel>
void project_of(const FrameView& frame, StretchBatch& batch) {
  switch (frame.visibility.mode) {
    case scene::Mode::maximum:
      return project_mode<scene::Mode::maximum, Voxel>(frame, batch);
    case scene::Mode::minimum:
      return project_mode<scene::Mode::minimum, Voxel>(frame, batch);
    default:
      return project_mode<scene::Mode::mean, Voxel>(frame, batch);
  }
}

}  // namespace

void project_u8(const FrameView& frame, StretchBatch& batch) {
  project_of<std::uint8_t>(frame, batch);
}
void project_u16(const FrameView& frame, StretchBatch& batch) {
  project_of<std::uint16_t>(frame, batch);
}
void project_f32(const FrameView& frame, StretchBatch& batch) {
  project_of<float>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(project_u8);
HWY_EXPORT(project_u16);
HWY_EXPORT(project_f32);

void project_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return HWY_DYNAMIC_DISPATCH(project_u8)(frame, batch);
    case VoxelType::u16:
      return HWY_DYNAMIC_DISPATCH(project_u16)(frame, batch);
    case VoxelType::f32:
      return HWY_DYNAMIC_DISPATCH(project_f32)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
