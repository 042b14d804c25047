/// \file
/// composite_post_batch: what post_classified.h does, with a ray in each lane of a vector. All lanes step
/// side by side: no address waits for what was gathered. Compiled once for each instruction set, a source a
/// voxel type (post_classified_u8_simd.cpp and its kin).

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_POST_CLASSIFIED_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_POST_CLASSIFIED_SIMD_INL_H
#undef GVX_RENDER_POST_CLASSIFIED_SIMD_INL_H
#else
#define GVX_RENDER_POST_CLASSIFIED_SIMD_INL_H
#endif

// Before any of Highway.
// clang-format off
#include "gvx/render/vectors/simd_targets.h"
// clang-format on

#include <bit>
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/render/reference/stretch.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/each_step_simd-inl.h"
#include "gvx/render/vectors/quads_simd-inl.h"
#include "gvx/render/vectors/visible_steps_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// What lights there are; one: by Shading::by_one.
enum class Lit { no, by_one, by_any };

/// Which rows of FrameView::step_colors values are classified by: Function::nearest, in fewer operations.
class StepRows {
 public:
  /// Of values in multiples of `unit`.
  HWY_INLINE StepRows(const scene::TransferView& function, float unit)
      : StepRows(function, unit, function.entries <= kUsual ? kUsual : kMost) {}

  /// The entry, half an entry and what entries are told from.
  HWY_INLINE Float place_of(Float value) const { return hn::MulAdd(value, scale_, offset_); }
  HWY_INLINE Mask visible(Float place) const {
    return hn::And(hn::Gt(place, first_visible_), hn::Lt(place, last_visible_));
  }
  /// In bytes. Whatever place is no number has one, too.
  HWY_INLINE Int offset_of(Float place) const {
    const Int held = hn::Min(hn::Max(hn::BitCast(kInts, place), first_), last_);
    return hn::And(hn::ShiftRightSame(held, fraction_bits_ - kRowBits), rows_);
  }

 private:
  static constexpr int kUsual = 8192, kMost = scene::TransferView::kMostEntries, kRowBits = 4;
  static_assert(scene::TransferView::kEntries <= kUsual && sizeof(StepColor) == 1 << kRowBits);

  /// From `base` on a float's last bits are the fraction of an entry; those before them are a whole number.
  HWY_INLINE StepRows(const scene::TransferView& function, float unit, int base)
      : scale_(all(function.to_entry_scale * unit)),
        offset_(all(static_cast<float>(base) + 0.5f + function.to_entry_offset)),
        first_visible_(all(static_cast<float>(base) + 0.5f + function.first_visible)),
        last_visible_(all(static_cast<float>(base) + 0.5f + function.last_visible)),
        first_(hn::BitCast(kInts, all(static_cast<float>(base)))),
        last_(hn::BitCast(kInts, all(static_cast<float>(base + function.entries - 1)))),
        rows_(all_ints((base - 1) << kRowBits)),
        fraction_bits_(23 - std::countr_zero(static_cast<unsigned>(base))) {}

  const Float scale_, offset_, first_visible_, last_visible_;
  const Int first_, last_, rows_;
  const int fraction_bits_;
};

/// The rays of so many vectors, and what they go through. kPlain: one brick; else two that are blended.
template <typename Texels, bool kPlain, Lit kLit, int kVectors>
class Post {
 public:
  static constexpr bool kIsLit = kLit != Lit::no;
  using Lights = Shading<Texels::kWhole>;
  using Samples = SamplesInside<Texels, kIsLit>;

  HWY_INLINE Post(const FrameView& frame, const Lights& lights, StretchBatch& batch,
                  const BatchLanes (&lanes)[kVectors], const Texels& fine, const Texels& coarse)
      : frame_(frame),
        lights_(lights),
        batch_(batch),
        lanes_(lanes),
        function_(frame.visibility.functions[0]),
        edge_(static_cast<int>(batch.m)),
        fine_(fine),
        coarse_(coarse) {}

