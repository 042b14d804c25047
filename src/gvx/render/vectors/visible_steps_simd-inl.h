/// \file
/// Which steps of a batch's rays can be seen, by the cells of the brick (visible_cells.h): just these are
/// taken, run by run. Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_VISIBLE_STEPS_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_VISIBLE_STEPS_SIMD_INL_H
#undef GVX_RENDER_VISIBLE_STEPS_SIMD_INL_H
#else
#define GVX_RENDER_VISIBLE_STEPS_SIMD_INL_H
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "gvx/render/reference/stretch.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/tile/visible_cells.h"
#include "gvx/render/vectors/batch_simd-inl.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// Are the bits of these numbers, from 0 to 63, set in `cells` (visible_cells.h)?
HWY_INLINE Mask are_set(std::uint64_t cells, Int index) {
  const Int low = all_ints(static_cast<std::int32_t>(cells & 0xffffffffu));
  const Int high = all_ints(static_cast<std::int32_t>(cells >> 32));
  const Int half = hn::IfThenElse(hn::Gt(index, all_ints(31)), high, low);
  const Int to_sign = hn::AndNot(index, all_ints(31));
  return hn::RebindMask(kFloats, hn::MaskFromVec(hn::BroadcastSignBit(hn::Shl(half, to_sign))));
}

/// Which cells of a brick can be seen, along rays. A cell's values reach half a voxel beyond it, so that a
/// place may be taken for one that is so far off.
class VisibleCells {
 public:
  /// In voxels: so much places are taken to be off, for rounding not to put any outside of the brick.
  static constexpr float kMoved = 1.0f / 64;

  HWY_INLINE VisibleCells(std::uint64_t cells, int edge) : cells_(cells) {
    const auto voxels = static_cast<float>(edge);
    const float scale = kCellsAcross / voxels * (1 - 1.5f * kMoved / voxels);
    scale_ = all(scale);
    // Added to it, a power of two has a place as a whole number of its last bits: two of which are the cell.
    const auto begin_at = [&](int exponent)
                              HWY_ATTR { return all(static_cast<float>(1 << exponent) + kMoved * scale); };
    first_ = {begin_at(23 - kBit), begin_at(21 - kBit), begin_at(19 - kBit)};
#if HWY_TARGET == HWY_AVX3
    low_ = _mm512_movm_epi16(static_cast<__mmask32>(cells & 0xffffffffu));
    high_ = _mm512_movm_epi16(static_cast<__mmask32>(cells >> 32));
#endif
  }

  /// A ray's way, of which of_cell is to be asked.
  HWY_INLINE void scale_way(const PathRows& path, Vec3v& first, Vec3v& per_step) const {
    first = {hn::MulAdd(path.first.x, scale_, first_.x), hn::MulAdd(path.first.y, scale_, first_.y),
             hn::MulAdd(path.first.z, scale_, first_.z)};
    per_step = {hn::Mul(path.per_step.x, scale_), hn::Mul(path.per_step.y, scale_),
                hn::Mul(path.per_step.z, scale_)};
  }

  /// At a place on such a way.
  HWY_INLINE Mask of_cell(const Vec3v& place) const {
    const Int x = hn::BitCast(kInts, place.x), y = hn::BitCast(kInts, place.y),
              z = hn::BitCast(kInts, place.z);
    const Int of_y = all_ints(3 << (kBit + 2)), of_z = all_ints(3 << (kBit + 4));
#if HWY_TARGET == HWY_AVX3
    constexpr int kChoose = 0xca;  // the second where the first has bits, else the third
    const __m512i xy = _mm512_ternarylogic_epi32(of_y.raw, y.raw, x.raw, kChoose);
    const __m512i xyz = _mm512_ternarylogic_epi32(of_z.raw, z.raw, xy, kChoose);
    // A word of each cell; of a lane's two only the lower is looked at.
    const __m512i word = _mm512_permutex2var_epi16(low_, _mm512_srli_epi32(xyz, kBit), high_);
    return hn::RebindMask(kFloats, hn::Mask<Ints>{_mm512_test_epi32_mask(word, _mm512_set1_epi32(0xffff))});
#else
    const Int of_x = all_ints(3 << kBit);
    const Int xyz = hn::Or(hn::Or(hn::And(x, of_x), hn::And(y, of_y)), hn::And(z, of_z));
    return are_set(cells_, hn::ShiftRight<kBit>(xyz));
#endif
  }

 private:
  static constexpr int kBit = 10;  // where x is; y and z are above

  [[maybe_unused]] std::uint64_t cells_;
  Float scale_;
  Vec3v first_;
#if HWY_TARGET == HWY_AVX3
  __m512i low_, high_;
#endif
};

