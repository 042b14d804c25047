/// \file
/// MarchingRays: the rays of one tile on their way: what each has gathered, and which are still to march. The
/// nodes that they come to are TileMarcher's to find. Private to this room.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "gvx/core/result.h"
#include "gvx/exec/host_memory.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/render/reference/gather.h"
#include "gvx/render/reference/march_view.h"
#include "gvx/render/reference/tree_walk.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/tile/tile_bricks.h"
#include "gvx/render/tile/tile_rays.h"
#include "gvx/render/vectors/vectors.h"

namespace gvx::render {

/// What a tile's march works in, for whichever tree. It takes 2 MB, which no stack should hold and no tile
/// should wait for: each thread keeps one.
struct Workspace {
  TileRays rays;
  StretchBatch batch;
  PreviewPixel pixel[TileRays::kMost];  // their counts
};

inline Workspace& this_threads_workspace() {
  thread_local const exec::HostMemory memory(sizeof(Workspace));
  static_assert(alignof(Workspace) <= exec::HostMemory::kAlignment);
  thread_local Workspace* const workspace = new (memory.data()) Workspace();
  return *workspace;
}

/// Where the states of a tile's rays are to be put.
struct TileStates {
  const RayState* first = nullptr;
  std::size_t row = 0;  ///< states from the start of a row to that of the next
  std::uint32_t width = 0, height = 0;

  /// Has the processor fetch what is about to be written.
  void prefetch() const {
#if defined(__GNUC__)
    for (std::uint32_t j = 0; j < height; ++j) {
      const auto* at = reinterpret_cast<const char*>(first + j * row);
      const std::size_t bytes = width * sizeof(RayState);
      // A row may begin in the middle of what is fetched at once.
      for (std::size_t byte = 0; byte < bytes + 63; byte += 64) {
        __builtin_prefetch(at + std::min(byte, bytes - 1), 1);
      }
    }
#endif
  }
};

/// What the marches of an object's tiles share. Its frame is of the film's own rays.
struct TilesView {
  const FilmView& film;
  WalkView walk;
  TileBricks bricks;
  brick::CellMaskView cells;

  TilesView(const Pass& pass, const ObjectView& object)
      : film(pass.film), walk(walk_view_of(object, pass.number)), bricks(object), cells(object.cells) {
    GVX_CHECK(object.frame.bundle.origin_world == film.camera.eye);
  }
};

/// Are there several zones (FrameView::Zone) along a ray?
inline bool has_zones(const FrameView& frame) {
  return frame.bundle.fixed_blend < 0 && frame.bundle.lod_distance[0] < 1e300;
}

template <int N>
class MarchingRays {
 public:
  /// All at their start. A thread has one at a time.
  MarchingRays(const TilesView& tiles, const RaysOfTile& tile)
      : film_(tiles.film),
        view_(tiles.walk),
        tile_(tile),
        zones_(has_zones(view_.frame)),
        projects_(render::projects(view_.frame)),
        vectors_(vectors_for(view_.frame)),
        bricks_(tiles.bricks),
        work_(this_threads_workspace()),
        active_(ActiveRays::all_of(tile.edge, tile.edge)) {
    if (tile.preview || projects_ || film_.proxy != nullptr) set_out();
  }

  /// Ray `index` goes on from where it was.
  void resume(std::uint32_t index, const RayState& state) {
    set_out();
    // One that has come from another object begins where a proxy says.
    work_.rays.tick[index] = std::max(work_.rays.tick[index], state.tick);
    put(index, state);
    if (zones_) work_.rays.find_zone(view_.frame, index);
    resumed_ = resumed_ || state.tick > 0;
  }
  /// No other rays than these take part.
  void leave_out_all_but(const ActiveRays& rays) {
    for (std::uint32_t y = 0; y < TileRays::kEdge; ++y) {
      for (std::uint64_t out = active_.row[y] & ~rays.row[y]; out != 0; out &= out - 1) {
        work_.rays.exit[y * TileRays::kEdge + static_cast<std::uint32_t>(std::countr_zero(out))] = -1;
      }
      active_.row[y] &= rays.row[y];
    }
  }

  /// All of these are to be written, when the rays see anything.
  void will_put(const TileStates& states) { states_ = states; }
  /// Does no ray of those that march see anything?
  bool is_blank() const { return !has_set_out_; }

