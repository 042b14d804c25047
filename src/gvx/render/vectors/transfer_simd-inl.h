/// \file
/// Transfer functions in vectors: scene::TransferView once more, the same names mean the same.
/// Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_TRANSFER_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_TRANSFER_SIMD_INL_H
#undef GVX_RENDER_TRANSFER_SIMD_INL_H
#else
#define GVX_RENDER_TRANSFER_SIMD_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "gvx/render/vectors/batch_simd-inl.h"
#include "gvx/scene/transfer_function.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// scene::Matter.
struct Matter {
  Float part[4];  // r, g, b, extinction
};

/// Of so much extinction times length.
HWY_INLINE Float opacity_of(Float depth) {
  return hn::Sub(all(1), hn::Exp(kFloats, hn::Neg(depth)));
}

/// scene::TransferView::Reading.
struct Reading {
  Float entry;
  Int sum[4];
};

/// scene::TransferView.
class Function {
 public:
  explicit Function(const scene::TransferView& view) : view_(view) {}

  float entries_per_value() const { return view_.to_entry_scale; }
  float first_entry() const { return view_.to_entry_offset; }
  HWY_INLINE Float entry_of(Float stored) const {
    return hn::Add(hn::Mul(stored, all(view_.to_entry_scale)), all(view_.to_entry_offset));
  }
  HWY_INLINE Float to_entries(Float deviation) const { return hn::Mul(deviation, all(view_.to_entry_scale)); }

  HWY_INLINE Float length(Float from, Float to) const {
    return hn::Mul(hn::Abs(hn::Sub(to, from)), all(view_.length_per_entry));
  }

  HWY_INLINE void read(Float entry, Reading& reading) const {
    const Float held = held_in_table(entry);
    const Float low = hn::Min(hn::Floor(held), all(static_cast<float>(view_.entries - 2)));
    const Float weight = hn::Sub(held, low);
    const Float units = hn::Mul(weight, all(view_.integrals_per_unit));
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    store_offsets(offset_of(whole(low)), offsets);
    Int sum[4], density[4];
    load_rows(sums(), offsets, sum);
    load_rows(densities(), offsets, density);
    reading.entry = entry;
    for (int i = 0; i < 4; ++i) {
      const Float more = hn::Mul(units, hn::BitCast(kFloats, density[i]));
      reading.sum[i] = hn::Add(sum[i], truncated(more));
    }
  }

  /// Lanes whose readings are no more than kNarrow apart mean nothing.
  HWY_INLINE Matter mean(const Reading& a, const Reading& b) const {
    const Float zero = hn::Zero(kFloats), last = all(static_cast<float>(view_.entries - 1));
    const Float width = hn::Sub(b.entry, a.entry);
    const Mask wide = hn::Gt(hn::Abs(width), all(scene::TransferView::kNarrow));
    const Float share = hn::Div(all(1), hn::IfThenElse(wide, width, all(1)));
    const Float scale = hn::Mul(all(view_.integral_unit), share);
    Matter m;
    for (int i = 0; i < 4; ++i) {
      m.part[i] = hn::Mul(scale, hn::ConvertTo(kFloats, hn::Sub(b.sum[i], a.sum[i])));
    }
    if (!none(hn::Or(hn::Lt(hn::Min(a.entry, b.entry), zero), hn::Gt(hn::Max(a.entry, b.entry), last)))) {
      const Float before = hn::Mul(share, hn::Sub(hn::Min(b.entry, zero), hn::Min(a.entry, zero)));
      const Float behind = hn::Mul(share, hn::Sub(hn::Max(b.entry, last), hn::Max(a.entry, last)));
      add(m, before, view_.matter[0]);
      add(m, behind, view_.matter[view_.entries - 1]);
    }
    return m;
  }

