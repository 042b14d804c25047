#include "gvx/surface/draw/surface_drawing.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include "gvx/exec/parallel.h"
#include "gvx/surface/surface_pieces.h"

namespace gvx::surface {
namespace {

SurfaceCamera camera_of(const SurfaceView& view) {
  return {FilmPlane(view.camera, view.width, view.height), world_to_camera(view.camera), view.widest_cell};
}

/// Elements that are asked for at a time: what comes hides what is behind it, which need not come then.
constexpr std::size_t kMostLacking = 4096;

}  // namespace

struct SurfaceDrawing::Drawn {
  std::uint32_t number = 0;  // in the cut
  PlacedBrick placed;
  const std::byte* pieces[kPieces] = {};
};

SurfaceDrawing::SurfaceDrawing(const exec::Device& cpu, const SurfaceView& view,
                               std::span<const SurfaceInstance> instances)
    : cpu_(cpu),
      view_(view),
      grid_{view.width, view.height, TileHits::kEdge},
      instances_(instances.begin(), instances.end()),
      cut_(camera_of(view), instances_) {
  for (const SurfaceInstance& instance : instances_) {
    lights_.emplace_back(view.lighting, view.camera, instance.cells_to_world);
  }
  clear();
}

void SurfaceDrawing::clear() {
  pixels_.assign(std::size_t{view_.width} * view_.height, {});
  blocks_x_ = (view_.width + kBlock - 1) / kBlock;
  const std::uint32_t blocks_y = (view_.height + kBlock - 1) / kBlock;
  farthest_.assign(std::size_t{blocks_x_} * blocks_y, std::numeric_limits<float>::infinity());
  counts_ = {};
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

void SurfaceDrawing::find_farthest() {
  const std::size_t blocks_y = farthest_.size() / std::max(blocks_x_, 1u);
  exec::parallel_for(cpu_, blocks_y, [&](std::size_t block_y) {
    for (std::uint32_t block_x = 0; block_x < blocks_x_; ++block_x) {
      float most = 0;
      const std::uint32_t y0 = static_cast<std::uint32_t>(block_y) * kBlock, x0 = block_x * kBlock;
      for (std::uint32_t y = y0; y < std::min(y0 + kBlock, view_.height); ++y) {
        const SurfacePixel* row = &pixels_[std::size_t{y} * view_.width];
        for (std::uint32_t x = x0; x < std::min(x0 + kBlock, view_.width); ++x) most = std::max(most, row[x].depth);
      }
      farthest_[block_y * blocks_x_ + block_x] = most;
    }
  });
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
    const Piece piece = brick.technique == Technique::rasterise ? Piece::triangles : Piece::geometry;
    const std::byte* const bytes = surface.piece(brick.level, brick.place, piece);
    if (bytes == nullptr) {
      all_drawn = false;
      lacking.push_back({brick.instance, brick.level, brick.place, false, piece, piece_bytes(brick.node, piece),
                         brick.seen.nearest});
      continue;
    }
    drawn.pieces[static_cast<int>(piece)] = bytes;
    brick.drawn = true;
    ready.push_back(drawn);
  }
  draw(ready);
  if (all_drawn) {
    lacking = shade();
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
    for (int piece = 0; piece < kPieces; ++piece) {
      if (!needs(brick.technique, static_cast<Piece>(piece))) continue;
      drawn.pieces[piece] =
          instances_[brick.instance].surface->piece(brick.level, brick.place, static_cast<Piece>(piece));
    }
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
    const bool left_first = left.technique == Technique::rasterise, right_first = right.technique == Technique::rasterise;
    return left_first != right_first ? left_first : left.seen.nearest < right.seen.nearest;
  });
  std::vector<std::vector<std::uint32_t>> of_tiles(grid_.tiles());
  for (const std::uint32_t i : order) {
    const CutBrick& brick = cut[bricks[i].number];
    ++counts_.bricks[static_cast<int>(brick.technique)];
    const bool triangles = brick.technique == Technique::rasterise;
    (triangles ? counts_.triangles : counts_.samples) += triangles ? brick.node.triangles : brick.node.samples;
    for (int piece = 0; piece < kPieces; ++piece) {
      if (bricks[i].pieces[piece] != nullptr) counts_.bytes += piece_bytes(brick.node, static_cast<Piece>(piece));
    }
    const PixelRect& rect = brick.seen.rect;
    constexpr std::int32_t kEdge = TileHits::kEdge;
    for (std::int32_t y = rect.y0 / kEdge; y <= (rect.y1 - 1) / kEdge; ++y) {
      for (std::int32_t x = rect.x0 / kEdge; x <= (rect.x1 - 1) / kEdge; ++x) {
        of_tiles[static_cast<std::size_t>(y) * grid_.tiles_x() + static_cast<std::size_t>(x)].push_back(i);
      }
    }
  }
  exec::parallel_for(cpu_, of_tiles.size(), [&](std::size_t tile) {
    if (!of_tiles[tile].empty()) draw_tile(static_cast<std::uint32_t>(tile), of_tiles[tile], bricks);
  });
  find_farthest();
}

