// TileRays' way from node to node, with a ray in each lane of a vector. Compiled once for each instruction
// set.

#include "gvx/render/simd_targets.h"
#include "gvx/render/tile_rays.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/tile_rays_simd.cpp"
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
HWY_INLINE Long load_indices(const std::int32_t* indices) {
  return hn::PromoteTo(kLongs, hn::Load(kHalfInts, indices));
}
HWY_INLINE Double gather(const double* values, Long index) {
  return hn::GatherIndex(kDoubles, values, index);
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
HWY_INLINE void store(const Vec3v& v, double (&values)[3][TileRays::kMost], std::size_t lane) {
  hn::Store(v.x, kDoubles, values[0] + lane);
  hn::Store(v.y, kDoubles, values[1] + lane);
  hn::Store(v.z, kDoubles, values[2] + lane);
}

/// CameraView::pixel_ray, and where the ray is in the visible volume (intersect of core/ray.h).
void set_up_all(const FrameView& frame, double x0, double y0, double apart, std::uint32_t rows,
                TileRays& rays) {
  const scene::CameraView& camera = frame.camera;
  constexpr std::size_t kEdge = exec::TileGrid::kTile;
  for (std::size_t lane = 0; lane < rows * kEdge; lane += hn::Lanes(kDoubles)) {
    const Double column = hn::Add(all(static_cast<double>(lane % kEdge)), hn::Iota(kDoubles, 0));
    const Double x = hn::Add(all(x0), hn::Mul(column, all(apart)));
    const std::size_t row = lane / kEdge;
    const double y = y0 + static_cast<double>(row) * apart;
    const Double right = hn::Mul(hn::Sub(hn::Add(x, all(0.5)), all(camera.half_width)), all(camera.pixel));
    const Double up = all((camera.half_height - y - 0.5) * camera.pixel);
    const Vec3v across = right * camera.right + up * camera.up;
    Vec3v origin = constant(camera.eye), direction = constant(camera.forward);
    if (camera.orthographic) {
      origin = origin + across;
    } else {
      const Vec3v way = direction + across;
      const Double square =
          hn::Add(hn::Add(hn::Mul(way.x, way.x), hn::Mul(way.y, way.y)), hn::Mul(way.z, way.z));
      const Double length = hn::Sqrt(square);
      direction = {hn::Div(way.x, length), hn::Div(way.y, length), hn::Div(way.z, length)};
    }
    store(origin, rays.world_origin, lane);
    hn::Store(to_floats(direction.x), kHalfFloats, rays.world_direction[0] + lane);
    hn::Store(to_floats(direction.y), kHalfFloats, rays.world_direction[1] + lane);
    hn::Store(to_floats(direction.z), kHalfFloats, rays.world_direction[2] + lane);
    origin = vector(frame.world_to_tree, origin) + constant(frame.world_to_tree.origin);
    direction = vector(frame.world_to_tree, direction);
    store(origin, rays.origin, lane);
    store(direction, rays.direction, lane);
    Double enter = hn::Zero(kDoubles), exit = all(1e300);
    Mask outside = hn::Lt(exit, enter);
    const auto along = [&](Double o, Double d, int axis) HWY_ATTR {
      const Double low = all(frame.box.minimum[axis]), high = all(frame.box.maximum[axis]);
      const Double to_low = hn::Div(hn::Sub(low, o), d), to_high = hn::Div(hn::Sub(high, o), d);
      const Mask still = hn::Eq(d, hn::Zero(kDoubles));
      outside = hn::Or(outside, hn::And(still, hn::Or(hn::Lt(o, low), hn::Gt(o, high))));
      enter = hn::IfThenElse(still, enter, hn::Max(enter, hn::Min(to_low, to_high)));
      exit = hn::IfThenElse(still, exit, hn::Min(exit, hn::Max(to_low, to_high)));
      hn::Store(hn::Div(all(1), d), kDoubles, rays.inverse[axis] + lane);
    };
    along(origin.x, direction.x, 0);
    along(origin.y, direction.y, 1);
    along(origin.z, direction.z, 2);
    outside = hn::Or(outside, hn::Not(hn::Lt(enter, exit)));
    hn::Store(hn::IfThenElse(outside, all(1), enter), kDoubles, rays.enter + lane);
    hn::Store(hn::IfThenElseZero(hn::Not(outside), exit), kDoubles, rays.exit + lane);
  }
}

/// Reads and writes what belongs to rays that stand anywhere in the tile.
struct Anywhere {
  Long ray;

  HWY_INLINE Double read(const double* values) const { return gather(values, ray); }
  HWY_INLINE void write(Double value, double* values) const {
    hn::ScatterIndex(value, kDoubles, values, ray);
  }
};
/// Of rays that stand side by side.
struct SideBySide {
  std::size_t first;

  HWY_INLINE Double read(const double* values) const { return hn::LoadU(kDoubles, values + first); }
  HWY_INLINE void write(Double value, double* values) const { hn::StoreU(value, kDoubles, values + first); }
};

/// Calls step(i, access) for each vector of a list's rays, which ascend. Those of a tile's row often move
/// together.
template <typename Step>
HWY_INLINE void for_vectors(const RayList& list, const Step& step) {
  constexpr std::size_t kLanes = hn::MaxLanes(kDoubles);
  for (std::size_t i = 0; i < list.size; i += kLanes) {
    const std::int32_t first = list.ray[i];
    const bool whole = i + kLanes <= list.size;
    if (whole && list.ray[i + kLanes - 1] - first == static_cast<std::int32_t>(kLanes) - 1) {
      step(i, SideBySide{static_cast<std::size_t>(first)});
    } else {
      step(i, Anywhere{load_indices(list.ray + i)});
    }
  }
}

/// Where rays come from: the eye is the same for all.
template <typename Access>
HWY_INLINE Double origin_of(const FrameView& frame, const TileRays& rays, const Access& access, int axis) {
  return frame.camera.orthographic ? access.read(rays.origin[axis]) : all(rays.origin[axis][0]);
}

void find_cells_of(const FrameView& frame, const TileRays& rays, const RayList& list, RaySteps& steps) {
  for_vectors(list, [&](std::size_t i, const auto& access) HWY_ATTR {
    const Double to_centre = hn::Add(access.read(rays.tick), hn::Mul(all(0.5), access.read(rays.stride)));
    const Double centre = hn::Add(access.read(rays.enter), hn::Mul(to_centre, all(frame.tick_world)));
    const Mask within = hn::Lt(centre, access.read(rays.exit));
    hn::Store(hn::IfThenElse(within, centre, all(-1)), kDoubles, steps.centre + i);
    const Double across = access.read(rays.across);
    for (int axis = 0; axis < 3; ++axis) {
      const Double way = hn::Mul(centre, access.read(rays.direction[axis]));
      const Double p = hn::Add(origin_of(frame, rays, access, axis), way);
      // cell_along of tree_walk.h.
      const Double held = hn::Min(hn::Max(p, all(frame.box.minimum[axis])), all(frame.last_inside[axis]));
      hn::Store(hn::DemoteTo(kHalfInts, hn::Mul(held, across)), kHalfInts, steps.cell[axis] + i);
    }
  });
}

/// RayMarcher::take.
void leave_nodes_of(const FrameView& frame, const NodeFaces& nodes, const RayList& list, RaySteps& steps,
                    TileRays& rays) {
  const Double zero = hn::Zero(kDoubles), one = all(1);
  const Long to_high = hn::Set(kLongs, NodeFaces::kMost);
  const bool zones = frame.lod_distance[0] < 1e300;
  for_vectors(list, [&](std::size_t i, const auto& access) HWY_ATTR {
    const Long node = load_indices(steps.node + i);
    Double exit = access.read(rays.exit);
    for (int axis = 0; axis < 3; ++axis) {
      const Double direction = access.read(rays.direction[axis]);
      const Long high =
          hn::BitCast(kLongs, hn::IfThenElseZero(hn::Gt(direction, zero), hn::BitCast(kDoubles, to_high)));
      const Double face = gather(nodes.face[axis], hn::Add(node, high));
      const Double from = origin_of(frame, rays, access, axis);
      const Double t = hn::Mul(hn::Sub(face, from), access.read(rays.inverse[axis]));
      exit = hn::IfThenElse(hn::And(hn::Lt(t, exit), hn::Ne(direction, zero)), t, exit);
    }
    const Double stride = gather(nodes.stride, node), tick = access.read(rays.tick);
    const Double centre = hn::Load(kDoubles, steps.centre + i);
    const Double count = hn::Div(hn::Sub(exit, centre), hn::Mul(all(frame.tick_world), stride));
    Double whole = hn::Ceil(hn::IfThenElse(hn::Gt(count, one), hn::Min(count, all(1e15)), one));
    if (zones) {
      const Double to_zone_end = hn::Div(hn::Sub(access.read(rays.zone_end), tick), stride);
      const Mask zoned = hn::Gt(gather(nodes.zoned, node), zero);
      whole = hn::IfThenElse(zoned, hn::Min(whole, to_zone_end), whole);
    }
    whole = hn::Min(whole, gather(nodes.most_steps, node));
    hn::Store(whole, kDoubles, steps.steps + i);
    access.write(hn::Add(tick, hn::Mul(whole, stride)), rays.tick);
  });
}

HWY_INLINE void fill_path(const TileRays& rays, Long ray, Double centre, Double t_step,
                          const BrickPlace& place, double m, std::size_t i, StretchBatch::Path& path) {
  for (int axis = 0; axis < 3; ++axis) {
    const Double direction = gather(rays.direction[axis], ray);
    const Double p = hn::Add(gather(rays.origin[axis], ray), hn::Mul(centre, direction));
    const Double first = hn::Mul(hn::Sub(hn::Mul(p, all(place.across)), all(place.corner[axis])), all(m));
    const Double per_step = hn::Mul(hn::Mul(hn::Mul(direction, t_step), all(place.across)), all(m));
    hn::Store(to_floats(first), kHalfFloats, path.first[axis] + i);
    hn::Store(to_floats(per_step), kHalfFloats, path.per_step[axis] + i);
  }
}

void fill_batch_of(const FrameView& frame, const TileRays& rays, const RayList& list, int level,
                   const BrickPlace& fine, const BrickPlace& coarse, StretchBatch& batch) {
  const Double t_step = all(frame.tick_world * static_cast<double>(frame.stride[level]));
  const double m = batch.m;
  const scene::Lighting& lighting = frame.lighting.lighting;
  const bool lit = lighting.enabled, near_lights = lighting.has_points();
  // FrameView::share_at is even in t.
  const double share_first = batch.blended ? frame.share_at(level, 0) : 0;
  const double share_slope = batch.blended ? frame.share_at(level, 1) - share_first : 0;
  const auto gather_floats = [](const float* values, hn::Vec<HalfInts> ray)
                                 HWY_ATTR { return hn::GatherIndex(kHalfFloats, values, ray); };
  batch.count = list.size;
  for (std::size_t i = 0; i < list.size; i += hn::Lanes(kDoubles)) {
    const auto short_ray = hn::Load(kHalfInts, list.ray + i);
    const Long ray = hn::PromoteTo(kLongs, short_ray);
    const Double centre = gather(rays.centre, ray);
    fill_path(rays, ray, centre, t_step, fine, m, i, batch.fine);
    if (batch.blended) {
      fill_path(rays, ray, centre, t_step, coarse, m, i, batch.coarse);
      const Double share = hn::Add(all(share_first), hn::Mul(centre, all(share_slope)));
      hn::Store(to_floats(share), kHalfFloats, batch.blend + i);
      hn::Store(to_floats(hn::Mul(t_step, all(share_slope))), kHalfFloats, batch.blend_per_step + i);
    }
    hn::Store(hn::GatherIndex(kHalfInts, rays.steps, short_ray), kHalfInts, batch.steps + i);
    for (int c = 0; c < 3; ++c) {
      hn::Store(gather_floats(rays.color[c], short_ray), kHalfFloats, batch.color[c] + i);
    }
    hn::Store(gather_floats(rays.opacity, short_ray), kHalfFloats, batch.opacity + i);
    hn::Store(hn::GatherIndex(kHalfInts, rays.samples, short_ray), kHalfInts, batch.samples + i);
    if (!lit) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const auto direction = gather_floats(rays.world_direction[axis], short_ray);
      hn::Store(hn::Neg(direction), kHalfFloats, batch.to_eye[axis] + i);
      if (!near_lights) continue;
      const Double way = hn::PromoteTo(kDoubles, direction);
      const Double place = hn::Add(gather(rays.world_origin[axis], ray), hn::Mul(centre, way));
      hn::Store(to_floats(place), kHalfFloats, batch.place[axis] + i);
      hn::Store(to_floats(hn::Mul(way, t_step)), kHalfFloats, batch.place_per_step[axis] + i);
    }
  }
}