  /// Is the ray so short that it has no step, but must have a value all the same? Another must march it.
  bool is_stub(std::uint32_t index) const { return projects_ && stubs_.has(index); }
  /// Where ray `index` is now: all of the state but its epoch. Number by number, since a copy of a state that
  /// was just put together waits for all of its stores.
  void put_state(std::uint32_t index, RayState& state) const {
    if (!has_set_out_) {  // one ray alone, that sees nothing
      state = RayState{};
      state.phase = RayPhase::finished;
      return;
    }
    const TileRays& rays = work_.rays;
    state.tick = rays.tick[index];
    put_gathered(rays.gathered[index], state);
    state.samples = static_cast<std::uint32_t>(rays.samples[index]);
    const bool goes_on = blocked_.has(index) || (stopped_ && active_.has(index));
    state.phase = goes_on ? RayPhase::under_way : RayPhase::finished;
  }
  /// What a preview of it shows.
  PreviewPixel pixel(std::uint32_t index) const {
    PreviewPixel pixel = work_.pixel[index];
    const float(&gathered)[4] = work_.rays.gathered[index];
    pixel.color = {gathered[0], gathered[1], gathered[2]};
    pixel.opacity = gathered[3];
    return pixel;
  }

  // For the walk through the nodes:

  /// Those that still have something to go through.
  const ActiveRays& active() const { return active_; }
  bool any_left() const { return left_ > 0; }
  /// Begins to count them.
  void begin() { left_ = active_.count(); }
  /// They march no further in this pass, but will go on.
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }
  bool is_blocked(std::uint32_t ray) const { return blocked_.has(ray); }
  /// Was some ray on its way before?
  bool resumed() const { return resumed_; }
  /// Has any active ray some of this node before it?
  bool any_before(const NodeBox& node, const TileRect& rect) const {
    return any_inside(view_.frame, work_.rays, active_, node, rect);
  }
  StretchBatch& batch() { return work_.batch; }

  /// The rays are set out when the first of them is needed: of most tiles beside an object none is.
  void set_out() {
    if (has_set_out_) return;
    has_set_out_ = true;
    states_.prefetch();
    const FrameView& frame = view_.frame;
    TileRays& rays = work_.rays;
    const ActiveRays wanted = active_;
    active_ = set_up(frame, film_.camera, tile_.x0, tile_.y0, tile_.apart, tile_.edge, rays);
    const std::uint32_t many = tile_.edge * TileRays::kEdge;
    std::fill_n(rays.tick, many, 0.0);
    std::memset(rays.gathered, 0, many * sizeof(rays.gathered[0]));
    std::memset(rays.samples, 0, many * sizeof(rays.samples[0]));
    if (film_.proxy != nullptr) cut_by_proxy();
    if (tile_.preview) std::fill_n(work_.pixel, many, PreviewPixel());
    if (zones_) {
      rays.begin_zones();
      active_.for_each([&](std::uint32_t ray) { rays.find_zone(frame, ray); });
    } else {
      rays.fill_zone(frame, many);
    }
    if (projects_) leave_out_stubs();
    leave_out_all_but(wanted);
    left_ = active_.count();
    StretchBatch& batch = work_.batch;
    batch.m = bricks_.m();
    batch.to_eye = rays.to_eye;
    batch.gathered = rays.gathered;
    batch.samples = rays.samples;
  }

  /// Puts their stretches through a node into the batch, but of a projection those to which it brings
  /// nothing; the rays are put behind them. False where there are none.
  bool take(NodeIndex node, const NodeBox& box, const TileRect& rect, const StretchesWanted& wanted) {
    gather_stretches(view_.frame, active_, box, rect, wanted, work_.rays, work_.batch);
    if (projects_) drop_outdone(node);
    return work_.batch.count > 0;
  }
  /// The most that any ray of the batch may still gain.
  float most_gain() const {
    float least_opacity = 1;
    for (std::uint32_t i = 0; i < work_.batch.count; ++i) {
      least_opacity = std::min(least_opacity, work_.rays.gathered[work_.batch.ray(i)][3]);
    }
    return 1 - least_opacity;
  }
  /// The rays of the batch stop before what they were to go through.
  void block() {
    for (std::uint32_t i = 0; i < work_.batch.count; ++i) {
      const std::uint32_t ray = work_.batch.ray(i);
      work_.rays.tick[ray] = work_.rays.start[ray];
      blocked_.set(ray);
      retire(ray);
    }
  }