void SurfaceDrawing::draw_tile(std::uint32_t tile, std::span<const std::uint32_t> of_tile,
                               const std::vector<Drawn>& bricks) {
  static thread_local TileHits hits;
  constexpr std::int32_t kEdge = TileHits::kEdge;
  const auto x0 = static_cast<std::int32_t>(tile % grid_.tiles_x()) * kEdge,
             y0 = static_cast<std::int32_t>(tile / grid_.tiles_x()) * kEdge;
  const PixelRect rect = PixelRect{x0, y0, x0 + kEdge, y0 + kEdge} &
                         PixelRect{0, 0, static_cast<std::int32_t>(view_.width), static_cast<std::int32_t>(view_.height)};
  hits.clear(rect, orders_.data());
  const auto for_pixels = [&](auto function) {
    for (std::int32_t y = rect.y0; y < rect.y1; ++y) {
      SurfacePixel* row = &pixels_[static_cast<std::size_t>(y) * view_.width];
      for (std::int32_t x = rect.x0; x < rect.x1; ++x) function(row[x], hits.index(x, y));
    }
  };
  for_pixels([&](const SurfacePixel& pixel, std::size_t at) {
    hits.depth[at] = pixel.depth;
    hits.brick[at] = pixel.brick;
    hits.item[at] = pixel.item;
  });
  const FilmPlane& film = cut_.camera().film;
  for (const std::uint32_t i : of_tile) {
    const Drawn& drawn = bricks[i];
    const CutBrick& brick = cut_.bricks()[drawn.number];
    const PixelRect part = brick.seen.rect & rect;
    if (hits.hides(part, brick.seen.nearest)) continue;
    if (brick.technique == Technique::rasterise) {
      const TriangleListView triangles =
          triangle_view(brick.node, drawn.pieces[static_cast<int>(Piece::triangles)]);
      rasterise({film, drawn.placed, triangles, drawn.number, rect}, hits);
      continue;
    }
    const SurfaceBrickView samples =
        brick_view(brick.node, drawn.pieces[static_cast<int>(Piece::geometry)], nullptr);
    const DrawnSamples what{film, drawn.placed, samples, drawn.number, part};
    if (brick.technique == Technique::splat) {
      splat_samples(what, hits);
    } else {
      cast_samples(what, hits);
    }
  }
  for_pixels([&](SurfacePixel& pixel, std::size_t at) {
    if (pixel.brick == hits.brick[at] && pixel.item == hits.item[at]) return;
    pixel = {hits.depth[at], hits.brick[at], hits.item[at], INFINITY, {}, -1};
  });
}

