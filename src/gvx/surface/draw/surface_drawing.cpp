#include "gvx/surface/draw/surface_drawing.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "gvx/exec/parallel.h"
#include "gvx/surface/draw/technique_vectors.h"
#include "gvx/surface/surface_pieces.h"

namespace gvx::surface {
namespace {

SurfaceCamera camera_of(const SurfaceView& view) {
  // Triangles alone are those of the finest bricks.
  const double widest = view.only == Technique::rasterise ? 0 : view.widest_cell;
  return {FilmPlane(view.camera, view.width, view.height), world_to_camera(view.camera), widest, view.only};
}

/// What tells where a brick is seen.
Piece drawn_piece(Technique technique) {
  return technique == Technique::rasterise ? Piece::triangles : Piece::geometry;
}

/// Elements that are asked for at a time: what comes hides what is behind it, which need not come then.
constexpr std::size_t kMostLacking = 4096;

}  // namespace

struct SurfaceDrawing::Drawn {
  std::uint32_t number = 0;  // in the cut
  PlacedBrick placed;
  const std::byte* bytes = nullptr;  // of its drawn_piece()
};

SurfaceDrawing::SurfaceDrawing(const exec::Device& cpu, const SurfaceView& view,
                               std::span<const SurfaceInstance> instances)
    : cpu_(cpu), cut_(camera_of(view), instances) {
  see(view, instances);
}

void SurfaceDrawing::see(const SurfaceView& view, std::span<const SurfaceInstance> instances) {
  view_ = view;
  grid_ = {view.width, view.height, TileHits::kEdge};
  instances_.assign(instances.begin(), instances.end());
  cut_ = SurfaceCut(camera_of(view), instances);
  lights_.clear();
  normals_.clear();
  for (const SurfaceInstance& instance : instances_) {
    lights_.emplace_back(view.lighting, view.camera, instance.cells_to_world);
    normals_.emplace_back(cut_.camera().world_to_camera * instance.cells_to_world);
  }
  clear();
}

void SurfaceDrawing::clear() {
  pixels_.resize(std::size_t{view_.width} * view_.height);
  tiles_.assign(grid_.tiles(), kBlank);
  blocks_x_ = (view_.width + kBlock - 1) / kBlock;
  const std::uint32_t blocks_y = (view_.height + kBlock - 1) / kBlock;
  farthest_.assign(std::size_t{blocks_x_} * blocks_y, std::numeric_limits<float>::infinity());
  counts_ = {};
  complete_ = false;
}

PixelRect SurfaceDrawing::rect_of(std::uint32_t tile) const {
  constexpr std::int32_t kEdge = TileHits::kEdge;
  const auto x0 = static_cast<std::int32_t>(tile % grid_.tiles_x()) * kEdge,
             y0 = static_cast<std::int32_t>(tile / grid_.tiles_x()) * kEdge;
  const auto width = static_cast<std::int32_t>(view_.width), height = static_cast<std::int32_t>(view_.height);
  return PixelRect{x0, y0, x0 + kEdge, y0 + kEdge} & PixelRect{0, 0, width, height};
}

bool SurfaceDrawing::hidden(const PixelRect& rect, double nearest) const {
  const auto at = static_cast<float>(nearest);
  const auto block = [](std::int32_t pixel) { return static_cast<std::uint32_t>(pixel) / kBlock; };
  for (std::uint32_t y = block(rect.y0); y <= block(rect.y1 - 1); ++y) {
    for (std::uint32_t x = block(rect.x0); x <= block(rect.x1 - 1); ++x) {
      if (!(farthest_[std::size_t{y} * blocks_x_ + x] < at)) return false;
    }
  }
  return true;
}

/// Of the blocks of a tile.
void SurfaceDrawing::find_farthest(const PixelRect& tile) {
  constexpr auto kEdge = static_cast<std::int32_t>(kBlock);
  for (std::int32_t y0 = tile.y0; y0 < tile.y1; y0 += kEdge) {
    for (std::int32_t x0 = tile.x0; x0 < tile.x1; x0 += kEdge) {
      float most = 0;
      const PixelRect block = PixelRect{x0, y0, x0 + kEdge, y0 + kEdge} & tile;
      for_rows(block, [&](const SurfacePixel* row, std::int32_t) {
        for (std::int32_t x = block.x0; x < block.x1; ++x) most = std::max(most, row[x].depth);
      });
      const auto of_block = [](std::int32_t pixel) { return static_cast<std::size_t>(pixel) / kBlock; };
      farthest_[of_block(y0) * blocks_x_ + of_block(x0)] = most;
    }
  }
}

std::vector<LackingElement> SurfaceDrawing::advance() {
  std::vector<LackingElement> lacking;
  if (complete_) return lacking;
  cut_.descend([&](const PixelRect& rect, double nearest) { return hidden(rect, nearest); }, lacking);
  std::vector<Drawn> ready;
  std::vector<CutBrick>& bricks = cut_.bricks();
  bool all_drawn = cut_.complete();
  for (std::uint32_t i = 0; i < bricks.size(); ++i) {
    CutBrick& brick = bricks[i];
    if (brick.drawn) continue;
    if (hidden(brick.seen.rect, brick.seen.nearest)) {
      brick.drawn = true;
      ++counts_.hidden;
      continue;
    }
    Drawn drawn{i, cut_.camera().place(instances_[brick.instance], brick.level, brick.key)};
    ResidentSurface& surface = *instances_[brick.instance].surface;
    // What colours what is seen comes later, but where it is a part of the same.
    const Piece piece = drawn_piece(brick.technique);
    drawn.bytes = surface.piece(brick.level, brick.place, piece);
    if (drawn.bytes == nullptr) {
      all_drawn = false;
      lacking.push_back({brick.instance, brick.level, brick.place, false, piece,
                         piece_bytes(brick.node, piece), brick.seen.nearest});
      continue;
    }
    brick.drawn = true;
    ready.push_back(drawn);
  }
  draw(ready);
  // What is hidden in the end needs no colours: they are asked for when all is drawn.
  std::vector<LackingElement> colorless = shade();
  if (all_drawn) {
    lacking = std::move(colorless);
    complete_ = lacking.empty();
  }
  std::stable_sort(lacking.begin(), lacking.end(), [](const LackingElement& a, const LackingElement& b) {
    return a.page != b.page ? a.page : a.nearest < b.nearest;
  });
  if (lacking.size() > kMostLacking) lacking.resize(kMostLacking);
  return lacking;
}

std::vector<LackingElement> SurfaceDrawing::draw_resident() {
  std::vector<LackingElement> lacking;
  clear();
  cut_ = SurfaceCut(camera_of(view_), instances_);
  cut_.descend_resident(lacking);
  std::vector<Drawn> ready;
  for (std::uint32_t i = 0; i < cut_.bricks().size(); ++i) {
    CutBrick& brick = cut_.bricks()[i];
    Drawn drawn{i, cut_.camera().place(instances_[brick.instance], brick.level, brick.key)};
    drawn.bytes =
        instances_[brick.instance].surface->piece(brick.level, brick.place, drawn_piece(brick.technique));
    brick.drawn = true;
    ready.push_back(drawn);
  }
  draw(ready);
  (void)shade();
  complete_ = lacking.empty();
  return lacking;
}

/// Draws bricks, of which all pieces are there that this takes.
void SurfaceDrawing::draw(std::vector<Drawn>& bricks) {
  if (bricks.empty()) return;
  const std::vector<CutBrick>& cut = cut_.bricks();
  orders_.resize(cut.size());
  for (std::size_t i = 0; i < cut.size(); ++i) orders_[i] = cut[i].order();
  // Triangles first, as rays need not go beyond them; the nearest first.
  std::vector<std::uint32_t> order(bricks.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const CutBrick &left = cut[bricks[a].number], &right = cut[bricks[b].number];
    const bool left_first = left.technique == Technique::rasterise,
               right_first = right.technique == Technique::rasterise;
    return left_first != right_first ? left_first : left.seen.nearest < right.seen.nearest;
  });
  std::vector<std::vector<std::uint32_t>> of_tiles(grid_.tiles());
  for (const std::uint32_t i : order) {
    const CutBrick& brick = cut[bricks[i].number];
    ++counts_.bricks[static_cast<int>(brick.technique)];
    const bool triangles = brick.technique == Technique::rasterise;
    (triangles ? counts_.triangles : counts_.samples) +=
        triangles ? brick.node.triangles : brick.node.samples;
    counts_.bytes += piece_bytes(brick.node, drawn_piece(brick.technique));
    const PixelRect& rect = brick.seen.rect;
    constexpr std::int32_t kEdge = TileHits::kEdge;
    for (std::int32_t y = rect.y0 / kEdge; y <= (rect.y1 - 1) / kEdge; ++y) {
      for (std::int32_t x = rect.x0 / kEdge; x <= (rect.x1 - 1) / kEdge; ++x) {
        of_tiles[static_cast<std::size_t>(y) * grid_.tiles_x() + static_cast<std::size_t>(x)].push_back(i);
      }
    }
  }
  // What colours are there is shaded at once.
  std::vector<SeenBrick> seen(cut.size());
  std::vector<LackingElement> ignored;
  for (const Drawn& drawn : bricks) {
    seen[drawn.number] = look_up(cut[drawn.number], ignored);
    count_colors(cut[drawn.number], seen[drawn.number]);
  }
  const RowShading rows = row_shading(seen);
  exec::parallel_for(cpu_, of_tiles.size(), [&](std::size_t tile) {
    if (of_tiles[tile].empty()) return;
    const PixelRect rect = rect_of(static_cast<std::uint32_t>(tile));
    draw_tile(rect, tiles_[tile] == kBlank, of_tiles[tile], bricks);
    find_farthest(rect);
    tiles_[tile] = shade_tile(rows, rect) ? kUnshaded : kShaded;
  });
}

