#include "gvx/engine/exact_rays.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace gvx::engine {
namespace {

using Clock = std::chrono::steady_clock;

// Marches in which no ray of the first tile came further, beside those that it takes to descend to a brick,
// one a level: before one ray runs alone, and before it is taken for hopeless.
constexpr int kPatience = 4;
constexpr int kMostStuck = 300;

/// The rays of a tile that are in the picture: function(x, y).
template <typename Function>
void for_rays_of(exec::TileGrid grid, std::uint32_t tile, std::uint32_t step, Function function) {
  const std::uint32_t x0 = tile % grid.tiles_x() * grid.tile, y0 = tile / grid.tiles_x() * grid.tile;
  for (std::uint32_t y = y0; y < std::min(y0 + grid.tile, grid.height); y += step) {
    for (std::uint32_t x = x0; x < std::min(x0 + grid.tile, grid.width); x += step) function(x, y);
  }
}

}  // namespace

void ExactRays::begin(const render::Film& film) {
  unfinished_.resize(film.grid().tiles());
  std::iota(unfinished_.begin(), unfinished_.end(), 0u);
  window_ = unfinished_.size();
  cursor_ = 0;
  forgive();
}

void ExactRays::forgive() {
  stuck_ = 0;
  lone_ray_ = render::Pass::kAllRays;
}

void ExactRays::march(render::Film& film, render::Pass pass, const Parts& parts) {
  pass.lone_ray = lone_ray_;
  const bool timed = parts.deadline != exec::no_deadline(), in_parts = parts.interval.count() > 0;
  const std::size_t least_part = 4 * static_cast<std::size_t>(device_.threads()) + 4;
  std::size_t part = timed ? least_part : unfinished_.size();
  if (in_parts) part = std::max(least_part, part / 16);
  std::size_t end = std::min(window_, unfinished_.size());
  if (cursor_ >= end || (!timed && !parts.goes_on)) cursor_ = 0;
  while (cursor_ < end) {
    const std::size_t count = std::min(part, end - cursor_);
    const Clock::time_point begin = Clock::now();
    const auto first = unfinished_.begin() + static_cast<std::ptrdiff_t>(cursor_);
    const auto last = first + static_cast<std::ptrdiff_t>(count);
    std::copy(first, last, list_.view().begin());
    for (auto tile = first; tile != last; ++tile) flags_.view()[*tile] = 0;
    const render::TilesMarch tiles{pass, film.grid(), {list_.view().data, count}, parts.deadline};
    if (!render::march_exact(device_, {tiles, film.rays(), flags_.view()})) {
      return;  // some flags were not set; finished rays cost little the next time
    }
    const auto kept =
        std::remove_if(first, last, [&](std::uint32_t tile) { return flags_.view()[tile] == 0; });
    const auto struck = static_cast<std::size_t>(last - kept);
    unfinished_.erase(kept, last);
    cursor_ += count - struck;
    end -= struck;
    if (!in_parts) continue;
    if (parts.goes_on && !parts.goes_on()) return;
    const double intervals = (Clock::now() - begin) / std::chrono::duration<double>(parts.interval);
    part = std::max(least_part,
                    static_cast<std::size_t>(static_cast<double>(count) / std::max(intervals, 1e-3)));
  }
  cursor_ = 0;
}

void ExactRays::adapt(bool crowded, std::uint32_t all_tiles) {
  window_ = crowded ? std::max<std::size_t>(1, window_ / 2)
                    : std::min<std::size_t>(window_ + window_ / 4 + 1, all_tiles);
}

bool ExactRays::came_on(render::Film& film, int levels) {
  // Changes with every ray's tick; a sum of ticks would round away the steps of the near ones.
  std::uint64_t place = unfinished_.size();
  std::uint64_t first_unfinished = render::Pass::kAllRays;
  if (!unfinished_.empty()) {
    const exec::TileGrid grid = film.grid();
    for_rays_of(grid, unfinished_[0], 1, [&](std::uint32_t x, std::uint32_t y) {
      const std::size_t index = std::size_t(y) * grid.width + x;
      const render::RayState& ray = film.rays()[index];
      place += std::bit_cast<std::uint64_t>(ray.tick) + static_cast<std::uint64_t>(ray.phase);
      if (ray.phase != render::RayPhase::finished && first_unfinished == render::Pass::kAllRays) {
        first_unfinished = index;
      }
    });
  }
  const bool moved = place != place_;
  stuck_ = moved ? 0 : stuck_ + 1;
  place_ = place;
  const bool lone_came_on = lone_ray_ != render::Pass::kAllRays && lone_ray_ == first_unfinished;
  const bool alone = stuck_ >= levels + kPatience || lone_came_on;
  lone_ray_ = alone ? first_unfinished : render::Pass::kAllRays;
  return moved;
}

bool ExactRays::hopeless(int levels) const {
  return stuck_ > levels + kMostStuck;
}

std::uint64_t ExactRays::finished_rays(render::Film& film) const {
  constexpr std::uint32_t kStep = 8;
  constexpr std::size_t kMostTiles = 1024;
  const exec::TileGrid grid = film.grid();
  std::uint64_t looked_at = 0, unfinished = 0;
  const std::size_t stride = unfinished_.size() / kMostTiles + 1;
  for (std::size_t i = 0; i < unfinished_.size(); i += stride) {
    for_rays_of(grid, unfinished_[i], kStep, [&](std::uint32_t x, std::uint32_t y) {
      const render::RayState& ray = film.rays()[std::size_t(y) * grid.width + x];
      ++looked_at;
      unfinished += ray.epoch == film.epoch() && ray.phase == render::RayPhase::finished ? 0 : 1;
    });
  }
  const double of_tiles = static_cast<double>(unfinished_.size()) / grid.tiles();
  const double share =
      looked_at == 0 ? 0 : of_tiles * static_cast<double>(unfinished) / static_cast<double>(looked_at);
  return static_cast<std::uint64_t>((1 - share) * static_cast<double>(grid.width) * grid.height);
}

}  // namespace gvx::engine