  HWY_INLINE void run(const StepRuns& runs) {
    const Float opaque = all(kOpaque), one = all(1);
    const Samples fine(fine_, edge_), coarse(coarse_, edge_);
    const StepRows rows(function_, Samples::kUnit);
    const std::byte* table = reinterpret_cast<const std::byte*>(
        frame_.step_colors + static_cast<std::size_t>(batch_.level * function_.entries));
    PathRows path[kVectors];
    Float first[kVectors], end[kVectors], last_step[kVectors], opacity[kVectors], most = hn::Zero(kFloats);
    Int samples[kVectors];
    Vec3v color[kVectors], to_eye[kVectors];
    typename Lights::FarHalves halves[kVectors];
    GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
      path[k] = lanes_[k].fine(batch_);
      path[k].first = in_texels(path[k].first);
      lanes_[k].find_ends(batch_, runs, path[k], first[k], end[k]);
      path[k].first = path[k].at(first[k]);
      end[k] = hn::Sub(end[k], first[k]);
      last_step[k] = hn::Max(hn::Sub(end[k], one), hn::Zero(kFloats));
      most = hn::Max(most, end[k]);
      samples[k] = hn::Zero(kInts);
      lanes_[k].load(batch_, color[k], opacity[k]);
      to_eye[k] = kIsLit ? lanes_[k].to_eye(batch_) : path[k].first;
      if constexpr (kIsLit) lights_.find_halves(to_eye[k], halves[k]);
    }
    const float last = hn::GetLane(hn::MaxOfLanes(kFloats, most));
    // To look for what steps see waits for nothing that was gathered: all go on at once.
    Found found[kSteps];
    for (float step = 0; step < last; step += kSteps) {
      Mask going[kVectors];
      GVX_UNROLL for (int k = 0; k < kVectors; ++k) going[k] = hn::Lt(opacity[k], opaque);
      if (none_of(going)) break;
      for (int c = 0; c < kSteps; ++c) {
        const Float i = all(step + static_cast<float>(c));
        Found& f = found[c];
        // Of rays that have ended the last, which is in the brick.
        Vec3v texel[kVectors];
        GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
          f.active[k] = hn::And(hn::Lt(i, end[k]), going[k]);
          texel[k] = path[k].at(hn::Min(i, last_step[k]));
        }
        f.sees = false;
        if (none_of(f.active)) continue;
        CellSample sample[kVectors];
        Float blend[kVectors];
        fine.find(texel, sample);
        if constexpr (!kPlain) blend_in_coarse(coarse, i, first, last_step, blend, sample);
        GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
          const Float place = rows.place_of(sample[k].value);
          f.seen[k] = hn::And(f.active[k], rows.visible(place));
          hn::Store(rows.offset_of(place), kInts, f.offset[k]);
        }
        f.sees = !none_of(f.seen);
        if constexpr (kIsLit) {
          if (!f.sees) continue;
          if constexpr (kLit == Lit::by_one) {
            GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
              lights_.shade_by_one(sample[k].gradient, all(batch_.fine.gradient_scale), halves[k],
                                   f.light[k].body, f.light[k].glint);
            }
          } else {
            // All lights' numbers of one vector fill the registers.
            for (int k = 0; k < kVectors; ++k) {
              f.light[k] =
                  shade_at(hn::Add(first[k], i), sample[k], blend[k], lanes_[k], to_eye[k], halves[k]);
            }
          }
        }
      }
      for (int c = 0; c < kSteps; ++c) {
        const Found& f = found[c];
        Mask sees[kVectors];
        GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
          sees[k] = hn::Lt(opacity[k], opaque);
          const Mask counts = hn::And(f.active[k], sees[k]);
          samples[k] = hn::Sub(samples[k], hn::VecFromMask(kInts, hn::RebindMask(kInts, counts)));
        }
        if (!f.sees) continue;
        GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
          const Mask seen = hn::And(f.seen[k], sees[k]);
          Int bits[4];
          load_rows(table, f.offset[k], bits);
          const Vec3v step_color = PathRows::vec3(bits);
          const Float step_opacity = hn::BitCast(kFloats, bits[3]);
          const Float weight = hn::IfThenElseZero(seen, hn::Mul(hn::Sub(one, opacity[k]), step_opacity));
          const auto add = [&](Float& sum, Float shown) HWY_ATTR {
            const Float more = hn::MulAdd(weight, shown, sum);
            // Of whole numbers every shade is a number, and nothing of it is nothing.
            sum = !kIsLit || Texels::kWhole ? more : hn::IfThenElse(seen, more, sum);
          };
          add(color[k].x, lit<0>(f.light[k], step_color.x));
          add(color[k].y, lit<1>(f.light[k], step_color.y));
          add(color[k].z, lit<2>(f.light[k], step_color.z));
          opacity[k] = hn::Add(opacity[k], weight);
        }
      }
    }
    GVX_UNROLL for (int k = 0; k < kVectors; ++k) lanes_[k].store(batch_, color[k], opacity[k], samples[k]);
  }

 private:
  struct NoLight {};
  struct GrayLight {
    Float body, glint;
  };
  using Light =
      std::conditional_t<kLit == Lit::no, NoLight, std::conditional_t<kLit == Lit::by_one, GrayLight, Shade>>;

  /// So many are looked for at once; lit, where each finds more numbers to keep, that is no gain.
  static constexpr int kSteps = kIsLit ? 1 : 2;
  /// What a step sees, if its ray is not opaque before.
  struct Found {
    Mask active[kVectors], seen[kVectors];
    bool sees;  // any of them
    alignas(64) std::int32_t offset[kVectors][hn::MaxLanes(kInts)];
    Light light[kVectors];
  };

  /// Of steps `i` from the first on.
  HWY_INLINE void blend_in_coarse(const Samples& coarse_samples, Float i, const Float (&first)[kVectors],
                                  const Float (&last_step)[kVectors], Float (&blend)[kVectors],
                                  CellSample (&sample)[kVectors]) const {
    Vec3v texel[kVectors];
    GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
      PathRows path = lanes_[k].coarse(batch_);
      path.first = in_texels(path.first);
      const Float step = hn::Add(first[k], hn::Min(i, last_step[k]));
      blend[k] = share_at(path, step);
      texel[k] = path.at(step);
    }
    CellSample coarse[kVectors];
    coarse_samples.find(texel, coarse);
    GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
      constexpr bool kLacks = !Texels::kWhole;
      sample[k].value = blended<kLacks>(sample[k].value, coarse[k].value, blend[k]);
      if constexpr (kIsLit) {
        sample[k].gradient = blended<kLacks>(sample[k].gradient, coarse[k].gradient, blend[k]);
      }
    }
  }

  template <int kPart>
  HWY_INLINE static Float lit([[maybe_unused]] const Light& light, Float of_step) {
    if constexpr (kLit == Lit::no) {
      return of_step;
    } else if constexpr (kLit == Lit::by_one) {
      return hn::MulAdd(of_step, light.body, light.glint);
    } else if constexpr (kPart == 0) {
      return hn::MulAdd(of_step, light.body.x, light.glint.x);
    } else if constexpr (kPart == 1) {
      return hn::MulAdd(of_step, light.body.y, light.glint.y);
    } else {
      return hn::MulAdd(of_step, light.body.z, light.glint.z);
    }
  }

  HWY_INLINE Shade shade_at(Float i, const CellSample& sample, Float blend, const BatchLanes& lanes,
                            const Vec3v& to_eye, const typename Lights::FarHalves& halves) const {
    Float scale = all(batch_.fine.gradient_scale);
    if constexpr (!kPlain) scale = mix(scale, all(batch_.coarse.gradient_scale), blend);
    return lights_.shade(0, sample.gradient, scale, to_eye, halves,
                         [&]() HWY_ATTR { return lanes.places(batch_).at(i); });
  }

  const FrameView& frame_;
  const Lights& lights_;
  StretchBatch& batch_;
  const BatchLanes (&lanes_)[kVectors];
  const scene::TransferView& function_;
  const int edge_;
  const Texels &fine_, &coarse_;
};

