/// \file
/// Rows of a StretchBatch side by side in vectors. Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_BATCH_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_BATCH_SIMD_INL_H
#undef GVX_RENDER_BATCH_SIMD_INL_H
#else
#define GVX_RENDER_BATCH_SIMD_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "gvx/render/reference/stretch.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// A row of StretchBatch::Path, or of StretchBatch::place, of each lane.
struct PathRows {
  Vec3v first, per_step;
  Float fourth, eighth;

  PathRows() = default;
  HWY_INLINE PathRows(const float (*rows)[8], const std::int32_t* offsets) {
    const auto* bytes = reinterpret_cast<const std::byte*>(rows);
    Int part[4];
    load_rows(bytes, offsets, part);
    first = vec3(part);
    fourth = hn::BitCast(kFloats, part[3]);
    load_rows(bytes + sizeof(float[4]), offsets, part);
    per_step = vec3(part);
    eighth = hn::BitCast(kFloats, part[3]);
  }

  HWY_INLINE static Vec3v vec3(const Int (&part)[4]) {
    return {hn::BitCast(kFloats, part[0]), hn::BitCast(kFloats, part[1]), hn::BitCast(kFloats, part[2])};
  }
  HWY_INLINE Vec3v at(Float i) const { return along(first, per_step, i); }
};

/// A place in voxels from a brick's low corner, in texels from the centre of its first.
HWY_INLINE Vec3v in_texels(const Vec3v& p) {
  const Float half = all(0.5f);
  return {hn::Add(p.x, half), hn::Add(p.y, half), hn::Add(p.z, half)};
}

/// Of a coarse brick, its share at step i.
HWY_INLINE Float share_at(const PathRows& coarse, Float i) {
  const Float asked = hn::MulAdd(i, coarse.eighth, coarse.fourth);
  return hn::Min(hn::Max(asked, hn::Zero(kFloats)), all(1));
}

/// Steps of a batch's rays that are taken in one go.
struct StepRuns {
  bool some = false;         ///< StretchBatch::run, not all
  std::uint32_t hidden = 0;  ///< so many rows come first in the order that take none
};

/// As many rays of a batch as a vector has lanes, the first of a list of rows. Lanes behind the last hold it
/// once more, with nothing before it; of no rows, the one at `rows`.
class BatchLanes {
 public:
  HWY_INLINE BatchLanes(const StretchBatch& batch, const std::int32_t* rows, std::size_t count)
      : valid_(std::min(kLanes, count)) {
    if (count >= kLanes) {
      hn::Store(hn::ShiftLeft<5>(hn::LoadU(kInts, rows)), kInts, row_);
    } else {
      const std::size_t last = count > 0 ? count - 1 : 0;
      for (std::size_t i = 0; i < kLanes; ++i)
        row_[i] = rows[std::min(i, last)] * static_cast<std::int32_t>(kRowBytes);
    }
    for (std::size_t i = 0; i < kLanes; ++i) {
      const auto row = static_cast<std::uint32_t>(row_[i]) / kRowBytes;
      ray_[i] = static_cast<std::int32_t>(batch.ray(row) * sizeof(float[4]));
    }
  }
  /// From place `lane` of the batch's order on.
  HWY_INLINE BatchLanes(const StretchBatch& batch, std::size_t lane)
      : BatchLanes(batch, batch.order + std::min<std::size_t>(lane, batch.count - 1),
                   lane < batch.count ? batch.count - lane : 0) {}

  HWY_INLINE PathRows fine(const StretchBatch& batch) const { return {batch.fine.row, row_}; }
  HWY_INLINE PathRows coarse(const StretchBatch& batch) const { return {batch.coarse.row, row_}; }
  HWY_INLINE PathRows waiting(const StretchBatch& batch) const { return {batch.waiting, row_}; }
  HWY_INLINE PathRows places(const StretchBatch& batch) const { return {batch.place, row_}; }
  HWY_INLINE Vec3v to_eye(const StretchBatch& batch) const {
    Int part[4];
    load_rows(reinterpret_cast<const std::byte*>(batch.to_eye), ray_, part);
    return PathRows::vec3(part);
  }
  HWY_INLINE Float steps(const PathRows& fine) const { return hn::IfThenElseZero(valid(), fine.fourth); }
  HWY_INLINE Mask valid() const { return hn::Lt(hn::Iota(kFloats, 0), all(static_cast<float>(valid_))); }

