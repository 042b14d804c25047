// project_batch: what projection.h does, with a ray in each lane of a vector. Compiled once for each
// instruction set.

#include "gvx/render/reference/projection.h"
#include "gvx/render/reference/stretch.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/projection_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/batch_simd-inl.h"
#include "gvx/render/vectors/deviation_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/projection.inc"

/// The greatest or least values of what a channel's samples stand for.
class Extremes {
 public:
  HWY_INLINE Extremes(const FrameView& frame, const StretchBatch& batch, std::uint32_t channel)
      : extreme_(frame.extreme[channel]),
        range_(frame.visibility.widened(batch.ranges.channel[channel])),
        places_(static_cast<int>(batch.m)),
        fine_(deviations(frame, batch, channel, batch.fine)),
        coarse_(deviations(frame, batch, channel, batch.blended ? batch.coarse : batch.fine)) {}

  HWY_INLINE Float fine_deviation(const Vec3v& p) const { return deviation(fine_, p); }
  HWY_INLINE Float coarse_deviation(const Vec3v& p) const { return deviation(coarse_, p); }

  template <bool kLacks>
  HWY_INLINE Float of(Float value, Float deviation) const {
    return extreme_of<kLacks>(extreme_, range_, value, deviation);
  }

 private:
  static PlainDeviations deviations(const FrameView& frame, const StretchBatch& batch, std::uint32_t channel,
                                    const StretchBatch::Path& path) {
    const std::size_t planes = frame.format.planes * plane_texels(batch.m) * voxel_bytes(frame.format.type);
    const std::byte* plane = path.brick + planes + channel * deviation_bytes(batch.m);
    return {path.deviates ? reinterpret_cast<const std::uint8_t*>(plane) : nullptr,
            static_cast<int>(batch.m)};
  }
  HWY_INLINE Float deviation(const PlainDeviations& deviations, const Vec3v& p) const {
    return deviations.some() ? deviations.at(places_.held(in_texels(p))) : hn::Zero(kFloats);
  }

  const FrameView::Extreme extreme_;
  const ValueRange range_;
  const PlacesInside places_;
  const PlainDeviations fine_, coarse_;
};

/// One channel of the rays of two vectors, whose `gathered` it goes on from; `first`: nothing was gathered
/// yet. Of means of what may be no data, `without` are the ticks that were none. kDeviates: coarse voxels
/// stand for more than their mean.
template <scene::Mode kMode, bool kDeviates, typename Texels>
HWY_INLINE void project_channel(const FrameView& frame, const StretchBatch& batch, std::uint32_t channel,
                                const BatchLanes (&lanes)[2], const Texels& fine, const Texels& coarse,
                                const Mask (&first)[2], Float (&gathered)[2],
                                [[maybe_unused]] Float (&without)[2]) {
  constexpr bool kLacks = !Texels::kWhole, kMean = kMode == scene::Mode::mean;
  const Extremes extremes(frame, batch, channel);
  const int edge = static_cast<int>(batch.m);
  const Float ticks = all(static_cast<float>(frame.stride[batch.level]));
  const PathRows path[2] = {lanes[0].fine(batch), lanes[1].fine(batch)};
  const Float end[2] = {lanes[0].steps(path[0]), lanes[1].steps(path[1])};
  const float last = hn::GetLane(hn::MaxOfLanes(kFloats, hn::Max(end[0], end[1])));
  for (int k = 0; k < 2; ++k) gathered[k] = begun<kLacks>(kMode, gathered[k], first[k]);
  for (float step = 0; step < last; step += 1) {
    const Float i = all(step);
    for (int k = 0; k < 2; ++k) {
      Float value = sample(fine, edge, path[k].at(i)), deviation = hn::Zero(kFloats);
      if constexpr (kDeviates) deviation = extremes.fine_deviation(path[k].at(i));
      if (batch.blended) {
        const PathRows coarse_path = lanes[k].coarse(batch);
        const Float blend = share_at(coarse_path, i);
        value = blended<kLacks>(value, sample(coarse, edge, coarse_path.at(i)), blend);
        if constexpr (kDeviates) {
          deviation = mix(deviation, extremes.coarse_deviation(coarse_path.at(i)), blend);
        }
      }
      if constexpr (kDeviates) value = extremes.template of<kLacks>(value, deviation);
      const Mask under_way = hn::Lt(i, end[k]);
      const Float taken = taken_in<kLacks>(kMode, gathered[k], value, ticks);
      if constexpr (kLacks && kMean) {
        const Mask lacks = hn::And(under_way, is_no_data(value));
        without[k] = hn::Add(without[k], hn::IfThenElseZero(lacks, ticks));
      }
      gathered[k] = hn::IfThenElse(under_way, taken, gathered[k]);
    }
  }
  for (int k = 0; k < 2; ++k) gathered[k] = ended<kLacks>(kMode, gathered[k]);
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
    const std::uint32_t channels = frame.visibility.channels;
    // ticks_without_data: there is room for those of two channels.
    Float nowhere[2] = {hn::Zero(kFloats), hn::Zero(kFloats)};
    for (std::uint32_t c = 0; c < channels; ++c) {
      Float(&without)[2] = channels <= 2 ? gathered[channels + c] : nowhere;
      const PlainTexels<Voxel> fine(batch.fine.brick + c * plane_bytes, static_cast<int>(batch.m));
      const PlainTexels<Voxel> coarse(batch.blended ? batch.coarse.brick + c * plane_bytes : nullptr,
                                      static_cast<int>(batch.m));
      if (scene::seeks_extreme(kMode) && (batch.fine.deviates || batch.blended)) {
        project_channel<kMode, true>(frame, batch, c, lanes, fine, coarse, first, gathered[c], without);
      } else {
        project_channel<kMode, false>(frame, batch, c, lanes, fine, coarse, first, gathered[c], without);
      }
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
