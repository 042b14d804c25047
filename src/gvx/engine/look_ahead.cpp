#include "gvx/engine/look_ahead.h"

#include <algorithm>
#include <new>
#include <numeric>

namespace gvx::engine {

void LookAhead::view_changed(const std::optional<render::View>& before, const render::View& now) {
  stop();
  if (!before || before->camera == now.camera) return;
  render::View moved = *before;
  moved.camera = now.camera;
  if (moved == now) camera_before_ = before->camera;
}

std::optional<render::View> LookAhead::next(const render::View& now) const {
  constexpr double kFramesAhead = 4;
  if (!camera_before_ || !(now.camera.origin == camera_before_->origin)) return std::nullopt;
  const scene::Camera& before = *camera_before_;
  render::View view = now;
  view.camera.eye = view.camera.eye + kFramesAhead * (view.camera.eye - before.eye);
  view.camera.target = view.camera.target + kFramesAhead * (view.camera.target - before.target);
  view.camera.up = view.camera.up + kFramesAhead * (view.camera.up - before.up);
  // Fewer rays, but as fine in what they want.
  const auto sparse = static_cast<std::uint32_t>(std::max(1.0, render::View::kMostDetail / view.detail));
  view.width = (view.width * view.antialias + sparse - 1) / sparse;
  view.height = (view.height * view.antialias + sparse - 1) / sparse;
  view.antialias = 1;
  view.detail *= sparse;
  return view;
}

std::optional<LookAhead::Picture> LookAhead::picture(const exec::Device& device, const render::View& ahead,
                                                     std::size_t most_tiles) {
  constexpr std::uint32_t kTile = 8;
  const exec::TileGrid grid{ahead.width, ahead.height, kTile};
  // Coarse pictures of high detail are not worth more memory.
  if (grid.tiles() > most_tiles) return std::nullopt;
  if (!film_ || film_->grid().width != ahead.width || film_->grid().height != ahead.height) {
    try {
      film_.emplace(device, ahead.width, ahead.height);
      tiles_ = exec::Buffer<std::uint32_t>(device, grid.tiles());
    } catch (const std::bad_alloc&) {
      film_.reset();
      stop();
      return std::nullopt;
    }
    std::iota(tiles_.view().begin(), tiles_.view().end(), 0u);
  }
  film_->clear();
  return Picture{&*film_, grid, tiles_.view()};
}

}  // namespace gvx::engine
