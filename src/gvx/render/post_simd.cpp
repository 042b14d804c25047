// composite_post_batch: post_classified.h once more, with a ray in each lane of a vector. All lanes step side
// by side: no address waits for what was gathered. Compiled once for each instruction set.

#include "gvx/render/simd_targets.h"
#include "gvx/render/stretch.h"
#include "gvx/render/stretch_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/post_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/sample_simd-inl.h"
#include "gvx/render/shade_simd-inl.h"
#include "gvx/render/transfer_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// brick::CellSample.
struct Sample {
  Float value;
  Vec3v gradient;
};

template <typename Texels>
HWY_INLINE Sample cell_sample(const Texels& texels, int edge, const Vec3v& p, bool with_gradient) {
  const int row = edge + 2, slice = row * row;
  const TexelAxis x(p.x, edge), y(p.y, edge), z(p.z, edge);
  const Int index = hn::Add(x.low, hn::Add(hn::Mul(y.low, all_ints(row)), hn::Mul(z.low, all_ints(slice))));
  const Corners at = texels.read(index, row, slice);
  const auto& c = at.corner;
  const Float r00 = hn::Sub(c[1], c[0]), r10 = hn::Sub(c[3], c[2]);
  const Float r01 = hn::Sub(c[5], c[4]), r11 = hn::Sub(c[7], c[6]);
  const Float c00 = hn::MulAdd(x.weight, r00, c[0]), c10 = hn::MulAdd(x.weight, r10, c[2]);
  const Float c01 = hn::MulAdd(x.weight, r01, c[4]), c11 = hn::MulAdd(x.weight, r11, c[6]);
  const Float y0 = hn::Sub(c10, c00), y1 = hn::Sub(c11, c01);
  const Float c0 = hn::MulAdd(y.weight, y0, c00), c1 = hn::MulAdd(y.weight, y1, c01);
  const Float z0 = hn::Sub(c1, c0);
  Sample sample;
  sample.value = hn::MulAdd(z.weight, z0, c0);
  if (with_gradient) {
    sample.gradient = {mix(mix(r00, r10, y.weight), mix(r01, r11, y.weight), z.weight), mix(y0, y1, z.weight),
                       z0};
  }
  return sample;
}

/// The rays of a vector, and what they go through. kPlain: one brick; else two that are blended.
template <typename Texels, bool kPlain>
class Post {
 public:
  HWY_INLINE Post(const FrameView& frame, StretchBatch& batch, std::size_t lane, const Texels& fine,
                  const Texels& coarse)
      : frame_(frame),
        batch_(batch),
        function_(frame.visibility.functions[0]),
        lane_(lane),
        edge_(static_cast<int>(batch.m)),
        fine_(fine),
        coarse_(coarse) {}

