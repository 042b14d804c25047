// composite_channels_batch: several channels, with a ray in each lane of a vector: what formula/composite.inc
// asks of rays. Compiled once for each instruction set.

#include <type_traits>

#include "gvx/render/reference/composite.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/composite_channels_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/composite_rays_simd-inl.h"
#include "gvx/render/vectors/each_step_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/composite.inc"

/// The rays of a vector on their way through a brick, as Compositing asks for them.
template <typename Voxel>
class Channels {
 public:
  static constexpr bool kWhole = std::is_integral_v<Voxel>, kLacks = kMayLack<Voxel>;

  HWY_INLINE Channels(const FrameView& frame, const Shading<kWhole>& lights, const StretchBatch& batch,
                      const BatchLanes& lanes)
      : visibility_(frame.visibility),
        planes_(frame.format.planes),
        batch_(batch),
        rays_(lights, batch, lanes),
        edge_(static_cast<int>(batch.m)),
        functions_{Function(visibility_.functions[0]), Function(visibility_.functions[1]),
                   Function(visibility_.functions[2]), Function(visibility_.functions[3])} {
    static_assert(kMaxChannels == 4);
    for (std::uint32_t c = 0; c < channels(); ++c) by_gradient_ = by_gradient_ || functions_[c].by_gradient();
  }

  HWY_INLINE std::uint32_t channels() const { return visibility_.channels; }
  HWY_INLINE const Function& function(std::uint32_t channel) const { return functions_[channel]; }
  HWY_INLINE bool by_gradient() const { return by_gradient_; }
  HWY_INLINE bool lit() const { return rays_.lit(); }
  HWY_INLINE const PathRows& fine() const { return rays_.fine; }
  HWY_INLINE Int samples() const { return samples_; }

  HWY_NOINLINE void sample(Float i, Mask counted, EntrySample (&places)[kMaxChannels]) {
    const Vec3v p = rays_.fine.at(i), q = rays_.coarse.at(i);
    const Float blend = blend_at(i);
    for (std::uint32_t c = 0; c < channels(); ++c) {
      Float value = HWY_NAMESPACE::sample(texels(batch_.fine, c), edge_, p), deviates = hn::Zero(kFloats);
      if (batch_.fine.deviates) deviates = deviation_at(batch_.fine, c, p);
      if (batch_.blended) {
        value = blended<kLacks>(value, HWY_NAMESPACE::sample(texels(batch_.coarse, c), edge_, q), blend);
        deviates = mix(deviates, deviation_at(batch_.coarse, c, q), blend);
      }
      places[c] = {entry_or_none<kLacks>(functions_[c].entry_of(value)), functions_[c].to_entries(deviates)};
    }
    samples_ = hn::Sub(samples_, hn::VecFromMask(kInts, hn::RebindMask(kInts, counted)));
  }
  HWY_INLINE Float held(Float centre, Float i) const { return held_in_voxel<kLacks>(rays_.fine, centre, i); }
  HWY_INLINE Float blend_at(Float i) const { return rays_.blend_at(i); }
  GVX_PIECE Vec3v gradient(std::uint32_t channel, Float i, Float blend) const {
    Vec3v slope = HWY_NAMESPACE::gradient(texels(batch_.fine, channel), edge_, rays_.fine.at(i));
    if (batch_.blended) {
      const Texels coarse = texels(batch_.coarse, channel);
      slope = blended<kLacks>(slope, HWY_NAMESPACE::gradient(coarse, edge_, rays_.coarse.at(i)), blend);
    }
    return or_none<kLacks>(slope);
  }
  HWY_INLINE Float factor_of(const Function& function, const Vec3v& gradient, Float blend) const {
    return rays_.factor_of(function, gradient, blend);
  }
  HWY_INLINE Shade shade(Float i, std::uint32_t channel, const Vec3v& gradient, Float blend) const {
    return rays_.shade(i, channel, gradient, blend);
  }

 private:
  using Path = StretchBatch::Path;
  using Texels = PlainTexels<Voxel>;

  HWY_INLINE Texels texels(const Path& path, std::uint32_t channel) const {
    return {path.brick + channel * plane_texels(batch_.m) * sizeof(Voxel), edge_};
  }
  HWY_INLINE Float deviation_at(const Path& path, std::uint32_t channel, const Vec3v& p) const {
    const std::byte* first = path.brick + planes_ * plane_texels(batch_.m) * sizeof(Voxel);
    const std::byte* deviations = first + channel * deviation_bytes(static_cast<std::size_t>(edge_));
    const PlainDeviations plane(reinterpret_cast<const std::uint8_t*>(deviations), edge_);
    return plane.some() ? plane.at(PlacesInside(edge_).held(in_texels(p))) : hn::Zero(kFloats);
  }

  const scene::Visibility& visibility_;
  const std::uint32_t planes_;
  const StretchBatch& batch_;
  const StepRays<kWhole> rays_;
  const int edge_;
  const Function functions_[kMaxChannels];
  bool by_gradient_ = false;
  Int samples_ = hn::Zero(kInts);
};

template <typename Voxel>
void composite_all(const FrameView& frame, StretchBatch& batch) {
  const Shading<std::is_integral_v<Voxel>> lights(frame);
  batch.opaque_count = 0;
  batch.put_in_order();
  for (std::size_t lane = 0; lane < batch.count; lane += hn::MaxLanes(kFloats)) {
    const BatchLanes lanes(batch, lane);
    Vec3v color;
    Float opacity;
    lanes.load(batch, color, opacity);
    Channels<Voxel> channels(frame, lights, batch, lanes);
    Compositing<Channels<Voxel>, kMaxChannels> compositing(channels, batch.units, color, opacity);
    compositing.run(lanes.steps(channels.fine()));
    lanes.store(batch, compositing.color(), compositing.opacity(), channels.samples());
  }
}

}  // namespace

void channels_u8(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint8_t>(frame, batch);
}
void channels_u16(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint16_t>(frame, batch);
}
void channels_f32(const FrameView& frame, StretchBatch& batch) {
  composite_all<float>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(channels_u8);
HWY_EXPORT(channels_u16);
HWY_EXPORT(channels_f32);

void composite_channels_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return HWY_DYNAMIC_DISPATCH(channels_u8)(frame, batch);
    case VoxelType::u16:
      return HWY_DYNAMIC_DISPATCH(channels_u16)(frame, batch);
    case VoxelType::f32:
      return HWY_DYNAMIC_DISPATCH(channels_f32)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
