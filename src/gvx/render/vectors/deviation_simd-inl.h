/// \file
/// How deviations in a brick are read in vectors (reference/sample.h does it for one ray). Compiled once for
/// each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_DEVIATION_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_DEVIATION_SIMD_INL_H
#undef GVX_RENDER_DEVIATION_SIMD_INL_H
#else
#define GVX_RENDER_DEVIATION_SIMD_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/quads_simd-inl.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// What one plane of a brick deviates by; nothing where it is null.
class Deviations {
 public:
  HWY_INLINE Deviations(const std::uint8_t* deviations, int brick_edge)
      : places_(brick_edge / 2, 1), row_(brick_edge / 2 + 2) {
    if (deviations == nullptr) return;
    std::memcpy(&unit_, deviations, sizeof(unit_));
    codes_ = deviations + sizeof(unit_);
  }

  /// Is there any?
  bool some() const { return unit_ > 0.0f; }

 protected:
  /// Of a place in the brick's texels, as of PlacesInside.
  HWY_INLINE TexelPlace at_half(const Vec3v& texel) const {
    const Float half = all(0.5f), quarter = all(0.25f);
    return places_.at({hn::MulAdd(texel.x, half, quarter), hn::MulAdd(texel.y, half, quarter),
                       hn::MulAdd(texel.z, half, quarter)});
  }

  const PlacesInside places_;
  const int row_;
  float unit_ = 0;
  const std::uint8_t* codes_ = nullptr;
};

/// As they are in the brick.
class PlainDeviations : public Deviations {
 public:
  // An inherited constructor would not be compiled for the instruction set.
  HWY_INLINE PlainDeviations(const std::uint8_t* deviations, int brick_edge)
      : Deviations(deviations, brick_edge) {}

  HWY_INLINE Float at(const Vec3v& texel) const {
    const TexelPlace place = at_half(texel);
    // The last texels' neighbours are read with those before them: a brick ends with its deviations.
    Corners at;
    for (int i = 0; i < 4; ++i) {
      const int offset = (i & 1) * row_ + (i >> 1) * row_ * row_ - 2;
      const Int four =
          hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(codes_ + offset), place.index);
      at.corner[2 * i] = meaning(hn::ShiftRight<16>(four));
      at.corner[2 * i + 1] = meaning(hn::ShiftRight<24>(four));
    }
    return hn::Mul(all(unit_), trilinear(at, place.weight));
  }

 private:
  /// deviation_of_code of the last byte.
  HWY_INLINE static Float meaning(Int codes) {
    const Int code = hn::And(codes, all_ints(0xff));
    // A code is the exponent and the first bits of the mantissa of a float.
    const Int bits = hn::Add(hn::ShiftLeft<19>(code), all_ints(127 << 23));
    return hn::IfThenElseZero(hn::RebindMask(kFloats, hn::Gt(code, hn::Zero(kInts))),
                              hn::BitCast(kFloats, bits));
  }
};

/// Laid out anew (StretchBatch::Path::deviations).
class DeviationQuads : public Deviations {
 public:
  HWY_INLINE DeviationQuads(const std::uint8_t* deviations, int brick_edge, const std::uint64_t* quads)
      : Deviations(deviations, brick_edge), quads_(quads) {}

  HWY_INLINE Float at(const Vec3v& texel) const {
    const TexelPlace place = at_half(texel);
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    store_offsets(hn::ShiftLeft<3>(place.index), offsets);
    Int low_high[4];  // along x: of z = 0 and 1, then the next
    load_rows(reinterpret_cast<const std::byte*>(quads_), offsets, low_high);
    const Int &c0 = low_high[0], &c1 = low_high[2], &d0 = low_high[1], &d1 = low_high[3];
    return hn::Mul(
        all(unit_),
        trilinear({{front(c0), front(c1), back(c0), back(c1), front(d0), front(d1), back(d0), back(d1)}},
                  place.weight));
  }

  /// Fills the quads as far as a path's rays come.
  HWY_INLINE void make(StretchBatch::Path& path) const {
    const std::size_t row = static_cast<std::size_t>(row_), slice = row * row;
    const auto edge = static_cast<std::uint32_t>(row_ - 2);
    const auto last = [&](int axis) { return std::min((path.last_row[axis] + 1) / 2, edge); };
    const TexelRows rows{path.first_row[0] / 2, last(0), path.first_row[1] / 2, last(1)};
    constexpr std::size_t kMostEdge = 16;
    std::uint16_t halves[plane_texels(kMostEdge, 1)];
    for (std::size_t z = rows.first_z; z <= rows.last_z + 1; ++z) {
      const std::size_t first = z * slice + rows.first_y * row, end = z * slice + (rows.last_y + 2) * row;
      for (std::size_t i = first; i < end; ++i) {
        // The upper half of the float that a code means: its exponent and the first bits of its mantissa.
        const std::uint32_t code = codes_[i];
        halves[i] = static_cast<std::uint16_t>(code == 0 ? 0 : (127u << 7) + (code << 3));
      }
    }
    make_quads(halves, row, rows, path.deviations);
  }

 private:
  HWY_INLINE static Float front(Int two) { return hn::BitCast(kFloats, hn::ShiftLeft<16>(two)); }
  HWY_INLINE static Float back(Int two) {
    return hn::BitCast(kFloats, hn::And(two, all_ints(static_cast<std::int32_t>(0xffff0000u))));
  }

  const std::uint64_t* quads_;
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
