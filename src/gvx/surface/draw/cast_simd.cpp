// cast_samples_in_vectors: what cast() does, with a ray in each lane. Compiled once for each instruction set.
//
// All rays of a brick are told from the depth at which the brick begins, in cells: numbers are small, and
// floats suffice.

#include "gvx/surface/draw/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/surface/draw/cast_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/surface/draw/lanes_simd-inl.h"
// clang-format on

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gvx/surface/draw/technique_vectors.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::surface::HWY_NAMESPACE {
namespace {

using Words = hn::RebindToUnsigned<Floats>;
using Word = hn::Vec<Words>;
constexpr Words kWords;

HWY_INLINE Int all_ints(std::int32_t value) {
  return hn::Set(kInts, value);
}
HWY_INLINE Word all_words(std::uint32_t value) {
  return hn::Set(kWords, value);
}
HWY_INLINE Mask of_ints(hn::Mask<Ints> mask) {
  return hn::RebindMask(kFloats, mask);
}
HWY_INLINE hn::Mask<Ints> to_ints(Mask mask) {
  return hn::RebindMask(kInts, mask);
}

/// The columns of a brick as masks, whatever the form of its grid.
const std::byte* columns_of(const PrimaryGridView& grid, std::uint32_t* columns) {
  if (grid.form == GridForm::masks) return grid.bytes;
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      const int at = column_at(u, v);
      const auto depth = static_cast<std::uint8_t>(grid.bytes[at]);
      columns[at] = depth < kCells ? std::uint32_t{1} << depth : 0;
      if (depth == PrimaryGridView::kMany) columns[at] = grid.column(u, v);
    }
  }
  return reinterpret_cast<const std::byte*>(columns);
}

/// An affine function of a pixel's place in the rectangle.
struct PerPixel {
  float at, per_x, per_y;

  HWY_INLINE Float operator()(Float x, float y) const {
    return hn::MulAdd(all(per_x), x, all(at + per_y * y));
  }
};

/// Of a ray along an axis of the grid: where it is at the brick's depth, and its way from there on.
struct RaysAlong {
  PerPixel place, way;
};

/// The number of the lowest and the highest bit of words of which none is 0.
HWY_INLINE Int lowest_bits(Word words) {
  const Int lowest = hn::BitCast(kInts, hn::And(words, hn::Sub(hn::Zero(kWords), words)));
  const Int exponent = hn::ShiftRight<23>(hn::BitCast(kInts, hn::ConvertTo(kFloats, lowest)));
  return hn::Sub(hn::And(exponent, all_ints(0xff)), all_ints(127));
}
HWY_INLINE Int highest_bits(Word words) {
  // Without the bit below the highest it is not rounded up.
  const Int held = hn::BitCast(kInts, hn::AndNot(hn::ShiftRight<1>(words), words));
  const Int exponent = hn::ShiftRight<23>(hn::BitCast(kInts, hn::ConvertTo(kFloats, held)));
  const auto last = hn::Lt(held, hn::Zero(kInts));
  return hn::IfThenElse(last, all_ints(31), hn::Sub(exponent, all_ints(127)));
}

class Caster {
 public:
  Caster(const DrawnSamples& drawn, TileHits& hits) : drawn_(drawn), hits_(hits), axes_(drawn.brick.axis) {
    columns_ = columns_of(drawn.brick.grid, scratch());
    const auto ray_at = [&](std::int32_t x, std::int32_t y) {
      const Ray ray = drawn.placed.ray(drawn.film.ray(x, y));
      return Ray{axes_.to_grid(ray.at(drawn.nearest)), axes_.to_grid(ray.direction)};
    };
    const PixelRect& part = drawn.part;
    const Ray first = ray_at(part.x0, part.y0), right = ray_at(part.x0 + 1, part.y0),
              below = ray_at(part.x0, part.y0 + 1);
    depth_per_way_ = static_cast<float>(1 / length(first.direction));
    const double scale = depth_per_way_;
    for (int axis = 0; axis < 3; ++axis) {
      const auto pixel_of = [&](double at, double x, double y, double times) {
        return PerPixel{static_cast<float>(at * times), static_cast<float>((x - at) * times),
                        static_cast<float>((y - at) * times)};
      };
      along_[axis] = {pixel_of(first.origin[axis], right.origin[axis], below.origin[axis], 1),
                      pixel_of(first.direction[axis], right.direction[axis], below.direction[axis], scale)};
    }
    nearest_ = static_cast<float>(drawn.nearest);
    const Vec3d low = axes_.to_grid(drawn.box.minimum), high = axes_.to_grid(drawn.box.maximum);
    for (int axis = 0; axis < 3; ++axis) {
      low_[axis] = static_cast<float>(low[axis]);
      high_[axis] = static_cast<float>(high[axis]);
    }
  }