void SurfaceDrawing::draw_tile(const PixelRect& rect, bool blank, std::span<const std::uint32_t> of_tile,
                               const std::vector<Drawn>& bricks) {
  static thread_local TileHits hits;
  hits.clear(rect, orders_.data());
  const auto for_pixels = [&](auto function) {
    for_rows(rect, [&](SurfacePixel* row, std::int32_t y) {
      for (std::int32_t x = rect.x0; x < rect.x1; ++x) function(row[x], hits.index(x, y));
    });
  };
  if (!blank) {
    for_pixels([&](const SurfacePixel& pixel, std::size_t at) {
      hits.depth[at] = pixel.depth;
      hits.brick[at] = pixel.brick;
      hits.item[at] = pixel.item;
    });
  }
  const FilmPlane& film = cut_.camera().film;
  for (const std::uint32_t i : of_tile) {
    const Drawn& drawn = bricks[i];
    const CutBrick& brick = cut_.bricks()[drawn.number];
    const PixelRect part = brick.seen.rect & rect;
    if (hits.hides(part, brick.seen.nearest)) continue;
    if (brick.technique == Technique::rasterise) {
      const TriangleListView triangles = triangle_view(brick.node, drawn.bytes);
      const DrawnTriangles what{film, drawn.placed, triangles, drawn.number, part, brick.seen.nearest};
      if (view_.plain) {
        rasterise(what, hits);
      } else {
        rasterise_in_vectors(what, hits);
      }
      continue;
    }
    const SurfaceBrickView samples = brick_view(brick.node, drawn.bytes, nullptr);
    const DrawnSamples what{film,
                            drawn.placed,
                            samples,
                            drawn.number,
                            part,
                            brick.seen.nearest,
                            {Vec3d(brick.node.low[0], brick.node.low[1], brick.node.low[2]),
                             Vec3d(brick.node.high[0] + 1, brick.node.high[1] + 1, brick.node.high[2] + 1)}};
    if (brick.technique == Technique::splat) {
      splat_samples(what, hits);
    } else if (view_.plain) {
      cast_samples(what, hits);
    } else {
      cast_samples_in_vectors(what, hits);
    }
  }
  for_pixels([&](SurfacePixel& pixel, std::size_t at) {
    if (!blank && pixel.brick == hits.brick[at] && pixel.item == hits.item[at]) return;
    pixel = {hits.depth[at], hits.brick[at], hits.item[at], INFINITY, {}, -1};
  });
}