  /// Of all steps, or of StretchBatch::run, the first and the one behind the last.
  HWY_INLINE void find_ends(const StretchBatch& batch, const StepRuns& runs, const PathRows& fine,
                            Float& first, Float& end) const {
    first = hn::Zero(kFloats);
    end = steps(fine);
    if (!runs.some) return;
    static_assert(kRowBytes == sizeof(std::int32_t) << 3);
    const Int run = hn::GatherOffset(kInts, batch.run, hn::ShiftRight<3>(hn::Load(kInts, row_)));
    first = hn::ConvertTo(kFloats, hn::And(run, all_ints((1 << StretchBatch::kRunBits) - 1)));
    const Float length = hn::ConvertTo(kFloats, hn::ShiftRight<StretchBatch::kRunBits>(run));
    end = hn::Add(first, hn::IfThenElseZero(valid(), length));
  }

  HWY_INLINE Mask without_samples(const StretchBatch& batch) const {
    alignas(64) std::int32_t samples[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      samples[i] = batch.samples[static_cast<std::size_t>(ray_[i]) / sizeof(float[4])];
    }
    return hn::RebindMask(kFloats, hn::Eq(hn::Load(kInts, samples), hn::Zero(kInts)));
  }

  /// What the rays have gathered.
  HWY_INLINE void load(const StretchBatch& batch, Vec3v& color, Float& opacity) const {
    Int part[4];
    load_rows(reinterpret_cast<const std::byte*>(batch.gathered), ray_, part);
    color = PathRows::vec3(part);
    opacity = hn::BitCast(kFloats, part[3]);
  }
  HWY_INLINE void store(StretchBatch& batch, const Vec3v& color, Float opacity, Int more_samples) const {
    if (valid_ == 0) return;
    const Int numbers[4] = {hn::BitCast(kInts, color.x), hn::BitCast(kInts, color.y),
                            hn::BitCast(kInts, color.z), hn::BitCast(kInts, opacity)};
    store_rows(numbers, ray_, reinterpret_cast<std::byte*>(batch.gathered));
    alignas(64) std::int32_t samples[kLanes];
    hn::Store(more_samples, kInts, samples);
    for (std::size_t i = 0; i < valid_; ++i)
      batch.samples[static_cast<std::size_t>(ray_[i]) / sizeof(float[4])] += samples[i];
    const Mask opaque = hn::And(valid(), hn::Ge(opacity, all(kOpaque)));
    if (none(opaque)) return;
    const Int rays = hn::Compress(hn::ShiftRight<4>(hn::Load(kInts, ray_)), hn::RebindMask(kInts, opaque));
    hn::StoreU(rays, kInts, batch.opaque + batch.opaque_count);
    batch.opaque_count += static_cast<std::uint32_t>(hn::CountTrue(kFloats, opaque));
  }

  /// Appends the rows of a mask's lanes to a list; `numbers` are what they wait with.
  HWY_INLINE void wait(StretchBatch& batch, Mask mask, const Float (&numbers)[5], std::int32_t* rows,
                       std::uint32_t& count) const {
    alignas(64) float lanes[5][kLanes];
    alignas(64) std::int32_t waits[kLanes];
    for (std::size_t k = 0; k < 5; ++k) hn::Store(numbers[k], kFloats, lanes[k]);
    hn::Store(hn::VecFromMask(kInts, hn::RebindMask(kInts, mask)), kInts, waits);
    for (std::size_t i = 0; i < valid_; ++i) {
      if (waits[i] == 0) continue;
      const std::size_t row = static_cast<std::size_t>(row_[i]) / sizeof(float[8]);
      for (std::size_t k = 0; k < 5; ++k) batch.waiting[row][k] = lanes[k][i];
      rows[count++] = static_cast<std::int32_t>(row);
    }
  }

 private:
  static constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  static constexpr std::uint32_t kRowBytes = sizeof(float[8]);
  static_assert(kRowBytes == 1 << 5);

  std::size_t valid_;
  alignas(64) std::int32_t row_[kLanes], ray_[kLanes];  // offsets in bytes
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
