#include "gvx/render/tile_march.h"

#include <array>
#include <atomic>
#include <optional>

#include "gvx/core/result.h"
#include "gvx/exec/parallel.h"
#include "gvx/render/composite.h"
#include "gvx/render/leaf_table.h"
#include "gvx/render/march_view.h"
#include "gvx/render/stretch_batch.h"
#include "gvx/render/tile_rays.h"
#include "gvx/render/visible_cells.h"

namespace gvx::render {
namespace {

/// What a tile's march works in, for whichever tree; some hundred KB, so each thread keeps its own.
struct Workspace {
  TileRays rays;
  LeafTable leaves;
  StretchBatch batch;
  RayList moving, waited, chosen;
  RaySteps steps;
  PreviewPixel pixel[TileRays::kMost];  // their counts
};

Workspace& this_threads_workspace() {
  thread_local Workspace workspace;
  return workspace;
}

template <typename Voxel, int N, int M>
class TileMarcher {
 public:
  /// The rays through the pixels (x0 + i * apart, y0 + j * apart), `rows` rows of them; `preview`: they make
  /// do with what is resident. A thread has one at a time.
  TileMarcher(const PassView<Voxel, N, M>& view, double x0, double y0, double apart, std::uint32_t rows,
              bool preview)
      : view_(view), walk_(view), preview_(preview), work_(this_threads_workspace()) {
    set_up(view.frame, x0, y0, apart, rows, work_.rays);
    work_.batch.m = M;
    work_.leaves.clear();
    work_.moving.size = 0;
  }

  /// Ray `index` of the tile takes part, from where it is.
  void add(std::uint32_t index, const RayState& state) {
    TileRays& rays = work_.rays;
    rays.tick[index] = static_cast<double>(state.tick);
    for (int c = 0; c < 3; ++c) rays.color[c][index] = state.color[c];
    rays.opacity[index] = state.opacity;
    rays.samples[index] = static_cast<std::int32_t>(state.samples);
    work_.pixel[index] = {};
    finished_[index] = false;
    find_zone(index);
    work_.moving.push(index);
  }

  /// Marches until no ray has anything to go through, or the deadline, at which rays step back before what
  /// they were to go through.
  void march(exec::Deadline deadline) {
    // Stepping back costs the way to the brick again: a tile that was begun comes a good part further.
    constexpr int kLeastBatches = 32;
    advance();
    for (int batches = 0; batches < kLeastBatches || !exec::late(deadline); ++batches) {
      const std::uint32_t nearest = work_.leaves.nearest();
      if (nearest == LeafTable::kNone) return;
      composite(nearest);
      advance();
    }
    step_back();
  }

  /// Where ray `index` is now.
  void take(std::uint32_t index, RayState& state) const {
    const TileRays& rays = work_.rays;
    state.tick = static_cast<std::int64_t>(rays.tick[index]);
    state.color = {rays.color[0][index], rays.color[1][index], rays.color[2][index]};
    state.opacity = rays.opacity[index];
    state.samples = static_cast<std::uint32_t>(rays.samples[index]);
    if (finished_[index]) state.phase = RayPhase::finished;
  }
  /// What a preview of it shows.
  PreviewPixel pixel(std::uint32_t index) const {
    const TileRays& rays = work_.rays;
    PreviewPixel pixel = work_.pixel[index];
    pixel.color = {rays.color[0][index], rays.color[1][index], rays.color[2][index]};
    pixel.opacity = rays.opacity[index];
    return pixel;
  }

 private:
  void find_zone(std::uint32_t ray) {
    TileRays& rays = work_.rays;
    const FrameView& frame = view_.frame;
    const FrameView::Zone zone = frame.zone_at(rays.enter[ray], static_cast<std::int64_t>(rays.tick[ray]));
    rays.level[ray] = zone.level;
    rays.blended[ray] = zone.blended;
    rays.stride[ray] = static_cast<double>(frame.stride[zone.level]);
    rays.zone_end[ray] = zone.end == INT64_MAX ? TileRays::kNever : static_cast<double>(zone.end);
    rays.across[ray] = TreeWalk<Voxel, N, M>::across(zone.level);
  }

