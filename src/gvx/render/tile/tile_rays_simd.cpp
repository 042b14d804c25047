// What of a tile's rays is in a node, with a ray in each lane of a vector; and which of them may meet a
// node's children, with a child in each. Compiled once for each instruction set.

#include <algorithm>
#include <bit>

#include "gvx/render/tile/tile_rays.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/tile/tile_rays_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::ScalableTag<double>;
using Double = hn::Vec<Doubles>;
using Longs = hn::RebindToSigned<Doubles>;
using Long = hn::Vec<Longs>;
using Mask = hn::Mask<Doubles>;
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfInts = hn::Rebind<std::int32_t, Doubles>;
constexpr Doubles kDoubles;
constexpr Longs kLongs;
constexpr HalfFloats kHalfFloats;
constexpr HalfInts kHalfInts;

HWY_INLINE Double all(double value) {
  return hn::Set(kDoubles, value);
}
HWY_INLINE hn::Vec<HalfFloats> to_floats(Double values) {
  return hn::DemoteTo(kHalfFloats, values);
}

struct Vec3v {
  Double x, y, z;
};
HWY_INLINE Vec3v operator+(const Vec3v& a, const Vec3v& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3v operator*(Double s, const Vec3d& v) {
  return {hn::Mul(s, all(v.x)), hn::Mul(s, all(v.y)), hn::Mul(s, all(v.z))};
}
HWY_INLINE Vec3v constant(const Vec3d& v) {
  return {all(v.x), all(v.y), all(v.z)};
}
HWY_INLINE Vec3v vector(const Affine3& map, const Vec3v& v) {
  return v.x * map.column[0] + v.y * map.column[1] + v.z * map.column[2];
}
HWY_INLINE void store(const Vec3v& v, double (&values)[3][TileRays::kRoom], std::size_t lane) {
  hn::Store(v.x, kDoubles, values[0] + lane);
  hn::Store(v.y, kDoubles, values[1] + lane);
  hn::Store(v.z, kDoubles, values[2] + lane);
}

using HalfFloat = hn::Vec<HalfFloats>;
constexpr unsigned kAllLanes = (1u << hn::MaxLanes(kDoubles)) - 1;

/// Of each lane in `taken` a row of the four vectors' numbers, `stride` floats from one to the next. One more
/// row than is taken may be written.
template <typename D = HalfFloats>
HWY_INLINE void put_rows(const hn::Vec<D> (&v)[4], unsigned taken, float* rows, std::size_t stride) {
  constexpr D d;
#if HWY_TARGET != HWY_SCALAR
  if constexpr (hn::MaxLanes(d) == 4) {
    const hn::RepartitionToWide<D> pairs;
    const auto a = hn::BitCast(pairs, hn::InterleaveLower(d, v[0], v[1])),
               b = hn::BitCast(pairs, hn::InterleaveUpper(d, v[0], v[1]));
    const auto e = hn::BitCast(pairs, hn::InterleaveLower(d, v[2], v[3])),
               f = hn::BitCast(pairs, hn::InterleaveUpper(d, v[2], v[3]));
    hn::StoreU(hn::BitCast(d, hn::InterleaveLower(pairs, a, e)), d, rows);
    rows += (taken & 1) * stride;
    hn::StoreU(hn::BitCast(d, hn::InterleaveUpper(pairs, a, e)), d, rows);
    rows += (taken >> 1 & 1) * stride;
    hn::StoreU(hn::BitCast(d, hn::InterleaveLower(pairs, b, f)), d, rows);
    rows += (taken >> 2 & 1) * stride;
    hn::StoreU(hn::BitCast(d, hn::InterleaveUpper(pairs, b, f)), d, rows);
  } else if constexpr (hn::MaxLanes(d) == 8) {
    const hn::Half<D> half;
    const hn::Vec<decltype(half)> low[4] = {hn::LowerHalf(half, v[0]), hn::LowerHalf(half, v[1]),
                                            hn::LowerHalf(half, v[2]), hn::LowerHalf(half, v[3])};
    const hn::Vec<decltype(half)> high[4] = {hn::UpperHalf(half, v[0]), hn::UpperHalf(half, v[1]),
                                             hn::UpperHalf(half, v[2]), hn::UpperHalf(half, v[3])};
    put_rows<hn::Half<D>>(low, taken & 15, rows, stride);
    put_rows<hn::Half<D>>(high, taken >> 4, rows + static_cast<unsigned>(std::popcount(taken & 15)) * stride,
                          stride);
  }
  if constexpr (hn::MaxLanes(d) >= 4) return;
#endif
  alignas(16) float part[4][hn::MaxLanes(d)];
  for (int k = 0; k < 4; ++k) hn::Store(v[k], d, part[k]);
  for (; taken != 0; taken &= taken - 1) {
    for (int k = 0; k < 4; ++k) rows[k] = part[k][std::countr_zero(taken)];
    rows += stride;
  }
}

/// The same of rows of eight, of two times four vectors' numbers.
HWY_INLINE void put_rows_of_8(const HalfFloat (&v)[4], const HalfFloat (&w)[4], unsigned taken,
                              float (*rows)[8]) {
#if HWY_MAX_BYTES == 64
  const hn::RepartitionToWide<HalfFloats> pairs;
  // Row k has lanes k and k + 4.
  const auto turn = [&](const HalfFloat(&from)[4], HalfFloat(&row)[4]) HWY_ATTR {
    const auto low = [&](int i, int j) HWY_ATTR {
      return hn::BitCast(pairs, hn::InterleaveLower(kHalfFloats, from[i], from[j]));
    };
    const auto high = [&](int i, int j) HWY_ATTR {
      return hn::BitCast(pairs, hn::InterleaveUpper(kHalfFloats, from[i], from[j]));
    };
    row[0] = hn::BitCast(kHalfFloats, hn::InterleaveLower(pairs, low(0, 1), low(2, 3)));
    row[1] = hn::BitCast(kHalfFloats, hn::InterleaveUpper(pairs, low(0, 1), low(2, 3)));
    row[2] = hn::BitCast(kHalfFloats, hn::InterleaveLower(pairs, high(0, 1), high(2, 3)));
    row[3] = hn::BitCast(kHalfFloats, hn::InterleaveUpper(pairs, high(0, 1), high(2, 3)));
  };
  HalfFloat a[4], b[4];
  turn(v, a);
  turn(w, b);
  for (int k = 0; k < 4; ++k, taken >>= 1) {
    hn::StoreU(hn::ConcatLowerLower(kHalfFloats, b[k], a[k]), kHalfFloats, *rows);
    rows += taken & 1;
  }
  for (int k = 0; k < 4; ++k, taken >>= 1) {
    hn::StoreU(hn::ConcatUpperUpper(kHalfFloats, b[k], a[k]), kHalfFloats, *rows);
    rows += taken & 1;
  }
#else
  put_rows(v, taken, *rows, 8);
  put_rows(w, taken, *rows + 4, 8);
#endif
}

HWY_INLINE unsigned bits_of(Mask mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(kDoubles, mask, bits);
  return bits[0];
}

/// CameraView::pixel_ray, and where the ray is in the visible volume (intersect of core/ray.h).
ActiveRays set_up_all(const FrameView& frame, const scene::CameraView& camera, double x0, double y0,
                      double apart, std::uint32_t edge, TileRays& rays) {
  ActiveRays meeting;
  rays.one_origin = !camera.orthographic;
  if (rays.one_origin) {
    for (int axis = 0; axis < 3; ++axis) {
      rays.origin[axis][0] = 0;
      rays.world_origin[axis][0] = camera.eye[axis];
    }
  }
  for (std::uint32_t row = 0; row < edge; ++row) {
    const double y = y0 + static_cast<double>(row) * apart;
    const Double up = all((camera.half_height - y - 0.5) * camera.pixel);
    for (std::uint32_t column = 0; column < edge; column += std::uint32_t{hn::MaxLanes(kDoubles)}) {
      const std::size_t ray = row * TileRays::kEdge + column;
      const Double i = hn::Add(all(static_cast<double>(column)), hn::Iota(kDoubles, 0));
      const Double x = hn::Add(all(x0), hn::Mul(i, all(apart)));
      const Double right = hn::Mul(hn::Sub(hn::Add(x, all(0.5)), all(camera.half_width)), all(camera.pixel));
      const Vec3v across = right * camera.right + up * camera.up;
      Vec3v origin = constant({}), direction = constant(camera.forward);
      if (camera.orthographic) {
        origin = across;
      } else {
        const Vec3v way = direction + across;
        const Double square =
            hn::Add(hn::Add(hn::Mul(way.x, way.x), hn::Mul(way.y, way.y)), hn::Mul(way.z, way.z));
        const Double per_length = hn::Div(all(1), hn::Sqrt(square));
        direction = {hn::Mul(per_length, way.x), hn::Mul(per_length, way.y), hn::Mul(per_length, way.z)};
      }
      const HalfFloat to_eye[4] = {hn::Neg(to_floats(direction.x)), hn::Neg(to_floats(direction.y)),
                                   hn::Neg(to_floats(direction.z)), hn::Zero(kHalfFloats)};
      put_rows(to_eye, kAllLanes, &rays.to_eye[ray][0], 4);
      if (camera.orthographic) {
        store(constant(camera.eye) + origin, rays.world_origin, ray);
        origin = vector(frame.world_to_tree, origin);
        store(origin, rays.origin, ray);
      }
      direction = vector(frame.world_to_tree, direction);
      store(direction, rays.direction, ray);
      Double enter = hn::Zero(kDoubles), exit = all(1e300);
      Mask outside = hn::Lt(exit, enter);
      const auto along = [&](Double o, Double d, int axis) HWY_ATTR {
        const Double low = all(frame.bundle.box.minimum[axis]), high = all(frame.bundle.box.maximum[axis]);
        const Mask still = hn::Eq(d, hn::Zero(kDoubles));
        // Finite, so that a face that the ray lies in gives 0 and not nothing.
        const Double inverse = hn::IfThenElse(still, all(1e300), hn::Div(all(1), d));
        const Double to_low = hn::Mul(hn::Sub(low, o), inverse), to_high = hn::Mul(hn::Sub(high, o), inverse);
        outside = hn::Or(outside, hn::And(still, hn::Or(hn::Lt(o, low), hn::Gt(o, high))));
        enter = hn::IfThenElse(still, enter, hn::Max(enter, hn::Min(to_low, to_high)));
        exit = hn::IfThenElse(still, exit, hn::Min(exit, hn::Max(to_low, to_high)));
        hn::Store(inverse, kDoubles, rays.inverse[axis] + ray);
      };
      along(origin.x, direction.x, 0);
      along(origin.y, direction.y, 1);
      along(origin.z, direction.z, 2);
      outside = hn::Or(outside, hn::Not(hn::Lt(enter, exit)));
      hn::Store(hn::IfThenElse(outside, all(1), enter), kDoubles, rays.enter + ray);
      hn::Store(hn::IfThenElseZero(hn::Not(outside), exit), kDoubles, rays.exit + ray);
      meeting.row[row] |= std::uint64_t{bits_of(hn::Not(outside))} << column;
    }
    if (edge < TileRays::kEdge) meeting.row[row] &= (std::uint64_t{1} << edge) - 1;
  }
  return meeting;
}

/// Where a vector of rays is in a node: between these distances.
struct Interval {
  Double in, out;
};

/// A node's faces; from the rays' origin where they have but one.
class Faces {
 public:
  HWY_INLINE Faces(const TileRays& rays, const NodeBox& node) : rays_(rays) {
    for (int axis = 0; axis < 3; ++axis) {
      const double origin = rays.one_origin ? rays.origin[axis][0] : 0;
      low_[axis] = all(node.low[axis] - origin);
      high_[axis] = all(node.high[axis] - origin);
    }
  }

  /// Rays from `r` on.
  HWY_INLINE Interval interval(std::size_t r) const {
    Interval t{hn::Load(kDoubles, rays_.enter + r), hn::Load(kDoubles, rays_.exit + r)};
    for (int axis = 0; axis < 3; ++axis) {
      const Double inverse = hn::Load(kDoubles, rays_.inverse[axis] + r);
      Double low = low_[axis], high = high_[axis];
      if (!rays_.one_origin) {
        const Double origin = hn::Load(kDoubles, rays_.origin[axis] + r);
        low = hn::Sub(low, origin);
        high = hn::Sub(high, origin);
      }
      const Double a = hn::Mul(low, inverse), b = hn::Mul(high, inverse);
      t.in = hn::Max(t.in, hn::Min(a, b));
      t.out = hn::Min(t.out, hn::Max(a, b));
    }
    return t;
  }

 private:
  const TileRays& rays_;
  Double low_[3], high_[3];
};

/// Along an axis, of rays from `r` on.
HWY_INLINE Double origin_of(const TileRays& rays, const double (&along_axis)[TileRays::kRoom],
                            std::size_t r) {
  return rays.one_origin ? all(along_axis[0]) : hn::Load(kDoubles, along_axis + r);
}

/// Calls function(r) for each vector of a rectangle's rays in which any is active.
template <typename Function>
HWY_INLINE void for_vectors(const ActiveRays& active, const TileRect& rect, const Function& function) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kDoubles));
  for (int y = rect.y0; y <= rect.y1; ++y) {
    for (int x = rect.x0 / kLanes * kLanes; x <= rect.x1; x += kLanes) {
      if ((active.row[y] >> x & ((1u << kLanes) - 1)) != 0)
        function(static_cast<std::size_t>(y) * TileRays::kEdge + static_cast<std::size_t>(x));
    }
  }
}