  HWY_INLINE Mask is_even(Float from, Float to) const {
    return hn::Or(hn::Le(hn::Abs(hn::Sub(to, from)), all(view_.even.width)),
                  hn::Ge(hn::Min(from, to), all(view_.even.above)));
  }
  HWY_INLINE Mask is_in_parabola(Float from, Float to) const {
    const scene::TransferView::Parabola& p = view_.even.piece;
    const Mask inside =
        hn::And(hn::Ge(hn::Min(from, to), all(p.first)), hn::Le(hn::Max(from, to), all(p.last)));
    return hn::And(inside, hn::Le(hn::Abs(hn::Sub(to, from)), all(p.width)));
  }
  /// What is half way, and along the parabola in the lanes of `mask`.
  HWY_INLINE Matter even_mean(Float from, Float to, Mask mask) const {
    Matter m = density_at(hn::Mul(all(0.5f), hn::Add(from, to)));
    const Float width = hn::Sub(to, from), square = hn::IfThenElseZero(mask, hn::Mul(width, width));
    add(m, square, view_.even.piece.bend);
    return m;
  }

  HWY_INLINE Matter density_at(Float entry) const {
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    store_offsets(offset_of(whole(hn::Floor(held_in_table(entry)))), offsets);
    Int density[4];
    load_rows(densities(), offsets, density);
    Matter m;
    for (int i = 0; i < 4; ++i) m.part[i] = hn::BitCast(kFloats, density[i]);
    return m;
  }

  /// Of the nearest whole entry.
  HWY_INLINE Matter nearest_matter(Float entry) const {
    static_assert(sizeof(scene::Matter) == 16);
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    store_offsets(hn::ShiftLeft<4>(nearest(entry)), offsets);
    Int row[4];
    load_rows(reinterpret_cast<const std::byte*>(view_.matter), offsets, row);
    Matter m;
    for (int i = 0; i < 4; ++i) m.part[i] = hn::BitCast(kFloats, row[i]);
    return m;
  }

  HWY_INLINE bool by_gradient() const { return view_.gradient_factor != nullptr; }

  HWY_INLINE Int nearest(Float entry) const { return truncated(held_in_table(hn::Add(entry, all(0.5f)))); }

  HWY_INLINE Float factor_of_gradient(Float steepness) const {
    constexpr auto kLast = static_cast<float>(scene::TransferView::kGradientEntries - 1);
    const Float entry = hn::Min(hn::Mul(steepness, all(view_.to_gradient_entry)), all(kLast));
    const Float low = hn::Min(hn::Floor(entry), all(kLast - 1));
    const Int at = whole(low);
    return mix(hn::GatherIndex(kFloats, view_.gradient_factor, at),
               hn::GatherIndex(kFloats, view_.gradient_factor + 1, at), hn::Sub(entry, low));
  }

  HWY_INLINE Mask invisible(Float a, Float b) const {
    return hn::Or(hn::Le(hn::Max(a, b), all(view_.first_visible)),
                  hn::Ge(hn::Min(a, b), all(view_.last_visible)));
  }

 private:
  HWY_INLINE Float held_in_table(Float entry) const {
    return hn::Min(hn::Max(entry, hn::Zero(kFloats)), all(static_cast<float>(view_.entries - 1)));
  }
  HWY_INLINE static Int offset_of(Int entry) {
    static_assert(sizeof(scene::TransferView::Integral) == 32);
    return hn::ShiftLeft<5>(entry);
  }
  HWY_INLINE const std::byte* sums() const { return reinterpret_cast<const std::byte*>(view_.integral); }
  HWY_INLINE const std::byte* densities() const {
    return sums() + offsetof(scene::TransferView::Integral, density);
  }
  HWY_INLINE static void add(Matter& m, Float weight, const scene::Matter& matter) {
    m.part[0] = hn::MulAdd(weight, all(matter.color.x), m.part[0]);
    m.part[1] = hn::MulAdd(weight, all(matter.color.y), m.part[1]);
    m.part[2] = hn::MulAdd(weight, all(matter.color.z), m.part[2]);
    m.part[3] = hn::MulAdd(weight, all(matter.extinction), m.part[3]);
  }

  const scene::TransferView& view_;
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