/// What of a step is looked at: its centre; or its ends, of which both are wanted where one can be seen.
enum class LooksAt { centres, ends };

/// Says of each lane's ray which of 32 places on it can be seen: the centres of steps, or their fronts.
class Places {
 public:
  HWY_INLINE Places(const VisibleCells& cells, const PathRows& path, LooksAt looks)
      : cells_(cells), last_(hn::Sub(path.fourth, all(1))), to_front_(looks == LooksAt::ends ? 0.5f : 0) {
    cells.scale_way(path, first_, per_step_);
    const Vec3v& way = path.per_step;
    const Float longest = hn::Max(hn::Max(hn::Abs(way.x), hn::Abs(way.y)), hn::Abs(way.z));
    two_at_once_ = none(hn::Gt(longest, all(1 - 2 * VisibleCells::kMoved)));
  }

  /// Where a step begins or ends may be outside of the brick, by half a step; where these are long, that is
  /// too far to know what is there.
  HWY_INLINE bool knows_faces() const { return two_at_once_ || to_front_ == 0; }
  /// The first `count` of the 32 from step `first` on; bits of those behind are of no concern.
  HWY_INLINE Int visible(float first, int count) const {
    return two_at_once_ ? visible<2>(first, count) : visible<1>(first, count);
  }

 private:
  /// kTogether are looked at half way between them, in steps short enough for that.
  template <int kTogether>
  HWY_INLINE Int visible(float first, int count) const {
    const float begin = first - to_front_ + 0.5f * (kTogether - 1);
    Int bits = hn::Zero(kInts);
    for (int i = 0; i < count; i += kTogether) {
      // Beyond the first and the last centre there may be no cell.
      Float at = hn::Min(all(begin + static_cast<float>(i)), last_);
      if (kTogether == 1) at = hn::Max(at, hn::Zero(kFloats));
      const Mask seen = cells_.of_cell(along(first_, per_step_, at));
      const auto bit = static_cast<std::int32_t>(((1u << kTogether) - 1) << i);
      bits = hn::IfThenElse(hn::RebindMask(kInts, seen), hn::Or(bits, all_ints(bit)), bits);
    }
    return bits;
  }

  const VisibleCells& cells_;
  const Float last_;
  const float to_front_;
  bool two_at_once_;
  Vec3v first_, per_step_;
};

/// Bits of each lane.
using BitsTag = hn::RebindToUnsigned<Ints>;
using Bits = hn::Vec<BitsTag>;
constexpr BitsTag kBits;

HWY_INLINE Bits all_bits(std::uint32_t bits) {
  return hn::Set(kBits, bits);
}
/// The number of the one bit that is set.
HWY_INLINE Bits number_of(Bits bit) {
  const Float power = hn::ConvertTo(kFloats, hn::BitCast(kInts, bit));  // the highest is the sign's
  return hn::Sub(hn::And(hn::ShiftRight<23>(hn::BitCast(kBits, power)), all_bits(0xff)), all_bits(127));
}

/// So many steps are looked at in one go: their ends are the bits of a word.
constexpr int kWindow = 31;

/// Takes the first runs of the rows from `row` on, of which these bits' steps are to be taken; `first` is
/// where their window begins. Gaps that take no longer than to begin a run belong to it.
HWY_INLINE void take_runs(StretchBatch& batch, std::uint32_t row, std::uint32_t first, Bits steps) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  const Bits none_left = hn::Zero(kBits), one = all_bits(1);
  const auto some = hn::Ne(steps, none_left);
  const Bits lowest = hn::And(steps, hn::Sub(none_left, steps));
  const Bits begin = hn::IfThenElseZero(some, number_of(lowest));
  const Bits here = hn::Shr(steps, begin);
  Bits wide = hn::Or(here, hn::ShiftLeft<1>(here));
  wide = hn::Or(wide, hn::ShiftLeft<2>(wide));
  wide = hn::And(wide, hn::ShiftRight<1>(wide));
  wide = hn::And(wide, hn::ShiftRight<2>(wide));
  const Bits filled = hn::Or(here, wide), end = hn::AndNot(filled, hn::Add(filled, one));
  const Bits length = hn::IfThenElseZero(some, number_of(end));
  const Bits run = hn::Or(hn::Add(all_bits(first), begin), hn::ShiftLeft<StretchBatch::kRunBits>(length));
  hn::StoreU(hn::AndNot(hn::Shl(hn::Sub(end, one), begin), steps), kBits, batch.to_take + row);
  hn::StoreU(hn::BitCast(kInts, run), kInts, batch.run + row);
  alignas(64) std::uint32_t lengths[kLanes];
  hn::Store(length, kBits, lengths);
  for (std::uint32_t i = 0; i < kLanes; ++i) batch.length[row + i] = static_cast<std::uint8_t>(lengths[i]);
}