/// A brick that is seen, with the pieces that this takes; what is not there is appended to `lacking`.
SeenBrick SurfaceDrawing::look_up(const CutBrick& brick, std::vector<LackingElement>& lacking) const {
  SeenBrick seen;
  seen.there = true;
  seen.technique = brick.technique;
  seen.by_triangles = brick.technique == Technique::rasterise;
  seen.instance = brick.instance;
  seen.object = instances_[brick.instance].object;
  const std::byte* pieces[kPieces] = {};
  for (int p = 0; p < kPieces; ++p) {
    const auto piece = static_cast<Piece>(p);
    if (!needs(brick.technique, piece)) continue;
    pieces[p] = instances_[brick.instance].surface->piece(brick.level, brick.place, piece);
    if (pieces[p] != nullptr) continue;
    seen.there = false;
    lacking.push_back({brick.instance, brick.level, brick.place, false, piece, piece_bytes(brick.node, piece),
                       brick.seen.nearest});
  }
  if (!seen.there) return seen;
  seen.placed = cut_.camera().place(instances_[brick.instance], brick.level, brick.key);
  seen.corner = Vec3f(seen.placed.to_camera.origin);
  for (int axis = 0; axis < 3; ++axis) seen.cell[axis] = Vec3f(seen.placed.to_camera.column[axis]);
  if (seen.by_triangles) {
    seen.triangles = triangle_view(brick.node, pieces[static_cast<int>(Piece::triangles)]);
  } else {
    seen.samples = brick_view(brick.node, pieces[static_cast<int>(Piece::geometry)],
                              pieces[static_cast<int>(Piece::attributes)]);
  }
  return seen;
}