  /// Takes the rays that move to bricks, before which they wait, or to their ends.
  void advance() {
    RayList& moving = work_.moving;
    RaySteps& steps = work_.steps;
    LeafTable& leaves = work_.leaves;
    while (moving.size > 0) {
      // Each may find a node of its own.
      if (!leaves.has_room_for(moving.size)) leaves.forget_idle();
      find_cells(view_.frame, work_.rays, moving, steps);
      find_leaves();
      leave_nodes(view_.frame, leaves.faces(), moving, steps, work_.rays);
      std::uint32_t still = 0;
      for (std::uint32_t i = 0; i < moving.size; ++i) {
        if (!goes_on(i)) continue;
        moving.ray[still++] = moving.ray[i];
      }
      moving.size = still;
    }
  }

  /// The leaf of each moving ray; those at their ends, or at a lack that they cannot pass, leave the list.
  void find_leaves() {
    RayList& moving = work_.moving;
    RaySteps& steps = work_.steps;
    TileRays& rays = work_.rays;
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < moving.size; ++i) {
      const auto ray = static_cast<std::uint32_t>(moving.ray[i]);
      if (steps.centre[i] < 0) {
        finished_[ray] = true;
        continue;
      }
      const std::uint32_t index =
          leaf_at(rays.level[ray], rays.blended[ray], {steps.cell[0][i], steps.cell[1][i], steps.cell[2][i]});
      const Place& place = work_.leaves[index].place;
      if (place.lacks()) {
        walk_.ask(place, 1 - rays.opacity[ray]);
        if (!preview_) continue;
      }
      moving.ray[kept] = moving.ray[i];
      steps.centre[kept] = steps.centre[i];
      steps.node[kept++] = static_cast<std::int32_t>(index);
    }
    moving.size = kept;
  }

  std::uint32_t leaf_at(int level, bool blended, Cell cell) {
    const std::uint32_t known = work_.leaves.find(level, blended, cell, N);
    if (known != LeafTable::kNone) return known;
    Leaf leaf;
    leaf.level = level;
    leaf.blended = blended;
    leaf.place = walk_.to(level, blended, {double(cell.x), double(cell.y), double(cell.z)},
                          [](NodeIndex) { return false; });
    Place& place = leaf.place;
    std::int32_t cells = 1;
    for (int l = place.level; l < level; ++l) cells *= N;
    leaf.low = {cell.x / cells * cells, cell.y / cells * cells, cell.z / cells * cells};
    leaf.high = {leaf.low.x + cells, leaf.low.y + cells, leaf.low.z + cells};
    if (preview_ && place.lack != 0) {
      leaf.lack = place.lack_of(level);
      walk_.fall_back(place);
    }
    const bool coarser = place.coarser_than(level);
    leaf.step_level = coarser ? place.brick_level : level;
    if (place.kind == Place::brick && (preview_ || !place.lacks())) walk_.touch_bricks(place);
    return work_.leaves.add(leaf, static_cast<double>(view_.frame.stride[leaf.step_level]), !coarser);
  }

  /// What becomes of moving ray i in its node. Does it go on to the next?
  bool goes_on(std::uint32_t i) {
    const auto r = static_cast<std::uint32_t>(work_.moving.ray[i]);
    TileRays& rays = work_.rays;
    const auto index = static_cast<std::uint32_t>(work_.steps.node[i]);
    const Leaf& leaf = work_.leaves[index];
    if (preview_ && leaf.place.kind != Place::transparent) {
      PreviewPixel& pixel = work_.pixel[r];
      ++pixel.wanted;
      pixel.resident += leaf.place.lacks() ? 0 : 1;
      pixel.worst_lack = leaf.lack > pixel.worst_lack ? leaf.lack : pixel.worst_lack;
    }
    if (leaf.place.kind == Place::brick) {
      rays.centre[r] = work_.steps.centre[i];
      rays.steps[r] = static_cast<std::int32_t>(work_.steps.steps[i]);
      work_.leaves.wait(index, r, work_.steps.centre[i]);
      return false;
    }
    if (leaf.place.kind == Place::constant) {
      RayState state;
      take(r, state);
      composite_constant({view_.frame, {}, {}}, walk_.ranges_of(leaf.place), leaf.level,
                         static_cast<std::int64_t>(work_.steps.steps[i]), state);
      put(r, state);
      if (state.phase == RayPhase::finished) return false;
    }
    if (rays.tick[r] >= rays.zone_end[r]) find_zone(r);
    return true;
  }