template <bool kPlain, Lit kLit, typename Texels>
void post_rows(const FrameView& frame, StretchBatch& batch, const StepRuns& runs, const Texels& fine,
               const Texels& coarse) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  const Shading<Texels::kWhole> lights(frame);
  std::size_t lane = runs.hidden;
  // Twice as many where vectors are short and what is kept of each is little.
  if constexpr (kLanes <= 8 && kPlain && kLit == Lit::no && GVX_VECTORS_SIDE_BY_SIDE >= 4) {
    for (; lane + 3 * kLanes < batch.count; lane += 4 * kLanes) {
      const BatchLanes lanes[4] = {
          {batch, lane}, {batch, lane + kLanes}, {batch, lane + 2 * kLanes}, {batch, lane + 3 * kLanes}};
      Post<Texels, kPlain, kLit, 4>(frame, lights, batch, lanes, fine, coarse).run(runs);
    }
  }
  if constexpr (GVX_VECTORS_SIDE_BY_SIDE >= 2) {
    for (; lane + kLanes < batch.count; lane += 2 * kLanes) {
      const BatchLanes lanes[2] = {{batch, lane}, {batch, lane + kLanes}};
      Post<Texels, kPlain, kLit, 2>(frame, lights, batch, lanes, fine, coarse).run(runs);
    }
  }
  for (; lane < batch.count; lane += kLanes) {
    const BatchLanes lanes[1] = {{batch, lane}};
    Post<Texels, kPlain, kLit, 1>(frame, lights, batch, lanes, fine, coarse).run(runs);
  }
}