Vec3f SurfaceDrawing::overlay_color(const CutBrick& brick, const SurfaceBrickView& samples,
                                    std::uint32_t item) const {
  constexpr Vec3f kRed(0.85f, 0.25f, 0.2f), kGreen(0.3f, 0.7f, 0.3f), kBlue(0.25f, 0.45f, 0.85f);
  if (view_.overlay == Overlay::technique) {
    return brick.technique == Technique::rasterise ? kRed : brick.technique == Technique::cast ? kGreen : kBlue;
  }
  // As in figure 7 of Reichl and others: one sample, one span of several, several spans.
  if (brick.technique == Technique::rasterise) return Vec3f(0.6f);
  const Cell cell = GridAxes(brick.node.axis()).to_grid(unpacked(item));
  const std::uint32_t column = samples.grid.column(cell.x, cell.y), low = column & (~column + 1);
  if (bits_in(column) == 1) return kGreen;
  const bool one_span = (column & (column + low)) == 0;
  return one_span ? kBlue : kRed;
}

/// Shades what is seen and not shaded; what that lacks is what is returned.
std::vector<LackingElement> SurfaceDrawing::shade() {
  const FilmPlane& film = cut_.camera().film;
  // Which bricks are seen is found first, as looking up what is in memory is for one thread.
  std::vector<std::uint8_t> wanted(cut_.bricks().size());
  exec::parallel_for(cpu_, view_.height, [&](std::size_t y) {
    const SurfacePixel* row = &pixels_[y * view_.width];
    for (std::uint32_t x = 0; x < view_.width; ++x) {
      if (row[x].seen() && !row[x].shaded()) std::atomic_ref(wanted[row[x].brick]).store(1, std::memory_order_relaxed);
    }
  });
  struct Shaded {
    PlacedBrick placed;
    SurfaceBrickView samples;
    TriangleListView triangles;
    bool there = false;
  };
  std::vector<Shaded> shaded(wanted.size());
  std::vector<LackingElement> lacking;
  for (std::uint32_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == 0) continue;
    const CutBrick& brick = cut_.bricks()[i];
    Shaded& of_brick = shaded[i];
    of_brick.there = true;
    const std::byte* pieces[kPieces] = {};
    for (int p = 0; p < kPieces; ++p) {
      const auto piece = static_cast<Piece>(p);
      if (!needs(brick.technique, piece)) continue;
      pieces[p] = instances_[brick.instance].surface->piece(brick.level, brick.place, piece);
      if (pieces[p] != nullptr) continue;
      of_brick.there = false;
      lacking.push_back({brick.instance, brick.level, brick.place, false, piece, piece_bytes(brick.node, piece),
                         brick.seen.nearest});
    }
    if (!of_brick.there) continue;
    of_brick.placed = cut_.camera().place(instances_[brick.instance], brick.level, brick.key);
    if (brick.technique == Technique::rasterise) {
      of_brick.triangles = triangle_view(brick.node, pieces[static_cast<int>(Piece::triangles)]);
    } else {
      of_brick.samples = brick_view(brick.node, pieces[static_cast<int>(Piece::geometry)],
                                    pieces[static_cast<int>(Piece::attributes)]);
    }
  }
  exec::parallel_for(cpu_, view_.height, [&](std::size_t y) {
    SurfacePixel* row = &pixels_[y * view_.width];
    for (std::uint32_t x = 0; x < view_.width; ++x) {
      SurfacePixel& pixel = row[x];
      if (!pixel.seen() || pixel.shaded() || !shaded[pixel.brick].there) continue;
      const CutBrick& brick = cut_.bricks()[pixel.brick];
      const Shaded& of_brick = shaded[pixel.brick];
      const Ray ray = film.ray(x, double(y));
      SurfacePoint point =
          brick.technique == Technique::rasterise
              ? point_of_triangle(of_brick.triangles, of_brick.placed, ray, film.orthographic, pixel.item)
              : point_of_sample(of_brick.samples, of_brick.placed, ray, unpacked(pixel.item));
      if (view_.overlay != Overlay::none)
        point.color = overlay_color(brick, of_brick.samples, pixel.item);
      pixel.place = static_cast<float>(point.depth);
      pixel.color = lights_[brick.instance].shade(point.normal, point.color, x, double(y), point.depth);
      pixel.object = instances_[brick.instance].object;
    }
  });
  return lacking;
}

}  // namespace gvx::surface
