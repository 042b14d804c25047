/// \file
/// TileMarcher: the rays of one tile, whatever the voxels are. Private to this room.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "gvx/core/result.h"
#include "gvx/exec/host_memory.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/render/reference/gather.h"
#include "gvx/render/reference/march_view.h"
#include "gvx/render/reference/tree_walk.h"
#include "gvx/render/tile/place_bricks.h"
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

/// Where the states of a tile's rays are to be put: rows of `width`, from each to the next so many states.
struct TileStates {
  const RayState* first = nullptr;
  std::size_t row = 0;
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

/// What all tiles share in which an object is marched.
struct TilesView {
  const FilmView& film;
  WalkView walk;
  TileBricks bricks;
  brick::CellMaskView cells;

  TilesView(const Pass& pass, const ObjectView& object)
      : film(pass.film), walk(walk_view_of(object, pass.number)), bricks(object), cells(object.cells) {}
};

template <int N>
class TileMarcher {
 public:
  /// The rays through the pixels (x0 + i * apart, y0 + j * apart), i and j below `edge`, all at their start;
  /// `preview`: they make do with what is resident. A thread has one at a time.
  TileMarcher(const TilesView& tiles, const TileProjection& projection, double x0, double y0, double apart,
              std::uint32_t edge, bool preview)
      : film_(tiles.film),
        view_(tiles.walk),
        walk_(tiles.walk),
        preview_(preview),
        zones_(view_.frame.bundle.fixed_blend < 0 && view_.frame.bundle.lod_distance[0] < 1e300),
        blends_(view_.frame.format.content != VoxelContent::labels),
        projects_(render::projects(view_.frame)),
        vectors_(vectors_for(view_.frame)),
        bricks_(tiles.bricks),
        place_bricks_(view_.frame, tiles.bricks, tiles.cells, vectors_),
        projection_(projection),
        x0_(x0),
        y0_(y0),
        apart_(apart),
        edge_(edge),
        work_(this_threads_workspace()) {
    const FrameView& frame = view_.frame;
    active_ = ActiveRays::all_of(edge, edge);
    projection_.begin_tile(x0, y0);
    if (film_.camera.orthographic) {
      const Vec3d forward = frame.world_to_tree.vector(film_.camera.forward);
      for (int axis = 0; axis < 3; ++axis) viewpoint_[axis] = forward[axis] > 0 ? -1e300 : 1e300;
    }
    if (preview || projects_ || film_.proxy != nullptr) set_out();
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

  /// Marches until no ray has anything to go through, or the deadline.
  void march(exec::Deadline deadline) {
    deadline_ = deadline;
    left_ = active_.count();
    const ActiveRays begun = active_;
    At root;
    root.cell = view_.frame.bundle.root;
    if (left_ > 0 && !view_.hidden.at(0, 0)) visit(root, TileRect());
    if (projects_ && !stopped_) {
      begun.for_each([&](std::uint32_t ray) {
        if (!blocked_.has(ray)) finish_projecting(ray);
      });
    }
  }

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

  /// A node on the way down.
  struct At {
    NodeIndex node, parent;
    int level = 0;
    Vec3d cell;  // counted from the eye's
    int ancestor_level = -1;
    BrickIndex ancestor_slot;  // of the finest node above that has a brick
  };
  /// The levels that steps within a node may be of.
  struct Levels {
    int finest, coarsest;
    double nearest = 0, farthest = 0;  // distances of the node
  };

  /// The rays are set out when the first of them is needed: of most tiles beside an object none is.
  void set_out() {
    if (has_set_out_) return;
    has_set_out_ = true;
    states_.prefetch();
    const FrameView& frame = view_.frame;
    TileRays& rays = work_.rays;
    const ActiveRays wanted = active_;
    active_ = set_up(frame, film_.camera, x0_, y0_, apart_, edge_, rays);
    const std::uint32_t many = edge_ * TileRays::kEdge;
    std::fill_n(rays.tick, many, 0.0);
    std::memset(rays.gathered, 0, many * sizeof(rays.gathered[0]));
    std::memset(rays.samples, 0, many * sizeof(rays.samples[0]));
    if (film_.proxy != nullptr) cut_by_proxy();
    if (preview_) std::fill_n(work_.pixel, many, PreviewPixel());
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

  /// Only what the proxy leaves of the rays.
  void cut_by_proxy() {
    const FrameView& frame = view_.frame;
    TileRays& rays = work_.rays;
    active_.for_each([&](std::uint32_t ray) {
      const std::uint32_t column = ray % TileRays::kEdge, row = ray / TileRays::kEdge;
      const double x = x0_ + apart_ * column, y = y0_ + apart_ * row;
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

  /// Goes through a node and all below it, nearest first, with the rays of a rectangle, which may meet it.
  void visit(const At& at, const TileRect& rect) {
    const FrameView& frame = view_.frame;
    const tree::ChildWord child = view_.nodes.child[at.node.value];
    const LevelView& level = frame.bundle.levels[at.level];
    const NodeBox box{level.corner(at.cell), level.corner(at.cell + Vec3d(1))};
    for (int axis = 0; axis < 3; ++axis) {
      if (box.high[axis] <= frame.bundle.box.minimum[axis] || box.low[axis] >= frame.bundle.box.maximum[axis])
        return;
    }
    if (projects_ && all_outdone(at.node, rect)) return;
    // Rays that go on have passed the nodes before: these are neither kept nor asked for.
    if (resumed_ && !any_inside(frame, work_.rays, active_, box, rect)) return;
    view_.tile_usage.touch(at.node.value / (N * N * N), view_.pass);
    const tree::ContentWord content = view_.nodes.content[at.node.value];
    Place place = place_at(at);
    const Levels levels = levels_in(box);
    if (content.kind() == tree::ContentKind::constant) {
      place.kind = Place::constant;
      // Steps of coarser levels than this node's are taken by nodes above, after those in its siblings.
      return go_through(place, box, rect, levels, levels.finest, std::max(levels.coarsest, at.level));
    }
    const bool has_brick = content.kind() == tree::ContentKind::brick;
    if (levels.finest > at.level && !child.terminal()) {
      At within = at;
      within.parent = at.node;
      if (has_brick) {
        within.ancestor_level = at.level;
        within.ancestor_slot = content.brick();
      }
      if (child.has_children()) {
        visit_children(within, child.children(), box, rect);
      } else {
        place = place_at(within);
        place.lack = cache::kNeedsChildren;
        go_through(place, box, rect, levels, levels.finest, at.level + 1);
        place = place_at(at);
      }
      if (stopped_ || levels.coarsest > at.level) return;
    }
    place.kind = has_brick ? Place::brick : Place::nothing;
    place.lack = has_brick ? 0 : cache::kNeedsBrick;
    place.slot = content.brick();
    place.brick_level = at.level;
    place.finest = child.terminal();
    go_through(place, box, rect, levels, child.terminal() ? levels.finest : at.level, at.level);
  }

  void visit_children(const At& within, TileIndex tile, const NodeBox& box, const TileRect& rect) {
    At child = within;
    child.level = within.level + 1;
    const LevelView& level = view_.frame.bundle.levels[child.level];
    typename TileProjection::Rects rects;
    projection_.project_children(box.low, level.edge_high, N, rects);
    int order[3][N];
    for (int axis = 0; axis < 3; ++axis) {
      order_along((viewpoint_[axis] - box.low[axis]) * level.across, order[axis]);
    }
    const Vec3d first = double(N) * within.cell - level.digit;
    for (const int z : order[2]) {
      for (const int y : order[1]) {
        for (const int x : order[0]) {
          const auto index = static_cast<std::uint32_t>(x + N * (y + N * z));
          if (view_.hidden.at(tile.value, index)) continue;
          TileRect met = rects[index];
          met = {std::max(met.x0, rect.x0), std::min(met.x1, rect.x1), std::max(met.y0, rect.y0),
                 std::min(met.y1, rect.y1)};
          if (met.empty() || !active_.any_in(met)) continue;
          child.node = NodeIndex(tile.value * (N * N * N) + index);
          child.cell = first + Vec3d(x, y, z);
          visit(child, met);
          if (stopped_ || left_ == 0) return;
        }
      }
    }
  }

  /// Children along an axis, those nearer to the eye first; it is at `eye`, in children.
  static void order_along(double eye, int (&order)[N]) {
    const int first = eye < 1 ? 0 : eye >= N - 1 ? N - 1 : static_cast<int>(eye);
    int count = 0;
    order[count++] = first;
    for (int step = 1; step < N; ++step) {
      if (first - step >= 0) order[count++] = first - step;
      if (first + step < N) order[count++] = first + step;
    }
  }

  Place place_at(const At& at) const {
    Place place;
    place.node = at.node;
    place.parent = at.parent;
    place.level = at.level;
    place.cell = at.cell;
    place.ancestor_level = at.ancestor_level;
    place.ancestor_slot = at.ancestor_slot;
    return place;
  }

  /// Certain not to leave out any: a zone may begin and end up to a step late.
  Levels levels_in(const NodeBox& box) const {
    const FrameView& frame = view_.frame;
    if (frame.bundle.fixed_blend >= 0) return {frame.bundle.fixed_level, frame.bundle.fixed_level};
    if (!zones_) return {frame.max_level, frame.max_level};
    const TileProjection::Distances t = projection_.distances(box);
    Levels levels{frame.max_level, frame.max_level, t.nearest, t.farthest};
    while (levels.finest > 0 && t.nearest > zone_ends(levels.finest - 1)) --levels.finest;
    while (levels.coarsest > 0 && t.farthest >= zone_begins(levels.coarsest - 1)) --levels.coarsest;
    return levels;
  }
  double zone_begins(int level) const {
    const double t = view_.frame.bundle.lod_distance[level];
    return t - 1e-9 * std::fabs(t);
  }
  /// Up to where rays may not have noticed yet that the zone of `level` has begun.
  double zone_ends(int level) const {
    const FrameView& frame = view_.frame;
    const double t = frame.bundle.lod_distance[level];
    return t + 1e-9 * std::fabs(t) + 2 * frame.stride_of(level, level > 0) * frame.tick_world;
  }
  bool may_be_zone(int level, bool blended, const Levels& levels) const {
    const FrameView& frame = view_.frame;
    if (level == 0 || !blends_) return !blended;
    if (frame.bundle.fixed_blend >= 0) return blended == (frame.bundle.fixed_blend > 0);
    if (!zones_) return !blended;
    if (level < frame.max_level) return blended;
    return blended ? levels.farthest >= zone_begins(level) : levels.nearest <= zone_ends(level);
  }

  /// All steps of levels from `finest` to `coarsest`: a ray comes from finer ones to coarser ones.
  void go_through(const Place& place, const NodeBox& box, const TileRect& rect, const Levels& levels,
                  int finest, int coarsest) {
    for (int level = finest; level >= coarsest; --level) {
      for (const bool blended : {false, true}) {
        if (stopped_ || !may_be_zone(level, blended, levels)) continue;
        go_through(place, box, rect, level, blended);
      }
    }
  }

  /// Those of one zone.
  void go_through(Place place, const NodeBox& box, const TileRect& rect, int level, bool blended) {
    if (blended && place.kind != Place::constant && place.level == level) {
      place.blended = place.ancestor_level == level - 1;
      place.lacks_coarse = !place.blended;
      place.parent_slot = place.ancestor_slot;
    }
    const bool stops = place.lacks() && !preview_;
    const Place shown = place.lack != 0 && preview_ ? walk_.stand_in(place) : place;
    StretchesWanted wanted;
    wanted.zone = TileRays::zone_number(level, blended);
    wanted.coarser = shown.coarser_than(level);
    wanted.step_level = wanted.coarser ? shown.brick_level : level;
    wanted.stride =
        wanted.coarser ? view_.frame.stride[shown.brick_level] : view_.frame.stride_of(level, blended);
    work_.batch.blended = false;
    const bool is_brick = shown.kind == Place::brick && !stops;
    const bool seen = is_brick && place_bricks_.prepare(shown, level, wanted, work_.batch);
    // Cells that cannot be seen are nobody's business, unless rays are counted or have passed them.
    if (is_brick && !seen && !preview_ && !resumed_) return walk_.touch_bricks(shown);
    set_out();
    StretchBatch& batch = work_.batch;
    gather_stretches(view_.frame, active_, box, rect, wanted, work_.rays, batch);
    if (projects_) drop_outdone(place.node);
    if (batch.count == 0) return;
    if (place.lacks()) {
      float least_opacity = 1;
      for (std::uint32_t i = 0; i < batch.count; ++i) {
        least_opacity = std::min(least_opacity, work_.rays.gathered[batch.ray(i)][3]);
      }
      walk_.ask(place, 1 - least_opacity);
      if (stops) return block();
      walk_.ask_for_own(place);
    }
    if (preview_) count_wanted(place, level);
    if (shown.kind == Place::constant) gather_constants(shown);
    if (!is_brick) return;
    walk_.touch_bricks(shown);
    if (!seen) return;
    gather(shown, wanted, level);
    // Beginning a tile costs something: one that was begun comes a good part further.
    constexpr int kLeastBatches = 32;
    stopped_ = ++batches_ >= kLeastBatches && exec::late(deadline_);
  }

  /// From the batch's stretches.
  void gather(const Place& place, const StretchesWanted& wanted, int level) {
    const FrameView& frame = view_.frame;
    StretchBatch& batch = work_.batch;
    if (projects_) batch.ranges = walk_.ranges_of(place);
    if (vectors_ == Vectors::none) return gather_ray_by_ray(place, wanted, level);
    gather_batch(vectors_, frame, batch);
    for (std::uint32_t i = 0; i < batch.opaque_count; ++i)
      retire(static_cast<std::uint32_t>(batch.opaque[i]));
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

  void count_wanted(const Place& place, int level) {
    const std::uint32_t lack = place.lack != 0 ? place.lack_of(level) : 0;
    for (std::uint32_t i = 0; i < work_.batch.count; ++i) {
      PreviewPixel& pixel = work_.pixel[work_.batch.ray(i)];
      ++pixel.wanted;
      pixel.resident += place.lacks() ? 0 : 1;
      pixel.worst_lack = std::max(pixel.worst_lack, lack);
    }
  }

  /// The rays of the list stop before what they were to go through.
  void block() {
    for (std::uint32_t i = 0; i < work_.batch.count; ++i) {
      const std::uint32_t ray = work_.batch.ray(i);
      work_.rays.tick[ray] = work_.rays.start[ray];
      blocked_.set(ray);
      retire(ray);
    }
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

  /// The ray has nothing more to do in this pass.
  void retire(std::uint32_t ray) {
    work_.rays.exit[ray] = -1;
    active_.clear(ray);
    --left_;
  }

  void gather_constants(const Place& place) {
    const ChannelRanges values = walk_.ranges_of(place);
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

  void put(std::uint32_t ray, const RayState& state) {
    float(&gathered)[4] = work_.rays.gathered[ray];
    for (int c = 0; c < 3; ++c) gathered[c] = state.color[c];
    gathered[3] = state.opacity;
    work_.rays.samples[ray] = static_cast<std::int32_t>(state.samples);
  }

  const FilmView& film_;
  const WalkView& view_;
  const TreeWalk<N> walk_;
  const bool preview_;
  const bool zones_;   // there are several along a ray
  const bool blends_;  // levels
  const bool projects_;
  const Vectors vectors_;
  const TileBricks& bricks_;
  const PlaceBricks<N> place_bricks_;
  TileProjection projection_;
  const double x0_, y0_, apart_;
  const std::uint32_t edge_;
  bool has_set_out_ = false;
  TileStates states_;
  Vec3d viewpoint_;  // that of the rays, from the eye: very far behind it where they are parallel
  Workspace& work_;
  ActiveRays active_, blocked_, stubs_;
  std::uint32_t left_ = 0;  // active ones
  bool resumed_ = false;    // some ray was on its way before
  bool stopped_ = false;    // by the deadline
  int batches_ = 0;
  exec::Deadline deadline_;
};

}  // namespace gvx::render
