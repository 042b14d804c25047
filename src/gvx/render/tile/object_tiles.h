/// \file
/// ObjectTiles: which objects of a scene lie before which tiles of a film. Found once for a frame: one
/// projection for each object.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/march_pass.h"

namespace gvx::render {

/// Rays (x, y) of a film with x0 <= x <= x1 and y0 <= y <= y1.
struct FilmRect {
  std::int32_t x0 = 0, x1 = -1, y0 = 0, y1 = -1;

  bool empty() const { return x0 > x1 || y0 > y1; }
  bool meets(const FilmRect& other) const {
    return x0 <= other.x1 && other.x0 <= x1 && y0 <= other.y1 && other.y0 <= y1;
  }
};

/// The rays that may meet the visible volume of an object.
FilmRect film_rect_of(const FilmView& film, const FrameView& object);

class ObjectTiles {
 public:
  ObjectTiles(const FilmView& film, std::span<const ObjectView> objects);

  const FilmRect& rect_of(std::uint32_t object) const { return rects_[object]; }
  /// The objects, by their indices, that rays of a rectangle may meet; ascending.
  std::vector<std::uint32_t> objects_in(const FilmRect& rect) const;

 private:
  /// Calls function(tile) for each tile of the film that the rectangle meets.
  template <typename Function>
  void for_tiles(const FilmRect& rect, Function function) const;

  exec::TileGrid grid_;
  std::vector<FilmRect> rects_;
  std::vector<std::uint32_t> first_;  // of each tile, in objects_; and their number
  std::vector<std::uint32_t> objects_;
};

}  // namespace gvx::render