bool any_inside_of(const FrameView& frame, const TileRays& rays, const ActiveRays& active,
                   const NodeBox& node, const TileRect& rect) {
  bool any = false;
  const Faces faces(rays, node);
  for_vectors(active, rect, [&](std::size_t r) HWY_ATTR {
    const Interval t = faces.interval(r);
    const Double enter = hn::Load(kDoubles, rays.enter + r), tick = hn::Load(kDoubles, rays.tick + r);
    const Double now = hn::Add(enter, hn::Mul(tick, all(frame.tick_world)));
    any = any || !hn::AllFalse(kDoubles, hn::And(hn::Lt(t.in, t.out), hn::Lt(now, t.out)));
  });
  return any;
}

/// Where in the world rays from `r` on are, and how far they go in a step.
HWY_INLINE void put_places(const TileRays& rays, Double centre, Double t_step, std::size_t r, unsigned taken,
                           float (*row)[8]) {
  alignas(64) float lanes[3][hn::MaxLanes(kDoubles)];
  for (std::size_t i = 0; i < hn::MaxLanes(kDoubles); ++i) {
    for (int axis = 0; axis < 3; ++axis) lanes[axis][i] = -rays.to_eye[r + i][axis];
  }
  HalfFloat place[4], per_step[4];
  for (int axis = 0; axis < 3; ++axis) {
    const Double way = hn::PromoteTo(kDoubles, hn::Load(kHalfFloats, lanes[axis]));
    const Double from = origin_of(rays, rays.world_origin[axis], r);
    place[axis] = to_floats(hn::Add(from, hn::Mul(centre, way)));
    per_step[axis] = to_floats(hn::Mul(way, t_step));
  }
  place[3] = per_step[3] = hn::Zero(kHalfFloats);
  put_rows_of_8(place, per_step, taken, row);
}

