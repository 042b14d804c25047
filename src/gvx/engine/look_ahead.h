/// \file
/// LookAhead: where a moving camera will be, so that what it will lack is made while nothing else is to do.
#pragma once

#include <optional>

#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/frame/view.h"

namespace gvx::engine {

class LookAhead {
 public:
  /// The view changed, from `before` where there was one. It is a move if only the camera did.
  void view_changed(const std::optional<render::View>& before, const render::View& now);
  /// There is nothing to look ahead for until the view changes again.
  void stop() { camera_before_.reset(); }

  /// Does the camera move?
  bool moving() const { return camera_before_.has_value(); }
  /// What it will see some frames from now, with fewer rays; none where that is not known.
  std::optional<render::View> next(const render::View& view) const;

  /// A picture of it in single pixels.
  struct Picture {
    render::Film* film;
    exec::TileGrid grid;
    exec::BufferView<const std::uint32_t> tiles;  ///< all of the grid
  };
  /// With a cleared film; none where memory, or so many tiles, do not suffice.
  std::optional<Picture> picture(const exec::Device& device, const render::View& ahead,
                                 std::size_t most_tiles);

 private:
  std::optional<scene::Camera> camera_before_;
  std::optional<render::Film> film_;
  exec::Buffer<std::uint32_t> tiles_;
};

}  // namespace gvx::engine