  void put(std::uint32_t ray, const RayState& state) {
    TileRays& rays = work_.rays;
    for (int c = 0; c < 3; ++c) rays.color[c][ray] = state.color[c];
    rays.opacity[ray] = state.opacity;
    rays.samples[ray] = static_cast<std::int32_t>(state.samples);
    finished_[ray] = state.phase == RayPhase::finished;
  }

  /// Composites all rays that wait before a leaf's brick; those that are not finished move.
  void composite(std::uint32_t index) {
    const Leaf& leaf = work_.leaves[index];
    const FrameView& frame = view_.frame;
    StretchBatch& batch = work_.batch;
    work_.leaves.release(index, work_.waited);
    order_by_steps();
    const Place& place = leaf.place;
    batch.units = frame.units_per_tick * static_cast<float>(frame.stride[leaf.step_level]);
    batch.level = leaf.step_level;
    batch.blended = place.blended;
    const BrickPlace fine = path_of(place, place.slot, place.brick_level, batch.fine);
    // Far coarser than wanted, deviations are of more than a step can tell apart: they would show fog.
    batch.fine.deviates = place.brick_level < frame.max_level && place.brick_level == leaf.level;
    batch.fine.gradient_scale = frame.gradient_scale[leaf.step_level];
    BrickPlace coarse;
    if (place.blended) {
      coarse = path_of(place, place.parent_slot, place.level - 1, batch.coarse);
      batch.coarse.deviates = true;
      batch.coarse.gradient_scale = frame.gradient_scale[leaf.step_level - 1];
    }
    fill_batch(frame, work_.rays, work_.chosen, leaf.step_level, fine, coarse, batch);
    const bool post = frame.classification == scene::Classification::post;
    const bool alone = !place.blended && (post || !batch.fine.deviates);
    batch.cells = alone ? cells_of(place.slot) : ~std::uint64_t(0);
    if (batch.cells != 0) {
      if (post) {
        composite_post_batch(frame, batch);
      } else {
        composite_batch(frame, batch);
      }
    }
    take_back(batch, work_.chosen, work_.rays);
    TileRays& rays = work_.rays;
    std::uint64_t go_on[TileRays::kMost / 64] = {};
    for (std::uint32_t i = 0; i < work_.chosen.size; ++i) {
      const auto ray = static_cast<std::uint32_t>(work_.chosen.ray[i]);
      if (rays.opacity[ray] >= kOpaque) {
        finished_[ray] = true;
        continue;
      }
      if (rays.tick[ray] >= rays.zone_end[ray]) find_zone(ray);
      go_on[ray / 64] |= std::uint64_t(1) << ray % 64;
    }
    // In the tile's order: rays that stand side by side are loaded side by side.
    for (std::uint32_t word = 0; word < TileRays::kMost / 64; ++word) {
      work_.moving.push_bits(64 * word, go_on[word]);
    }
  }

  std::uint64_t cells_of(BrickIndex slot) const {
    return view_.cells.of(slot, [&] {
      const scene::TransferView& function = view_.frame.visibility.functions[0];
      // A pre-integrated step may go from one cell to another, and through all that is between their values.
      const bool post = view_.frame.classification == scene::Classification::post;
      return visible_cells<M>(view_.bricks.brick(slot).voxels, [&](ValueRange values) {
        return post ? function.transparent(values) : function.below_visible(values);
      });
    });
  }

  BrickPlace path_of(const Place& place, BrickIndex slot, int level, StretchBatch::Path& path) const {
    path.brick = reinterpret_cast<const std::byte*>(view_.bricks.brick(slot).voxels);
    const BrickCorner<N> at(place, level);
    return {at.across, at.corner};
  }