/// Opaque rays have no steps left. (Seldom is a row in a later run.)
HWY_INLINE Bits without_opaque(const StretchBatch& batch, std::uint32_t row, Bits steps) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  alignas(64) std::uint32_t left[kLanes];
  hn::Store(steps, kBits, left);
  for (std::uint32_t i = 0; i < kLanes; ++i) {
    if (left[i] != 0 && batch.gathered[batch.ray(row + i)][3] >= kOpaque) left[i] = 0;
  }
  return hn::Load(kBits, left);
}

/// Takes the first runs of all rays in the window of steps from `first` on. Do some go on behind it?
template <LooksAt kLooks>
HWY_NOINLINE bool take_first_runs(StretchBatch& batch, int first) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  const VisibleCells cells(batch.cells, static_cast<int>(batch.m));
  int most = 0;
  for (std::uint32_t row = 0; row < batch.count; row += kLanes) {
    alignas(64) std::int32_t offsets[kLanes];
    for (std::uint32_t i = 0; i < kLanes; ++i) {
      offsets[i] = static_cast<std::int32_t>(std::min(row + i, batch.count - 1) * sizeof(float[8]));
    }
    const PathRows path(batch.fine.row, offsets);
    const Places places(cells, path, kLooks);
    const Mask is_row =
        hn::Lt(hn::Iota(kFloats, static_cast<float>(row)), all(static_cast<float>(batch.count)));
    const Float left = hn::Sub(hn::IfThenElseZero(is_row, path.fourth), all(static_cast<float>(first)));
    const int steps = static_cast<int>(hn::GetLane(hn::MaxOfLanes(kFloats, left)));
    most = std::max(most, steps);
    constexpr int kEnds = kLooks == LooksAt::ends ? 1 : 0;
    const Int seen = places.visible(static_cast<float>(first), std::min(steps, kWindow) + kEnds);
    Bits visible = hn::BitCast(kBits, seen);
    const Float in_window = hn::Min(hn::Max(left, hn::Zero(kFloats)), all(kWindow));
    const Bits end = hn::Shl(all_bits(1), hn::BitCast(kBits, hn::ConvertTo(kInts, in_window)));
    if (!places.knows_faces()) visible = hn::Or(visible, hn::Or(end, all_bits(1)));
    if (kLooks == LooksAt::ends) visible = hn::Or(visible, hn::ShiftRight<1>(visible));
    visible = hn::And(visible, hn::Sub(end, all_bits(1)));
    if (first > 0) visible = without_opaque(batch, row, visible);
    take_runs(batch, row, static_cast<std::uint32_t>(first), visible);
  }
  return most > kWindow;
}

/// The next runs of those that have any left.
HWY_INLINE bool take_next_runs(StretchBatch& batch, int first) {
  constexpr auto kLanes = static_cast<std::uint32_t>(hn::MaxLanes(kFloats));
  bool some = false;
  for (std::uint32_t row = 0; row < batch.count; row += kLanes) {
    Bits left = hn::LoadU(kBits, batch.to_take + row);
    if (!hn::AllTrue(kBits, hn::Eq(left, hn::Zero(kBits)))) {
      left = without_opaque(batch, row, left);
      some = some || !hn::AllTrue(kBits, hn::Eq(left, hn::Zero(kBits)));
    }
    take_runs(batch, row, static_cast<std::uint32_t>(first), left);
  }
  return some;
}

/// Calls go(runs) until a batch's rays have taken all steps that can be seen, in order.
template <LooksAt kLooks, typename Go>
HWY_INLINE void in_runs(StretchBatch& batch, const Go& go) {
  // Where more of 64 can be seen, to find the others takes longer than to step through them.
  constexpr int kMostCells = kLooks == LooksAt::ends ? 60 : 44;
  if (std::popcount(batch.cells) > kMostCells) {
    batch.put_in_order();
    return go(StepRuns());
  }
  bool goes_on = true;
  for (int first = 0; goes_on; first += kWindow) {
    goes_on = take_first_runs<kLooks>(batch, first);
    bool some = true;
    while (some) {
      batch.put_in_order();
      const std::int32_t* seen = std::partition_point(
          batch.order, batch.order + batch.count, [&](std::int32_t row) { return batch.length[row] == 0; });
      const auto hidden = static_cast<std::uint32_t>(seen - batch.order);
      if (hidden == batch.count) break;
      go(StepRuns{true, hidden});
      some = take_next_runs(batch, first);
    }
  }
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