  void cast() {
    const PixelRect& part = drawn_.part;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(kFloats));
    for (std::int32_t y = part.y0; y < part.y1; ++y) {
      for (std::int32_t x = part.x0; x < part.x1; x += lanes) cast_lanes(x, y, part.x1 - x);
    }
  }

 private:
  static std::uint32_t* scratch() {
    static thread_local std::uint32_t columns[kCells * kCells];
    return columns;
  }

  /// Rays of pixels from x on, of which `count` are in the rectangle.
  HWY_INLINE void cast_lanes(std::int32_t x, std::int32_t y, std::int32_t count) {
    const Float lane = hn::ConvertTo(kFloats, hn::Iota(kInts, 0));
    const Float px = hn::Add(lane, all(static_cast<float>(x - drawn_.part.x0)));
    const auto py = static_cast<float>(y - drawn_.part.y0);
    float* const depths = hits_.depth + hits_.index(x, y);
    // Rows of hits end beyond those of the rectangle, and others' are not changed.
    const Mask in_rect = hn::FirstN(kFloats, std::min(static_cast<std::size_t>(count), hn::Lanes(kFloats)));
    const Float depth_before = hn::MaskedLoad(in_rect, kFloats, depths);
    const Float per_depth = all(1 / depth_per_way_);

    Float place[3], way[3], inverse[3];
    Float enter = hn::Mul(all(-nearest_), per_depth);
    Float exit = hn::Mul(hn::Sub(depth_before, all(nearest_)), per_depth);
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] = along_[axis].place(px, py);
      const Float d = along_[axis].way(px, py);
      // Nothing runs along a plane for ever.
      const Float least = hn::CopySign(all(1e-9f), d);
      way[axis] = hn::IfThenElse(hn::Lt(hn::Abs(d), all(1e-9f)), least, d);
      inverse[axis] = hn::Div(all(1), way[axis]);
      const Float low = hn::Mul(hn::Sub(all(low_[axis]), place[axis]), inverse[axis]);
      const Float high = hn::Mul(hn::Sub(all(high_[axis]), place[axis]), inverse[axis]);
      enter = hn::Max(enter, hn::Min(low, high));
      exit = hn::Min(exit, hn::Max(low, high));
    }
    Mask active = hn::And(in_rect, hn::Le(enter, exit));
    if (hn::AllFalse(kFloats, active)) return;

    // The column that a ray is in, and how far it is to the next along u and along v.
    const Float zero = hn::Zero(kFloats), last_cell = all(kCells - 1);
    Float cell[2], to_next[2], step[2], between[2];
    for (int axis = 0; axis < 2; ++axis) {
      const Float at = hn::MulAdd(enter, way[axis], place[axis]);
      cell[axis] = hn::Min(hn::Max(hn::Floor(at), zero), last_cell);
      const Mask rises = hn::Gt(way[axis], zero);
      const Float plane = hn::IfThenElse(rises, hn::Add(cell[axis], all(1)), cell[axis]);
      to_next[axis] = hn::Mul(hn::Sub(plane, place[axis]), inverse[axis]);
      step[axis] = hn::IfThenElse(rises, all(1), all(-1));
      between[axis] = hn::Abs(inverse[axis]);
    }
    Float s = enter, found_enter = zero, found_exit = zero;
    Int column = hn::Zero(kInts), found_column = hn::Zero(kInts);
    Word found = hn::Zero(kWords);
    Mask hit = hn::Lt(zero, zero);
    // A ray crosses at most so many columns; it may begin beside them by rounding.
    constexpr int kMostSteps = 2 * kCells + 4;
    for (int i = 0; i < kMostSteps; ++i) {
      const Float leaves_column = hn::Min(to_next[0], to_next[1]), until = hn::Min(leaves_column, exit);
      const Float from_w = hn::MulAdd(s, way[2], place[2]), to_w = hn::MulAdd(until, way[2], place[2]);
      // A little more than it crosses: no cell may be missed for rounding.
      constexpr float kMargin = 1e-4f;
      const auto clamped = [&](Float w) HWY_ATTR {
        return hn::ConvertTo(kInts, hn::Min(hn::Max(w, zero), last_cell));
      };
      const Int low = clamped(hn::Sub(hn::Min(from_w, to_w), all(kMargin)));
      const Int high = clamped(hn::Add(hn::Max(from_w, to_w), all(kMargin)));
      column = hn::ConvertTo(kInts, hn::MulAdd(cell[1], all(kCells), cell[0]));
      const Int safe = hn::And(column, all_ints(kCells * kCells - 1));
      const Word cells =
          hn::BitCast(kWords, hn::GatherIndex(kInts, reinterpret_cast<const std::int32_t*>(columns_), safe));
      const Word ones = all_words(UINT32_MAX);
      const Word within = hn::And(hn::Shl(ones, hn::BitCast(kWords, low)),
                                  hn::Shr(ones, hn::BitCast(kWords, hn::Sub(all_ints(31), high))));
      const Word met = hn::And(cells, within);
      const Mask some = of_ints(hn::Ne(hn::BitCast(kInts, met), hn::Zero(kInts)));
      const Mask now = hn::And(active, some);
      found = hn::IfThenElse(hn::RebindMask(kWords, now), met, found);
      found_column = hn::IfThenElse(to_ints(now), safe, found_column);
      found_enter = hn::IfThenElse(now, s, found_enter);
      // Where the cell ends, whatever ends the ray: so what is found does not depend on that.
      found_exit = hn::IfThenElse(now, leaves_column, found_exit);
      hit = hn::Or(hit, now);
      active = hn::And(hn::AndNot(some, active), hn::Lt(until, exit));
      if (hn::AllFalse(kFloats, active)) break;
      const Mask along_u = hn::Lt(to_next[0], to_next[1]);
      cell[0] = hn::Add(cell[0], hn::IfThenElseZero(along_u, step[0]));
      cell[1] = hn::Add(cell[1], hn::IfThenZeroElse(along_u, step[1]));
      to_next[0] = hn::Add(to_next[0], hn::IfThenElseZero(along_u, between[0]));
      to_next[1] = hn::Add(to_next[1], hn::IfThenZeroElse(along_u, between[1]));
      s = until;
      const Mask inside = hn::And(hn::And(hn::Ge(cell[0], zero), hn::Le(cell[0], last_cell)),
                                  hn::And(hn::Ge(cell[1], zero), hn::Le(cell[1], last_cell)));
      active = hn::And(active, inside);
    }
    if (hn::AllFalse(kFloats, hit)) return;

    // The first of the cells that were met, and how the ray goes through it.
    const Word some_bits = hn::IfThenElse(hn::RebindMask(kWords, hit), found, all_words(1));
    const Mask rises = hn::Ge(way[2], zero);
    const Int w = hn::IfThenElse(to_ints(rises), lowest_bits(some_bits), highest_bits(some_bits));
    const Float cell_w = hn::ConvertTo(kFloats, w), behind = hn::Add(cell_w, all(1));
    const Float first = hn::IfThenElse(rises, cell_w, behind), second = hn::IfThenElse(rises, behind, cell_w);
    const Float enters = hn::Max(found_enter, hn::Mul(hn::Sub(first, place[2]), inverse[2]));
    const Float leaves = hn::Max(hn::Min(found_exit, hn::Mul(hn::Sub(second, place[2]), inverse[2])), enters);
    const Float middle = hn::Mul(all(0.5f), hn::Add(enters, leaves));
    const Float depth = hn::MulAdd(middle, all(depth_per_way_), all(nearest_));

    const Int u = hn::And(found_column, all_ints(kCells - 1)), v = hn::ShiftRight<5>(found_column);
    const Int item =
        hn::Add(hn::Add(hn::Mul(u, all_ints(stride(axes_.u))), hn::Mul(v, all_ints(stride(axes_.v)))),
                hn::Mul(w, all_ints(stride(axes_.w))));
    const Mask nearer = hn::And(hit, hn::Lt(depth, depth_before));
    hn::BlendedStore(depth, nearer, kFloats, depths);
    const std::size_t at = hits_.index(x, y);
    hn::BlendedStore(item, to_ints(nearer), kInts, reinterpret_cast<std::int32_t*>(hits_.item + at));
    hn::BlendedStore(all_ints(static_cast<std::int32_t>(drawn_.number)), to_ints(nearer), kInts,
                     reinterpret_cast<std::int32_t*>(hits_.brick + at));
    const Mask equal = hn::And(hit, hn::Eq(depth, depth_before));
    if (HWY_LIKELY(hn::AllFalse(kFloats, equal))) return;
    alignas(64) float lane_depth[hn::MaxLanes(kFloats)];
    alignas(64) std::int32_t lane_item[hn::MaxLanes(kFloats)];
    hn::Store(hn::IfThenElse(equal, depth, all(INFINITY)), kFloats, lane_depth);
    hn::Store(item, kInts, lane_item);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count) && i < hn::Lanes(kFloats); ++i) {
      if (lane_depth[i] < INFINITY) {
        hits_.put(at + i, lane_depth[i], drawn_.number, static_cast<std::uint32_t>(lane_item[i]));
      }
    }
  }

  /// Of packed() along an axis of the brick.
  static std::int32_t stride(int axis) { return axis == 0 ? 1 : axis == 1 ? kCells : kCells * kCells; }

  const DrawnSamples& drawn_;
  TileHits& hits_;
  const GridAxes axes_;
  const std::byte* columns_;
  RaysAlong along_[3];  // the grid's axes
  float depth_per_way_, nearest_;
  float low_[3], high_[3];  // of the box that samples are in
};

}  // namespace

void cast_samples_in_vectors(const DrawnSamples& drawn, TileHits& hits) {
  Caster(drawn, hits).cast();
}

}  // namespace gvx::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::surface {

HWY_EXPORT(cast_samples_in_vectors);

void cast_samples_in_vectors(const DrawnSamples& drawn, TileHits& hits) {
  HWY_DYNAMIC_DISPATCH(cast_samples_in_vectors)(drawn, hits);
}

}  // namespace gvx::surface
#endif
