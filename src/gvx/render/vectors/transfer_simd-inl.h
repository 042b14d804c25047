/// \file
/// How the formulas read the tables of transfer functions in vectors. Compiled once for each instruction set.

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
#include "gvx/render/vectors/simd_targets.h"
#include "gvx/scene/transfer_function.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// Offsets in bytes of an entry's rows, of 1 << kShift bytes each.
template <int kShift>
struct RowsOf {
  alignas(64) std::int32_t offset[hn::MaxLanes(kInts)];

  HWY_INLINE explicit RowsOf(Int entry) { store_offsets(hn::ShiftLeft<kShift>(entry), offset); }
};
HWY_INLINE void read_numbers(const void* first, const std::int32_t* offsets, Float (&numbers)[4]) {
  Int bits[4];
  load_rows(static_cast<const std::byte*>(first), offsets, bits);
  for (int i = 0; i < 4; ++i) numbers[i] = hn::BitCast(kFloats, bits[i]);
}

HWY_INLINE void read_integral(const scene::TransferView::Integral* table, Int entry, Int (&sum)[4],
                              Float (&density)[4]) {
  static_assert(sizeof(*table) == 1 << 5);
  const RowsOf<5> rows(entry);
  load_rows(reinterpret_cast<const std::byte*>(table->sum), rows.offset, sum);
  read_numbers(table->density, rows.offset, density);
}
HWY_INLINE void read_density(const scene::TransferView::Integral* table, Int entry, Float (&density)[4]) {
  read_numbers(table->density, RowsOf<5>(entry).offset, density);
}
HWY_INLINE void read_matter(const scene::Matter* table, Int entry, Float (&matter)[4]) {
  static_assert(sizeof(*table) == 1 << 4);
  read_numbers(table, RowsOf<4>(entry).offset, matter);
}

#include "gvx/render/formula/transfer.inc"

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