  /// Rays of a vector go as far as the one that goes farthest: those that go as far are put together.
  void order_by_steps() {
    constexpr std::int32_t kLengths = 128;
    const RayList& waited = work_.waited;
    RayList& chosen = work_.chosen;
    const auto length_of = [&](std::int32_t ray) {
      const std::int32_t steps = work_.rays.steps[static_cast<std::size_t>(ray)];
      return static_cast<std::size_t>(steps < kLengths ? steps : kLengths - 1);
    };
    std::array<std::uint16_t, kLengths + 1> first{};
    for (std::uint32_t i = 0; i < waited.size; ++i) ++first[length_of(waited.ray[i]) + 1];
    for (std::size_t i = 1; i < first.size(); ++i)
      first[i] = static_cast<std::uint16_t>(first[i] + first[i - 1]);
    for (std::uint32_t i = 0; i < waited.size; ++i)
      chosen.ray[first[length_of(waited.ray[i])]++] = waited.ray[i];
    chosen.size = waited.size;
  }

  void step_back() {
    for (std::uint32_t nearest = work_.leaves.nearest(); nearest != LeafTable::kNone;
         nearest = work_.leaves.nearest()) {
      const auto stride = static_cast<double>(view_.frame.stride[work_.leaves[nearest].step_level]);
      work_.leaves.release(nearest, work_.chosen);
      for (std::uint32_t i = 0; i < work_.chosen.size; ++i) {
        const auto ray = static_cast<std::uint32_t>(work_.chosen.ray[i]);
        work_.rays.tick[ray] -= static_cast<double>(work_.rays.steps[ray]) * stride;
      }
    }
  }