void take_back_all(const StretchBatch& batch, const RayList& list, TileRays& rays) {
  for (std::size_t i = 0; i < list.size; ++i) {
    const auto ray = static_cast<std::size_t>(list.ray[i]);
    for (int c = 0; c < 3; ++c) rays.color[c][ray] = batch.color[c][i];
    rays.opacity[ray] = batch.opacity[i];
    rays.samples[ray] = batch.samples[i];
  }
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(set_up_all);
HWY_EXPORT(find_cells_of);
HWY_EXPORT(leave_nodes_of);
HWY_EXPORT(fill_batch_of);
HWY_EXPORT(take_back_all);

namespace {

/// Vectors are read whole: what lies behind the last ray is made the last one again.
template <typename T>
void repeat_last(T* values, std::uint32_t size) {
  for (std::uint32_t i = size; i % (64 / sizeof(double)) != 0; ++i) values[i] = values[size - 1];
}

}  // namespace

void set_up(const FrameView& frame, double x0, double y0, double apart, std::uint32_t rows, TileRays& rays) {
  HWY_DYNAMIC_DISPATCH(set_up_all)(frame, x0, y0, apart, rows, rays);
}

void find_cells(const FrameView& frame, const TileRays& rays, RayList& list, RaySteps& steps) {
  repeat_last(list.ray, list.size);
  HWY_DYNAMIC_DISPATCH(find_cells_of)(frame, rays, list, steps);
}

void leave_nodes(const FrameView& frame, const NodeFaces& nodes, RayList& list, RaySteps& steps,
                 TileRays& rays) {
  repeat_last(list.ray, list.size);
  repeat_last(steps.node, list.size);
  repeat_last(steps.centre, list.size);
  HWY_DYNAMIC_DISPATCH(leave_nodes_of)(frame, nodes, list, steps, rays);
}

void fill_batch(const FrameView& frame, const TileRays& rays, RayList& list, int level,
                const BrickPlace& fine, const BrickPlace& coarse, StretchBatch& batch) {
  repeat_last(list.ray, list.size);
  HWY_DYNAMIC_DISPATCH(fill_batch_of)(frame, rays, list, level, fine, coarse, batch);
}

void take_back(const StretchBatch& batch, const RayList& list, TileRays& rays) {
  HWY_DYNAMIC_DISPATCH(take_back_all)(batch, list, rays);
}

}  // namespace gvx::render
#endif
