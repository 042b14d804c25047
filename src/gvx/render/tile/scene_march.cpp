#include "gvx/render/tile/scene_march.h"

#include <optional>
#include <vector>

#include "gvx/exec/parallel.h"
#include "gvx/exec/relaxed.h"
#include "gvx/render/tile/scene_tile.h"
#include "gvx/render/tile/tile_part.h"

namespace gvx::render {
namespace {

/// Those of the pass, or else found anew.
class TilesOfPass {
 public:
  explicit TilesOfPass(const Pass& pass) {
    if (pass.object_tiles == nullptr) own_.emplace(pass.film, pass.objects);
    tiles_ = own_ ? &*own_ : pass.object_tiles;
  }
  const ObjectTiles& operator*() const { return *tiles_; }

 private:
  std::optional<ObjectTiles> own_;
  const ObjectTiles* tiles_;
};

FilmRect film_rect_of(const exec::TileGrid& grid, std::uint32_t tile) {
  const TilePart part(grid, tile);
  const auto last = [](std::uint32_t first, std::uint32_t count) {
    return static_cast<std::int32_t>(first + count) - 1;
  };
  return {static_cast<std::int32_t>(part.x0), last(part.x0, part.width), static_cast<std::int32_t>(part.y0),
          last(part.y0, part.height)};
}

/// A tile's exact rays: taken from a film, and put back.
class ExactTile {
 public:
  ExactTile(const ExactMarch& march, std::uint32_t tile)
      : march_(march), part_(march.grid, tile), states_(TileRays::kMost) {
    part_.for_rays([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      const RayState& ray = march_.rays[index(x, y)];
      const bool begun = ray.epoch == march_.pass.epoch;
      if (begun) states_[i] = ray;
      states_[i].epoch = march_.pass.epoch;
      is_new_ = is_new_ && !begun;
      if (states_[i].phase == RayPhase::finished) return;
      all_finished_ = false;
      const std::uint64_t lone = march_.pass.lone_ray;
      if (lone == Pass::kAllRays || lone == index(x, y)) marching_.set(i);
    });
  }

  bool all_finished() const { return all_finished_; }
  const ActiveRays& marching() const { return marching_; }
  void march(const ObjectTiles& objects) {
    const RaysOfTile rays{double(part_.x0), double(part_.y0), 1, part_.width, part_.height};
    SceneTile(march_.pass, objects, rays, marching_).march(states_.data(), nullptr, march_.deadline);
  }
  /// None of its rays sees anything: their states need not be written.
  bool is_blank() const {
    bool blank = is_new_;
    part_.for_rays([&](std::uint32_t i, std::uint32_t, std::uint32_t) {
      blank = blank && states_[i].phase == RayPhase::finished && !(states_[i].opacity > 0.0f);
    });
    return blank;
  }
  /// Returns whether all rays are finished.
  bool put_back() const {
    bool finished = true;
    part_.for_rays([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      march_.rays[index(x, y)] = states_[i];
      finished = finished && states_[i].phase == RayPhase::finished;
    });
    return finished;
  }

 private:
  std::size_t index(std::uint32_t x, std::uint32_t y) const { return std::size_t(y) * march_.grid.width + x; }

  const ExactMarch& march_;
  const TilePart part_;
  std::vector<RayState> states_;
  ActiveRays marching_;
  bool is_new_ = true, all_finished_ = true;
};

}  // namespace

bool scene_march(const exec::Device& cpu, const ExactMarch& march) {
  const Pass& pass = march.pass;
  GVX_CHECK(march.grid.tile == exec::TileGrid::kTile && pass.blank_tiles.size == march.grid.tiles());
  const TilesOfPass objects(pass);
  Turns turns(march.deadline);
  exec::parallel_for(cpu, march.tiles.size, [&](std::size_t t) {
    const std::uint32_t tile = march.tiles[t];
    if (!turns.all_taken() || pass.blank_tiles[tile] == pass.epoch) return;
    if ((*objects).objects_in(film_rect_of(march.grid, tile)).empty()) {
      pass.blank_tiles[tile] = pass.epoch;
      exec::store_relaxed(&march.unfinished[tile], 0);
      return;
    }
    ExactTile rays(march, tile);
    if (rays.all_finished()) return;
    exec::store_relaxed(&march.unfinished[tile], 1);
    if (rays.marching().count() == 0 || !turns.take()) return;
    rays.march(*objects);
    const bool blank = rays.is_blank();
    if (blank) pass.blank_tiles[tile] = pass.epoch;
    if (blank || rays.put_back()) exec::store_relaxed(&march.unfinished[tile], 0);
  });
  return turns.all_taken();
}

bool scene_preview(const exec::Device& cpu, const PreviewMarch& march) {
  const Pass& pass = march.pass;
  const TilesOfPass objects(pass);
  const PreviewPixels drawn(march);
  Turns turns(march.deadline);
  exec::parallel_for(cpu, march.tiles.size, [&](std::size_t t) {
    if (!turns.all_taken()) return;
    const TilePart part(march.grid, march.tiles[t]);
    ActiveRays missing;
    part.for_rays([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      if (!drawn.is_drawn(x, y)) missing.set(i);
    });
    if (missing.count() == 0 || !turns.take()) return;
    std::vector<RayState> states(TileRays::kMost);
    std::vector<PreviewPixel> pixels(TileRays::kMost);
    const double block = march.block;
    const RaysOfTile rays{part.x0 * block, part.y0 * block, block, part.width,
                          part.height,     march.grid.tile, true};
    // A preview's ray cannot stop half way.
    SceneTile(pass, *objects, rays, missing).march(states.data(), pixels.data(), exec::no_deadline());
    missing.for_each([&](std::uint32_t i) {
      const std::uint32_t x = part.x0 + i % TileRays::kEdge, y = part.y0 + i / TileRays::kEdge;
      PreviewPixel pixel = pixels[i];
      pixel.color = states[i].color;
      pixel.opacity = states[i].opacity;
      drawn.put(x, y, pixel);
    });
  });
  return turns.all_taken();
}

}  // namespace gvx::render