  const PassView<Voxel, N, M>& view_;
  const TreeWalk<Voxel, N, M> walk_;
  const bool preview_;
  Workspace& work_;
  std::array<bool, TileRays::kMost> finished_;
};

/// Calls function(i, x, y) for each ray of a tile; i is its place among those of the tile.
template <typename Function>
void for_rays(exec::TileGrid grid, std::uint32_t tile, Function function) {
  const std::uint32_t x0 = tile % grid.tiles_x() * grid.tile, y0 = tile / grid.tiles_x() * grid.tile;
  for (std::uint32_t j = 0; j < grid.tile && y0 + j < grid.height; ++j) {
    for (std::uint32_t i = 0; i < grid.tile && x0 + i < grid.width; ++i) {
      function(j * exec::TileGrid::kTile + i, x0 + i, y0 + j);
    }
  }
}

template <typename Voxel, int N, int M>
bool march_tiles(const exec::Device& cpu, const PassView<Voxel, N, M>& view, const Pass& pass,
                 exec::TileGrid grid, exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                 exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  std::atomic<bool> all_begun{true};
  exec::parallel_for(cpu, tiles.size, [&](std::size_t t) {
    if (exec::late(deadline)) {
      all_begun.store(false, std::memory_order_relaxed);
      return;
    }
    const std::uint32_t x0 = tiles[t] % grid.tiles_x() * grid.tile;
    const std::uint32_t y0 = tiles[t] / grid.tiles_x() * grid.tile;
    // A tile that is finished must cost next to nothing, or short frames end in it.
    std::optional<TileMarcher<Voxel, N, M>> marcher;
    RayList marching;
    const auto state_of = [&](std::uint32_t x, std::uint32_t y) -> RayState& {
      return rays[std::size_t(y) * grid.width + x];
    };
    bool all_finished = true;
    for_rays(grid, tiles[t], [&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      RayState& ray = state_of(x, y);
      if (ray.epoch != pass.epoch) {
        ray = RayState{};
        ray.epoch = pass.epoch;
      }
      if (ray.phase == RayPhase::finished) return;
      if (pass.lone_ray != Pass::kAllRays && pass.lone_ray != std::uint64_t(y) * grid.width + x) {
        all_finished = false;
        return;
      }
      if (!marcher) marcher.emplace(view, double(x0), double(y0), 1.0, grid.tile, false);
      marcher->add(i, ray);
      marching.push(i);
    });
    if (marcher) marcher->march(deadline);
    for (std::uint32_t k = 0; k < marching.size; ++k) {
      const auto i = static_cast<std::uint32_t>(marching.ray[k]);
      RayState& ray = state_of(x0 + i % exec::TileGrid::kTile, y0 + i / exec::TileGrid::kTile);
      marcher->take(i, ray);
      all_finished = all_finished && ray.phase == RayPhase::finished;
    }
    if (!all_finished) exec::store_relaxed(&unfinished[tiles[t]], 1);
  });
  return all_begun.load();
}

template <typename Voxel, int N, int M>
bool preview_tiles(const exec::Device& cpu, const PassView<Voxel, N, M>& view, const Pass& pass,
                   exec::TileGrid grid, exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                   std::uint32_t block, std::uint32_t generation, exec::BufferView<const RayState> rays,
                   exec::BufferView<PreviewPixel> pixels) {
  std::atomic<bool> all_done{true};
  exec::parallel_for(cpu, tiles.size, [&](std::size_t t) {
    if (exec::late(deadline)) {
      all_done.store(false, std::memory_order_relaxed);
      return;
    }
    const std::uint32_t x0 = tiles[t] % grid.tiles_x() * grid.tile * block;
    const std::uint32_t y0 = tiles[t] / grid.tiles_x() * grid.tile * block;
    std::optional<TileMarcher<Voxel, N, M>> marcher;
    RayList marching;
    const auto pixel_of = [&](std::uint32_t x, std::uint32_t y) {
      return std::size_t(y) * block * view.frame.width + std::size_t(x) * block;
    };
    for_rays(grid, tiles[t], [&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      const std::size_t pixel = pixel_of(x, y);
      if (rays[pixel].epoch == pass.epoch && rays[pixel].phase == RayPhase::finished) return;
      if (pixels[pixel].epoch == pass.epoch && pixels[pixel].generation == generation) return;
      if (!marcher) marcher.emplace(view, double(x0), double(y0), double(block), grid.tile, true);
      marcher->add(i, RayState{});
      marching.push(i);
    });
    // A preview's ray cannot stop half way.
    if (marcher) marcher->march(exec::no_deadline());
    for (std::uint32_t k = 0; k < marching.size; ++k) {
      const auto i = static_cast<std::uint32_t>(marching.ray[k]);
      PreviewPixel& pixel =
          pixels[pixel_of(x0 / block + i % exec::TileGrid::kTile, y0 / block + i / exec::TileGrid::kTile)];
      pixel = marcher->pixel(i);
      pixel.epoch = pass.epoch;
      pixel.generation = generation;
    }
  });
  return all_done.load();
}

}  // namespace

bool marches_tiles(const Pass& pass) {
  // Ticks and cells are counted in doubles.
  constexpr double kMostTicks = 1e15;
  const FrameView& frame = pass.frame;
  const Affine3 to_world = inverse(frame.world_to_tree);
  double diagonal = 0;
  for (const Vec3d& column : to_world.column) diagonal += length(column);
  const double ticks = diagonal / frame.tick_world;
  const auto across = static_cast<double>(frame.stride[0]);
  return !pass.one_ray_at_a_time && composites_batches(frame) && ticks < kMostTicks && across <= kMostAcross;
}

bool tile_march(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  GVX_CHECK(grid.tile == exec::TileGrid::kTile);
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return with_view<decltype(zero)>(pass, [&](const auto& view) {
      return march_tiles(cpu, view, pass, grid, tiles, deadline, rays, unfinished);
    });
  });
}

bool tile_preview(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                  exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                  std::uint32_t generation, exec::BufferView<const RayState> rays,
                  exec::BufferView<PreviewPixel> pixels) {
  GVX_CHECK(grid.tile <= exec::TileGrid::kTile);
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return with_view<decltype(zero)>(pass, [&](const auto& view) {
      return preview_tiles(cpu, view, pass, grid, tiles, deadline, block, generation, rays, pixels);
    });
  });
}

}  // namespace gvx::render