void SurfaceDrawing::count_colors(const CutBrick& brick, const SeenBrick& seen) {
  if (seen.there && !seen.by_triangles) counts_.bytes += piece_bytes(brick.node, Piece::attributes);
}

RowShading SurfaceDrawing::row_shading(std::span<const SeenBrick> seen) const {
  RowShading rows;
  rows.film = cut_.camera().film;
  rows.lighting = view_.lighting.lighting;
  rows.bricks = seen;
  rows.normals = normals_;
  rows.overlay = view_.overlay;
  const Affine3& to_camera = cut_.camera().world_to_camera;
  for (int i = 0; i < rows.lighting.lights; ++i) {
    const Vec3d place = view_.lighting.place[i];
    const bool near = rows.lighting.light[i].kind == scene::LightKind::point;
    rows.light[i] = Vec3f(near ? to_camera.point(place) : to_camera.vector(place));
  }
  return rows;
}

/// shade_row() for one pixel after the other, in doubles: what it should find.
void SurfaceDrawing::shade_row_plainly(const RowShading& rows, SurfacePixel* row, std::uint32_t y,
                                       std::uint32_t x0, std::uint32_t x1) const {
  for (std::uint32_t x = x0; x < x1; ++x) {
    SurfacePixel& pixel = row[x];
    if (!pixel.seen() || pixel.shaded() || !rows.bricks[pixel.brick].there) continue;
    const SeenBrick& brick = rows.bricks[pixel.brick];
    const Ray ray = rows.film.ray(x, y);
    SurfacePoint point =
        brick.by_triangles
            ? point_of_triangle(brick.triangles, brick.placed, ray, rows.film.orthographic, pixel.item)
            : point_of_sample(brick.samples, brick.placed, ray, unpacked(pixel.item), pixel.depth);
    if (rows.overlay != Overlay::none) point.color = overlay_color(rows.overlay, brick, pixel.item);
    pixel.place = static_cast<float>(point.depth);
    pixel.color = lights_[brick.instance].shade(point.normal, point.color, x, y, point.depth);
    pixel.object = brick.object;
  }
}

/// Shades what is there of a tile; returns whether something is left.
bool SurfaceDrawing::shade_tile(const RowShading& rows, const PixelRect& rect) {
  bool left = false;
  const auto x0 = static_cast<std::uint32_t>(rect.x0), x1 = static_cast<std::uint32_t>(rect.x1);
  for_rows(rect, [&](SurfacePixel* row, std::int32_t y) {
    if (view_.plain) {
      shade_row_plainly(rows, row, static_cast<std::uint32_t>(y), x0, x1);
    } else {
      shade_row(rows, row, static_cast<std::uint32_t>(y), x0, x1);
    }
    left = left ||
           std::any_of(row + x0, row + x1, [](const SurfacePixel& p) { return p.seen() && !p.shaded(); });
  });
  return left;
}

/// Shades what is seen and not shaded; what that lacks is what is returned.
std::vector<LackingElement> SurfaceDrawing::shade() {
  // Which bricks are seen is found first, as looking up what is in memory is for one thread.
  std::vector<std::uint8_t> wanted(cut_.bricks().size());
  const auto for_unshaded = [&](auto function) {
    exec::parallel_for(cpu_, tiles_.size(), [&](std::size_t tile) {
      if (tiles_[tile] == kUnshaded) function(tile, rect_of(static_cast<std::uint32_t>(tile)));
    });
  };
  for_unshaded([&](std::size_t, const PixelRect& rect) {
    for_rows(rect, [&](const SurfacePixel* row, std::int32_t) {
      std::uint32_t last = SurfacePixel::kNothing;
      for (std::int32_t x = rect.x0; x < rect.x1; ++x) {
        if (row[x].brick == last || row[x].shaded() || !row[x].seen()) continue;
        last = row[x].brick;
        std::atomic_ref(wanted[last]).store(1, std::memory_order_relaxed);
      }
    });
  });
  std::vector<SeenBrick> seen(wanted.size());
  std::vector<LackingElement> lacking;
  for (std::uint32_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == 0) continue;
    seen[i] = look_up(cut_.bricks()[i], lacking);
    count_colors(cut_.bricks()[i], seen[i]);
  }
  const RowShading rows = row_shading(seen);
  for_unshaded([&](std::size_t tile, const PixelRect& rect) {
    if (!shade_tile(rows, rect)) tiles_[tile] = kShaded;
  });
  return lacking;
}

}  // namespace gvx::surface