HWY_INLINE void put_lengths(hn::Vec<HalfInts> lengths, unsigned taken, std::uint8_t* to) {
#if HWY_TARGET == HWY_SCALAR
  *to = static_cast<std::uint8_t>(hn::GetLane(lengths));
  (void)taken;
#else
  const std::uint8_t bits[8] = {static_cast<std::uint8_t>(taken)};
  const auto put_first = hn::Compress(lengths, hn::LoadMaskBits(kHalfInts, bits));
  const hn::Rebind<std::uint8_t, HalfInts> bytes;
  hn::StoreU(hn::DemoteTo(bytes, put_first), bytes, to);
#endif
}

/// The places of rays from `r` on in a brick, and their fourths: what goes with them into a row.
HWY_INLINE void put_path(const TileRays& rays, const Double (&p)[3], std::size_t r, Double t_step,
                         const BrickPlace& place, double m, unsigned taken, HalfFloat fourth,
                         HalfFloat eighth, float (*row)[8]) {
  HalfFloat first[4], per_step[4];
  const Double voxels = all(place.across * m), voxels_per_step = hn::Mul(t_step, voxels);
  for (int axis = 0; axis < 3; ++axis) {
    const Double direction = hn::Load(kDoubles, rays.direction[axis] + r);
    first[axis] = to_floats(hn::Mul(hn::Sub(p[axis], all(place.corner[axis])), voxels));
    per_step[axis] = to_floats(hn::Mul(direction, voxels_per_step));
  }
  first[3] = fourth;
  per_step[3] = eighth;
  put_rows_of_8(first, per_step, taken, row);
}