  /// Previews: they wanted `level` there.
  void count_wanted(const Place& place, int level) {
    const std::uint32_t lack = place.lack != 0 ? place.lack_of(level) : 0;
    for (std::uint32_t i = 0; i < work_.batch.count; ++i) {
      PreviewPixel& pixel = work_.pixel[work_.batch.ray(i)];
      ++pixel.wanted;
      pixel.resident += place.lacks() ? 0 : 1;
      pixel.worst_lack = std::max(pixel.worst_lack, lack);
    }
  }

  /// The rays of the batch go through matter of one value.
  void gather_constant_matter(const ChannelRanges& values) {
    TileRays& rays = work_.rays;
    for (std::uint32_t i = 0; i < work_.batch.count; ++i) {
      const std::uint32_t ray = work_.batch.ray(i);
      RayState state = state_of(ray);
      state.phase = RayPhase::under_way;
      const double steps = std::rint((rays.tick[ray] - rays.start[ray]) / rays.stride[ray]);
      constexpr double kMostSteps = 1e15;
      gather_constant(ray_view(ray), values, rays.stride[ray],
                      static_cast<std::int64_t>(std::min(steps, kMostSteps)), state);
      put(ray, state);
      if (state.phase == RayPhase::finished) retire(ray);
    }
  }

  /// And through the bricks of a place, as steps of `level`; of projections with the values it may hold.
  void gather(const Place& place, const StretchesWanted& wanted, int level, const ChannelRanges& ranges) {
    const FrameView& frame = view_.frame;
    StretchBatch& batch = work_.batch;
    batch.ranges = ranges;
    if (vectors_ == Vectors::none) return gather_ray_by_ray(place, wanted, level);
    gather_batch(vectors_, frame, batch);
    for (std::uint32_t i = 0; i < batch.opaque_count; ++i)
      retire(static_cast<std::uint32_t>(batch.opaque[i]));
  }

  /// Can nothing below a node change what any ray of a rectangle has gathered?
  bool all_outdone(NodeIndex node, const TileRect& rect) const {
    for (int y = rect.y0; y <= rect.y1; ++y) {
      for (int x = rect.x0; x <= rect.x1; ++x) {
        const auto ray = static_cast<std::uint32_t>(y) * TileRays::kEdge + static_cast<std::uint32_t>(x);
        if (active_.has(ray) && !is_outdone(node, ray)) return false;
      }
    }
    return true;
  }
  /// Makes a colour of what a ray has gathered on all its way.
  void finish_projecting(std::uint32_t ray) {
    const FrameView& frame = view_.frame;
    TileRays& rays = work_.rays;
    double end;
    while (true) {
      const double steps = (rays.exit[ray] - rays.enter[ray]) * rays.steps_per_t[ray];
      end = std::max(rays.tick[ray], std::ceil(steps - 0.5) * rays.stride[ray]);
      if (end < rays.zone_end[ray]) break;
      rays.tick[ray] = std::max(rays.tick[ray], rays.zone_end[ray]);
      rays.find_zone(frame, ray);
    }
    RayState state = state_of(ray);
    finish_projection(ray_view(ray), static_cast<float>(end), state);
    put(ray, state);
  }

 private:
  /// Colour and opacity at once.
  static void put_gathered(const float (&gathered)[4], RayState& state) {
    static_assert(offsetof(RayState, opacity) == offsetof(RayState, color) + 3 * sizeof(float));
    std::memcpy(reinterpret_cast<std::byte*>(&state) + offsetof(RayState, color), gathered, sizeof(gathered));
  }
  RayState state_of(std::uint32_t index) const {
    RayState state;
    put_state(index, state);
    return state;
  }