template <bool kPlain, typename Texels>
void post_lit(const FrameView& frame, StretchBatch& batch, const StepRuns& runs, const Texels& fine,
              const Texels& coarse) {
  if (!frame.lighting.lighting.enabled) return post_rows<kPlain, Lit::no>(frame, batch, runs, fine, coarse);
  if constexpr (kPlain && Texels::kWhole) {
    const Shading<Texels::kWhole> lights(frame);
    if (lights.by_one()) return post_rows<kPlain, Lit::by_one>(frame, batch, runs, fine, coarse);
  }
  post_rows<kPlain, Lit::by_any>(frame, batch, runs, fine, coarse);
}

template <typename Texels>
void post_all(const FrameView& frame, StretchBatch& batch, const StepRuns& runs, const Texels& fine,
              const Texels& coarse) {
  if (batch.blended) return post_lit<false>(frame, batch, runs, fine, coarse);
  post_lit<true>(frame, batch, runs, fine, coarse);
}

/// By FrameView::step_colors.
template <typename Voxel>
void post_of(const FrameView& frame, StretchBatch& batch) {
  batch.opaque_count = 0;
  const auto edge = static_cast<int>(batch.m);
  const PlainTexels<Voxel> fine(batch.fine.brick, edge), coarse(batch.coarse.brick, edge);
  bool has_quads = false;
  in_runs<LooksAt::centres>(batch, [&](const StepRuns& runs) HWY_ATTR {
    if constexpr (std::is_same_v<Voxel, std::uint8_t>) {
      if (!has_quads && pays_to_lay_out(batch)) {
        make_quads(batch.m, false, batch.fine);
        if (batch.blended) make_quads(batch.m, false, batch.coarse);
        has_quads = true;
      }
      if (has_quads) {
        return post_all(frame, batch, runs, quads_of(batch.m, batch.fine), quads_of(batch.m, batch.coarse));
      }
    }
    post_all(frame, batch, runs, fine, coarse);
  });
}

/// Of several channels, or where opacity depends on gradients.
template <typename Voxel>
class Classified {
 public:
  static constexpr bool kWhole = std::is_integral_v<Voxel>, kLacks = kMayLack<Voxel>;

  HWY_INLINE Classified(const FrameView& frame, const StretchBatch& batch)
      : visibility_(frame.visibility), batch_(batch), edge_(static_cast<int>(batch.m)) {}

  GVX_PIECE void show(Float i, const StepRays<kWhole>& rays, Mask active, Shown& shown) const {
    const auto sample = [&](std::uint32_t channel, Float blend, bool add_gradient)
                            HWY_ATTR { return sample_of(channel, i, rays, blend, add_gradient); };
    show_scalars<kLacks>(visibility_, batch_.units, rays, i, active, sample, shown);
  }

 private:
  GVX_PIECE CellSample sample_of(std::uint32_t channel, Float i, const StepRays<kWhole>& rays, Float blend,
                                 bool add_gradient) const {
    const std::size_t plane = channel * plane_texels(batch_.m) * sizeof(Voxel);
    const Vec3v p[1] = {rays.fine.at(i)};
    const Float zero = hn::Zero(kFloats);
    CellSample fine[1] = {{zero, {zero, zero, zero}}};
    cell_samples(PlainTexels<Voxel>(batch_.fine.brick + plane, edge_), edge_, p, add_gradient, fine);
    if (!batch_.blended) return fine[0];
    const Vec3v q[1] = {rays.coarse.at(i)};
    CellSample coarse[1] = {fine[0]};
    cell_samples(PlainTexels<Voxel>(batch_.coarse.brick + plane, edge_), edge_, q, add_gradient, coarse);
    fine[0].value = blended<kLacks>(fine[0].value, coarse[0].value, blend);
    fine[0].gradient = blended<kLacks>(fine[0].gradient, coarse[0].gradient, blend);
    return fine[0];
  }

  const scene::Visibility& visibility_;
  const StretchBatch& batch_;
  const int edge_;
};

template <typename Voxel>
void post_all(const FrameView& frame, StretchBatch& batch) {
  if (frame.step_colors == nullptr) return composite_each_step<Classified<Voxel>>(frame, batch);
  post_of<Voxel>(frame, batch);
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