  HWY_INLINE void run() {
    const FrameView& frame = frame_;
    const Int left = all_ints(static_cast<std::int32_t>(batch_.count - lane_));
    const Int steps =
        hn::IfThenElseZero(hn::Lt(hn::Iota(kInts, 0), left), hn::Load(kInts, batch_.steps + lane_));
    const auto most = static_cast<std::int32_t>(hn::GetLane(hn::MaxOfLanes(kInts, steps)));
    const Vec3v first = load(batch_.fine.first, lane_), per_step = load(batch_.fine.per_step, lane_);
    const bool lit = frame.lighting.lighting.enabled;
    const std::byte* table = reinterpret_cast<const std::byte*>(
        frame.step_colors + std::size_t(batch_.level) * scene::TransferView::kEntries);
    const bool all_cells = batch_.cells == ~std::uint64_t(0);
    const Float end = hn::ConvertTo(kFloats, steps), opaque = all(kOpaque), one = all(1);
    Int samples = hn::Load(kInts, batch_.samples + lane_);
    Vec3v color = load(batch_.color, lane_);
    Float opacity = hn::Load(kFloats, batch_.opacity + lane_);
    for (std::int32_t step = 0; step < most; ++step) {
      const Float i = all(static_cast<float>(step));
      Mask active = hn::And(hn::Lt(i, end), hn::Lt(opacity, opaque));
      if (none(active)) break;
      const Vec3v p = along(first, per_step, i);
      if (!all_cells) {
        active = hn::And(active, in_visible_cell(batch_.cells, edge_, p));
        if (none(active)) continue;
      }
      samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, active)));
      Sample sample = cell_sample(fine_, edge_, p, lit);
      Float blend;
      if constexpr (!kPlain) {
        blend = hn::MulAdd(i, hn::Load(kFloats, batch_.blend_per_step + lane_),
                           hn::Load(kFloats, batch_.blend + lane_));
        blend = hn::Min(hn::Max(blend, hn::Zero(kFloats)), one);
        const Vec3v q = along(load(batch_.coarse.first, lane_), load(batch_.coarse.per_step, lane_), i);
        const Sample coarse = cell_sample(coarse_, edge_, q, lit);
        sample.value = mix(sample.value, coarse.value, blend);
        if (lit) {
          sample.gradient = {mix(sample.gradient.x, coarse.gradient.x, blend),
                             mix(sample.gradient.y, coarse.gradient.y, blend),
                             mix(sample.gradient.z, coarse.gradient.z, blend)};
        }
      }
      const Float entry = function_.entry_of(sample.value);
      const Mask seen = hn::AndNot(function_.invisible(entry, entry), active);
      if (none(seen)) continue;
      alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
      static_assert(sizeof(StepColor) == 16);
      hn::Store(hn::ShiftLeft<4>(function_.nearest(entry)), kInts, offsets);
      Int bits[4];
      load_rows(table, offsets, bits);
      const auto number = [&](int k) HWY_ATTR { return hn::BitCast(kFloats, bits[k]); };
      const Float weight = hn::IfThenElseZero(seen, hn::Mul(hn::Sub(one, opacity), number(3)));
      if (lit) {
        const Shade light = shade_at(i, sample, kPlain ? hn::Zero(kFloats) : blend);
        const auto gather_color = [&](Float sum, Float color_of, Float body, Float glint) HWY_ATTR {
          return hn::IfThenElse(seen, hn::MulAdd(weight, hn::MulAdd(color_of, body, glint), sum), sum);
        };
        color.x = gather_color(color.x, number(0), light.body.x, light.glint.x);
        color.y = gather_color(color.y, number(1), light.body.y, light.glint.y);
        color.z = gather_color(color.z, number(2), light.body.z, light.glint.z);
      } else {
        color.x = hn::MulAdd(weight, number(0), color.x);
        color.y = hn::MulAdd(weight, number(1), color.y);
        color.z = hn::MulAdd(weight, number(2), color.z);
      }
      opacity = hn::Add(opacity, weight);
    }
    hn::Store(samples, kInts, batch_.samples + lane_);
    hn::Store(color.x, kFloats, batch_.color[0] + lane_);
    hn::Store(color.y, kFloats, batch_.color[1] + lane_);
    hn::Store(color.z, kFloats, batch_.color[2] + lane_);
    hn::Store(opacity, kFloats, batch_.opacity + lane_);
  }

 private:
  HWY_INLINE Shade shade_at(Float i, const Sample& sample, Float blend) const {
    Float scale = all(batch_.fine.gradient_scale);
    if constexpr (!kPlain) scale = mix(scale, all(batch_.coarse.gradient_scale), blend);
    const Vec3v relative = scaled(all(1 / frame_.soft_gradient[0]), sample.gradient);
    return shade(frame_, relative, scale, load(batch_.to_eye, lane_), [&]() HWY_ATTR {
      return along(load(batch_.place, lane_), load(batch_.place_per_step, lane_), i);
    });
  }

  const FrameView& frame_;
  StretchBatch& batch_;
  const Function function_;
  const std::size_t lane_;
  const int edge_;
  const Texels &fine_, &coarse_;
};

template <bool kPlain, typename Texels>
void post_all(const FrameView& frame, StretchBatch& batch, const Texels& fine, const Texels& coarse) {
  for (std::size_t lane = 0; lane < batch.count; lane += hn::Lanes(kFloats)) {
    Post<Texels, kPlain>(frame, batch, lane, fine, coarse).run();
  }
}

template <typename Voxel>
void post_of(const FrameView& frame, StretchBatch& batch) {
  const PlainTexels<Voxel> fine(batch.fine.brick), coarse(batch.coarse.brick);
  if (batch.blended) {
    post_all<false>(frame, batch, fine, coarse);
  } else {
    post_all<true>(frame, batch, fine, coarse);
  }
}

}  // namespace

void post_u8(const FrameView& frame, StretchBatch& batch) {
  if (batch.blended || !pairs_rows(batch)) return post_of<std::uint8_t>(frame, batch);
  const PairedRows rows{batch.row_pairs};
  post_all<true>(frame, batch, rows, rows);
}
void post_u16(const FrameView& frame, StretchBatch& batch) {
  post_of<std::uint16_t>(frame, batch);
}
void post_f32(const FrameView& frame, StretchBatch& batch) {
  post_of<float>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(post_u8);
HWY_EXPORT(post_u16);
HWY_EXPORT(post_f32);

void composite_post_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return HWY_DYNAMIC_DISPATCH(post_u8)(frame, batch);
    case VoxelType::u16:
      return HWY_DYNAMIC_DISPATCH(post_u16)(frame, batch);
    case VoxelType::f32:
      return HWY_DYNAMIC_DISPATCH(post_f32)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