void gather_stretches_of(const FrameView& frame, const ActiveRays& active, const NodeBox& node,
                         const TileRect& rect, const StretchesWanted& wanted, TileRays& rays,
                         StretchBatch& batch) {
  const double step_stride = wanted.stride;
  const Double half = all(0.5), one = all(1), tick_world = all(frame.tick_world);
  const Double t_step = all(frame.tick_world * step_stride);
  const double m = batch.m;
  const scene::Lighting& lighting = frame.lighting.lighting;
  const bool near_lights = lighting.enabled && lighting.has_points();
  // FrameView::share_at is even in t.
  const double share_first = batch.blended ? frame.share_at(wanted.step_level, 0) : 0;
  const double share_slope = batch.blended ? frame.share_at(wanted.step_level, 1) - share_first : 0;
  const Long zone_wanted = hn::Set(kLongs, wanted.zone);
  const auto first_numbers = hn::Iota(kHalfInts, 0);
  const Faces faces(rays, node);
  std::size_t count = 0;
  for_vectors(active, rect, [&](std::size_t r) HWY_ATTR {
    const Interval t = faces.interval(r);
    const Mask inside = hn::Lt(t.in, t.out);
    if (hn::AllFalse(kDoubles, inside)) return;
    const Double enter = hn::Load(kDoubles, rays.enter + r);
    Double tick, stride, steps_per_t, zone_end, start, middle;
    while (true) {
      tick = hn::Load(kDoubles, rays.tick + r);
      stride = hn::Load(kDoubles, rays.stride + r);
      steps_per_t = hn::Load(kDoubles, rays.steps_per_t + r);
      zone_end = hn::Load(kDoubles, rays.zone_end + r);
      const Double steps_before = hn::Ceil(hn::Sub(hn::Mul(hn::Sub(t.in, enter), steps_per_t), half));
      start = hn::Max(tick, hn::Mul(steps_before, stride));
      middle = hn::Add(start, hn::Mul(half, stride));
      // Starts and ends are multiples of the stride, but for rounding.
      const Mask behind_zone = hn::And(inside, hn::Ge(middle, zone_end));
      if (hn::AllFalse(kDoubles, behind_zone)) break;
      for (unsigned left = bits_of(behind_zone); left != 0; left &= left - 1) {
        const std::size_t ray = r + static_cast<std::size_t>(std::countr_zero(left));
        // Longer steps of a stand-in may have gone beyond it.
        rays.tick[ray] = std::fmax(rays.tick[ray], rays.zone_end[ray]);
        rays.find_zone(frame, static_cast<std::uint32_t>(ray));
      }
    }
    const Long zone = hn::PromoteTo(kLongs, hn::Load(kHalfInts, rays.zone + r));
    Mask taken = hn::And(inside, hn::RebindMask(kDoubles, hn::Eq(zone, zone_wanted)));
    const Double steps_until = hn::Ceil(hn::Sub(hn::Mul(hn::Sub(t.out, enter), steps_per_t), half));
    Double end = hn::Min(hn::Mul(steps_until, stride), zone_end);
    taken = hn::And(taken, hn::Lt(middle, end));
    const unsigned taken_bits = bits_of(taken);
    if (taken_bits == 0) return;
    const Double centre = hn::Add(enter, hn::Mul(middle, tick_world));
    Double steps;
    if (wanted.coarser) {
      steps = hn::Max(one, hn::Ceil(hn::Div(hn::Sub(t.out, centre), t_step)));
    } else {
      steps = hn::Round(hn::Mul(hn::Sub(end, start), hn::Mul(steps_per_t, tick_world)));
    }
    end = hn::Add(start, hn::Mul(steps, all(step_stride)));
    hn::Store(hn::IfThenElse(taken, end, tick), kDoubles, rays.tick + r);
    hn::Store(start, kDoubles, rays.start + r);
    hn::Store(centre, kDoubles, rays.centre + r);

    Double p[3];
    for (int axis = 0; axis < 3; ++axis) {
      const Double origin = origin_of(rays, rays.origin[axis], r);
      p[axis] = hn::Add(origin, hn::Mul(centre, hn::Load(kDoubles, rays.direction[axis] + r)));
    }
    const auto numbers = hn::Add(first_numbers, hn::Set(kHalfInts, static_cast<std::int32_t>(r)));
    put_path(rays, p, r, t_step, wanted.fine, m, taken_bits, to_floats(steps),
             hn::BitCast(kHalfFloats, numbers), batch.fine.row + count);
    if (batch.blended) {
      const Double blend = hn::Add(all(share_first), hn::Mul(centre, all(share_slope)));
      const Double growth = hn::Mul(t_step, all(share_slope));
      put_path(rays, p, r, t_step, wanted.coarse, m, taken_bits, to_floats(blend), to_floats(growth),
               batch.coarse.row + count);
    }
    const auto lengths = hn::DemoteTo(kHalfInts, hn::Min(steps, all(255)));
    put_lengths(lengths, taken_bits, batch.length + count);
    if (near_lights) put_places(rays, centre, t_step, r, taken_bits, batch.place + count);
    count += static_cast<std::size_t>(std::popcount(taken_bits));
  });
  batch.count = static_cast<std::uint32_t>(count);
}

