#include "gvx/engine/preview_rays.h"

#include <algorithm>
#include <numeric>

namespace gvx::engine {
namespace {

using Clock = std::chrono::steady_clock;

// Tiles that are drawn between two looks at what producers have finished.
constexpr std::uint32_t kTilesAtOnce = 128;
// Once this share of what coarse blocks want is there, what comes later is for finer ones and exact rays.
constexpr double kSettledShare = 0.95;

}  // namespace

PreviewRays::PreviewRays(const exec::Device& device, exec::TileGrid grid)
    : device_(device), list_(device, std::max(grid.tiles(), kTilesAtOnce)) {}

void PreviewRays::begin(std::uint32_t first_block) {
  ++generation_;
  first_block_ = block_ = first_block;
  tile_ = 0;
}

void PreviewRays::begin_view(std::uint32_t first_block) {
  shows_something_ = false;
  begin(first_block);
}

void PreviewRays::begin_refresh() {
  begin(1);
  first_block_ = 0;
}

bool PreviewRays::draw(render::Film& film, const render::Pass& pass, exec::Deadline deadline) {
  const exec::TileGrid rays = film.grid();
  const exec::TileGrid grid{(rays.width + block_ - 1) / block_, (rays.height + block_ - 1) / block_, 8};
  const std::uint32_t count = std::min(kTilesAtOnce, grid.tiles() - tile_);
  std::iota(list_.view().begin(), list_.view().begin() + count, tile_);
  const render::TilesMarch tiles{pass, grid, {list_.view().data, count}, deadline};
  if (!render::march_preview(device_, {tiles, block_, generation_, film.rays(), film.preview()})) {
    return false;  // what was drawn of them is not drawn again
  }
  tile_ += count;
  if (tile_ == grid.tiles()) {
    block_ /= 2;
    tile_ = 0;
  }
  return true;
}

bool PreviewRays::draw_stage(render::Film& film, const render::Pass& pass, exec::Deadline deadline) {
  const std::uint32_t block = block_;
  const bool in_any_case = in_first_stage() && !shows_something_, first = in_first_stage();
  const auto begun = Clock::now();
  while (block_ == block) {
    if (!draw(film, pass, in_any_case ? exec::no_deadline() : deadline)) return false;
  }
  if (first) {
    first_stage_took_ = Clock::now() - begun;
    shows_something_ = true;
  }
  return true;
}

void PreviewRays::draw_until(render::Film& film, const render::Pass& pass, exec::Deadline deadline) {
  while (!complete() && draw(film, pass, deadline) && Clock::now() < deadline) {
  }
}

bool PreviewRays::lacks_much(const render::Film& film) const {
  return film.resident_share(std::max(kCoarseBlock, first_block_)) < kSettledShare;
}

}  // namespace gvx::engine