  /// Only what the proxy leaves of the rays.
  void cut_by_proxy() {
    const FrameView& frame = view_.frame;
    TileRays& rays = work_.rays;
    active_.for_each([&](std::uint32_t ray) {
      const std::uint32_t column = ray % TileRays::kEdge, row = ray / TileRays::kEdge;
      const double x = tile_.x0 + tile_.apart * column, y = tile_.y0 + tile_.apart * row;
      if (!(x < film_.width && y < film_.height)) return;
      RayInterval inside{rays.enter[ray], rays.exit[ray]};
      const std::size_t index = film_.index(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      rays.tick[ray] = frame.cut(film_.proxy[index], inside);
      rays.exit[ray] = inside.exit;
      resumed_ = resumed_ || rays.tick[ray] > 0;
      if (!inside.empty()) return;
      active_.clear(ray);
      rays.exit[ray] = -1;
    });
  }
  void leave_out_stubs() {
    TileRays& rays = work_.rays;
    active_.for_each([&](std::uint32_t ray) {
      const double centre = rays.enter[ray] + 0.5 * rays.stride[ray] * view_.frame.tick_world;
      if (centre < rays.exit[ray]) return;
      stubs_.set(ray);
      active_.clear(ray);
      rays.exit[ray] = -1;
    });
  }

  void gather_ray_by_ray(const Place& place, const StretchesWanted& wanted, int level) {
    const FrameView& frame = view_.frame;
    const StretchBatch& batch = work_.batch;
    const auto voxels_across = [&](int of_level) {
      return static_cast<float>(BrickCorner<N>(frame, place, of_level).across * bricks_.m());
    };
    BytesStretch s;
    s.level = wanted.step_level;
    s.stride = wanted.stride;
    s.t_step = frame.tick_world * wanted.stride;
    s.fine.brick = bricks_.at(place.slot);
    s.fine.voxels_across = voxels_across(place.brick_level);
    s.fine_deviates = place.deviates(frame, level);
    s.ranges = batch.ranges;
    s.blended = place.blended;
    if (s.blended) {
      s.coarse.brick = bricks_.at(place.parent_slot);
      s.coarse.voxels_across = voxels_across(place.level - 1);
    }
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      const std::uint32_t ray = batch.ray(i);
      s.steps = static_cast<std::int64_t>(batch.steps(i));
      s.t_centre = work_.rays.centre[ray];
      put_path(batch.fine.row[i], s.fine);
      if (s.blended) put_path(batch.coarse.row[i], s.coarse);
      if (frame.adds_noise) {
        const TileRays& rays = work_.rays;
        const Vec3d direction = rays.direction_of(ray);
        s.noisy = &frame;
        s.place = frame.bundle.origin + rays.origin_of(ray) + s.t_centre * direction;
        s.place_step = s.t_step * direction;
      }
      RayState state = state_of(ray);
      state.phase = RayPhase::under_way;
      bricks_.gather_stretch(ray_view(ray), s, state);
      put(ray, state);
      if (state.phase == RayPhase::finished) retire(ray);
    }
  }
  static void put_path(const float (&row)[8], BytesPath& path) {
    path.first = {row[0], row[1], row[2]};
    path.per_step = {row[4], row[5], row[6]};
  }
  RayView ray_view(std::uint32_t ray) const {
    const TileRays& rays = work_.rays;
    const float(&to_eye)[4] = rays.to_eye[ray];
    const Vec3f towards(to_eye[0], to_eye[1], to_eye[2]);
    return {view_.frame, {rays.world_origin_of(ray), -Vec3d(towards)}, towards};
  }

  bool is_outdone(NodeIndex node, std::uint32_t ray) const {
    RayState state = state_of(ray);
    return outdone(view_.frame, view_.nodes, node, state);
  }
  /// Takes those rays out of the batch to which a node can bring nothing.
  void drop_outdone(NodeIndex node) {
    StretchBatch& batch = work_.batch;
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      if (is_outdone(node, batch.ray(i))) continue;
      std::copy_n(batch.fine.row[i], 8, batch.fine.row[kept]);
      if (batch.blended) std::copy_n(batch.coarse.row[i], 8, batch.coarse.row[kept]);
      batch.length[kept++] = batch.length[i];
    }
    batch.count = kept;
  }

  /// The ray has nothing more to do in this pass.
  void retire(std::uint32_t ray) {
    work_.rays.exit[ray] = -1;
    active_.clear(ray);
    --left_;
  }

  void put(std::uint32_t ray, const RayState& state) {
    float(&gathered)[4] = work_.rays.gathered[ray];
    for (int c = 0; c < 3; ++c) gathered[c] = state.color[c];
    gathered[3] = state.opacity;
    work_.rays.samples[ray] = static_cast<std::int32_t>(state.samples);
  }

  const FilmView& film_;
  const WalkView& view_;
  const RaysOfTile tile_;
  const bool zones_, projects_;
  const Vectors vectors_;
  const TileBricks& bricks_;
  bool has_set_out_ = false;
  TileStates states_;
  Workspace& work_;
  ActiveRays active_, blocked_, stubs_;
  std::uint32_t left_ = 0;  // active ones
  bool resumed_ = false;
  bool stopped_ = false;
};

}  // namespace gvx::render