/// A rectangle is this much wider than its node, in rays: rounding must not make it lose one.
constexpr float kMargin = 0.05f;
/// A node is too near for its picture to be where its corners' are if one of these is nearer than this many
/// of its edges.
constexpr float kNear = 0.01f;

// Of a child its place among its parent's children, x first; those behind the last are made the first again.
struct ChildPlaces {
  alignas(64) float of[3][TileProjection::Rects::kMost] = {};

  explicit constexpr ChildPlaces(int n) {
    for (int child = 0; child < n * n * n; ++child) {
      of[0][child] = static_cast<float>(child % n);
      const int row = child / n, slice = row / n;
      of[1][child] = static_cast<float>(row % n);
      of[2][child] = static_cast<float>(slice);
    }
  }
};
constexpr ChildPlaces kPlacesOf2(2), kPlacesOf3(3);

void project_children_of(const TileProjection& to, const Vec3d& low, double edge, int n,
                         TileProjection::Rects& rects) {
  const hn::CappedTag<float, 8> floats;
  const hn::RebindToSigned<decltype(floats)> ints;
  using Float = hn::Vec<decltype(floats)>;
  const auto set = [&](double value) HWY_ATTR { return hn::Set(floats, static_cast<float>(value)); };
  constexpr auto kLast = static_cast<float>(TileRays::kEdge - 1);
  const auto per_axis = static_cast<std::size_t>(n), children = per_axis * per_axis * per_axis;
  const ChildPlaces& places = n == 2 ? kPlacesOf2 : kPlacesOf3;
  const Vec3d ways[3] = {edge * to.across, edge * to.down, edge * to.ahead};
  const Vec3d rows[3] = {to.across, to.down, to.ahead};
  // In doubles: near the eye these cancel.
  double first[3];
  for (int k = 0; k < 3; ++k) first[k] = dot(rows[k], low);
  const double nearest = kNear * (std::fabs(ways[2].x) + std::fabs(ways[2].y) + std::fabs(ways[2].z));
  const Float shift_x = set(to.first_x), shift_y = set(to.first_y);
  for (std::size_t child = 0; child < children; child += hn::Lanes(floats)) {
    Float base[3];
    for (int k = 0; k < 3; ++k) {
      base[k] = set(first[k]);
      for (int axis = 0; axis < 3; ++axis) {
        base[k] = hn::MulAdd(hn::Load(floats, places.of[axis] + child), set(ways[k][axis]), base[k]);
      }
    }
    Float least_x = set(1e30), most_x = set(-1e30), least_y = least_x, most_y = most_x;
    Float least_z = least_x, most_z = most_x;
    for (int corner = 0; corner < 8; ++corner) {
      Float q[3];
      for (int k = 0; k < 3; ++k) {
        const double way =
            (corner & 1 ? ways[k].x : 0) + (corner & 2 ? ways[k].y : 0) + (corner & 4 ? ways[k].z : 0);
        q[k] = hn::Add(base[k], set(way));
      }
      least_z = hn::Min(least_z, q[2]);
      most_z = hn::Max(most_z, q[2]);
      if (!to.orthographic) {
        const Float share = hn::Div(set(1), q[2]);
        q[0] = hn::Mul(q[0], share);
        q[1] = hn::Mul(q[1], share);
      }
      least_x = hn::Min(least_x, q[0]);
      most_x = hn::Max(most_x, q[0]);
      least_y = hn::Min(least_y, q[1]);
      most_y = hn::Max(most_y, q[1]);
    }
    auto all_rays = hn::Lt(least_z, set(nearest)), none = hn::Le(most_z, hn::Zero(floats));
    if (to.orthographic) all_rays = none = hn::Lt(set(1), hn::Zero(floats));
    const auto put = [&](Float least, Float most, Float shift, std::int32_t* from,
                         std::int32_t* until) HWY_ATTR {
      const Float begin = hn::Ceil(hn::Add(least, hn::Sub(shift, hn::Set(floats, kMargin))));
      const Float end = hn::Floor(hn::Add(most, hn::Add(shift, hn::Set(floats, kMargin))));
      Float first_ray = hn::IfThenElseZero(hn::Not(all_rays), hn::Max(begin, hn::Zero(floats)));
      first_ray = hn::Min(first_ray, hn::Set(floats, kLast + 1));
      Float last_ray = hn::IfThenElse(all_rays, hn::Set(floats, kLast), hn::Min(end, hn::Set(floats, kLast)));
      last_ray = hn::IfThenElse(none, set(-1), hn::Max(last_ray, set(-1)));
      hn::Store(hn::ConvertTo(ints, first_ray), ints, from + child);
      hn::Store(hn::ConvertTo(ints, last_ray), ints, until + child);
    };
    put(least_x, most_x, shift_x, rects.x0, rects.x1);
    put(least_y, most_y, shift_y, rects.y0, rects.y1);
  }
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(set_up_all);
HWY_EXPORT(any_inside_of);
HWY_EXPORT(gather_stretches_of);
HWY_EXPORT(project_children_of);

void TileRays::find_zone(const FrameView& frame, std::uint32_t ray) {
  const FrameView::Zone found = frame.zone_at(enter[ray], tick[ray]);
  zone[ray] = zone_number(found.level, found.blended);
  stride[ray] = frame.stride_of(found.level, found.blended);
  steps_per_t[ray] = 1 / (stride[ray] * frame.tick_world);
  zone_end[ray] = found.end;
}

void TileRays::fill_zone(const FrameView& frame, std::uint32_t count) {
  const std::int32_t zone_before = zone[0];
  const double stride_before = stride[0], end_before = zone_end[0], per_t_before = steps_per_t[0];
  find_zone(frame, 0);
  const bool same = zone[0] == zone_before && stride[0] == stride_before && zone_end[0] == end_before &&
                    steps_per_t[0] == per_t_before;
  if (same && count <= filled_) return;
  std::fill_n(zone, count, zone[0]);
  std::fill_n(stride, count, stride[0]);
  std::fill_n(steps_per_t, count, steps_per_t[0]);
  std::fill_n(zone_end, count, zone_end[0]);
  filled_ = count;
}

TileProjection::TileProjection(const scene::CameraView& camera, const Affine3& world_to_tree, double apart)
    : orthographic(camera.orthographic),
      apart_(apart),
      half_width_(camera.half_width),
      half_height_(camera.half_height),
      tree_to_world_(inverse(world_to_tree)) {
  const Vec3d(&edge)[3] = tree_to_world_.column;
  for (const double y : {-1.0, 1.0}) {
    for (const double z : {-1.0, 1.0}) {
      diagonal_world_ = std::fmax(diagonal_world_, length(edge[0] + y * edge[1] + z * edge[2]));
    }
  }
  // Of a perspective only ratios matter: whatever the world's unit, floats must hold them.
  const double unit = orthographic ? 1 : 1 / diagonal_world_;
  const double rays = unit / (camera.pixel * apart);
  across = rays * tree_to_world_.transposed_vector(camera.right);
  down = -rays * tree_to_world_.transposed_vector(camera.up);
  ahead = unit * tree_to_world_.transposed_vector(camera.forward);
}

void TileProjection::begin_tile(double x, double y) {
  first_x = (half_width_ - 0.5 - x) / apart_;
  first_y = (half_height_ - 0.5 - y) / apart_;
}

TileProjection::Distances TileProjection::distances(const NodeBox& node) const {
  const double distance = length(tree_to_world_.vector(0.5 * (node.low + node.high)));
  const double radius = 0.5 * diagonal_world_ * (node.high.x - node.low.x);
  return {distance - radius, distance + radius};
}

void TileProjection::project_children(Vec3d low, double edge, int n, Rects& rects) const {
  HWY_DYNAMIC_DISPATCH(project_children_of)(*this, low, edge, n, rects);
}

ActiveRays set_up(const FrameView& frame, const scene::CameraView& camera, double x0, double y0, double apart,
                  std::uint32_t edge, TileRays& rays) {
  return HWY_DYNAMIC_DISPATCH(set_up_all)(frame, camera, x0, y0, apart, edge, rays);
}

bool any_inside(const FrameView& frame, const TileRays& rays, const ActiveRays& active, const NodeBox& node,
                const TileRect& rect) {
  return HWY_DYNAMIC_DISPATCH(any_inside_of)(frame, rays, active, node, rect);
}

void gather_stretches(const FrameView& frame, const ActiveRays& active, const NodeBox& node,
                      const TileRect& rect, const StretchesWanted& wanted, TileRays& rays,
                      StretchBatch& batch) {
  HWY_DYNAMIC_DISPATCH(gather_stretches_of)(frame, active, node, rect, wanted, rays, batch);
}

}  // namespace gvx::render
#endif
