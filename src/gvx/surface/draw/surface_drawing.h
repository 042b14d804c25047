/// \file
/// SurfaceDrawing: a picture's opaque surfaces, drawn from what is in memory. What is not there is named, and
/// drawn when it has come: each brick once, in any order. A picture that is complete has the same bits
/// whatever came when, on any number of threads.
///
///     cut -> bricks of which the pieces are there -> tiles: cast, splat, rasterise -> hits
///         -> what is seen: attributes -> shaded pixels
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gvx/exec/device.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/lighting.h"
#include "gvx/surface/draw/shade_rows.h"
#include "gvx/surface/draw/surface_cut.h"
#include "gvx/surface/draw/surface_film_view.h"
#include "gvx/surface/draw/surface_overlay.h"
#include "gvx/surface/draw/surface_shading.h"

namespace gvx::surface {

/// What a picture asks of its surfaces.
struct SurfaceView {
  scene::CameraView camera;
  std::uint32_t width = 0, height = 0;  ///< of the film, in rays
  scene::LightingView lighting;
  double widest_cell = kWidestCell;  ///< in pixels
  /// One ray at a time, one triangle at a time: slower. It defines what a picture is.
  bool plain = false;
  std::optional<Technique> only = {};  ///< where a brick can be drawn so; for tests and benches
  Overlay overlay = Overlay::none;
};

/// How much was drawn.
struct SurfaceCounts {
  std::uint64_t bricks[3] = {};              ///< by Technique
  std::uint64_t hidden = 0;                  ///< bricks that were not drawn, as something else is before them
  std::uint64_t triangles = 0, samples = 0;  ///< of the bricks that were drawn
  std::uint64_t bytes = 0;                   ///< of their pieces

  std::uint64_t drawn() const { return bricks[0] + bricks[1] + bricks[2]; }
};

class SurfaceDrawing {
 public:
  /// For threads of `cpu`. The surfaces must live as long as it does.
  SurfaceDrawing(const exec::Device& cpu, const SurfaceView& view,
                 std::span<const SurfaceInstance> instances);

  /// Begins another picture, in the same memory if it is of the same size.
  void see(const SurfaceView& view, std::span<const SurfaceInstance> instances);

  /// Draws what it can of what is not drawn yet, and says what else it needs, the nearest first.
  std::vector<LackingElement> advance();
  /// Is all drawn that the exact picture shows?
  bool complete() const { return complete_; }

  /// Draws all with what is in memory; coarser bricks stand in for what is not. If nothing lacks, the picture
  /// is the complete one.
  std::vector<LackingElement> draw_resident();

  SurfaceFilmView film() const { return {pixels_.data(), tiles_.data(), view_.width, view_.height}; }
  const SurfaceCounts& counts() const { return counts_; }

 private:
  /// A brick with the pieces it is drawn with.
  struct Drawn;

  void clear();
  bool hidden(const PixelRect& rect, double nearest) const;
  void draw(std::vector<Drawn>& bricks);
  void draw_tile(const PixelRect& rect, bool blank, std::span<const std::uint32_t> of_tile,
                 const std::vector<Drawn>& bricks);
  bool shade_tile(const RowShading& rows, const PixelRect& rect);
  std::vector<LackingElement> shade();
  void find_farthest(const PixelRect& tile);
  PixelRect rect_of(std::uint32_t tile) const;
  /// Calls function(row, y), where row[x] is pixel x.
  template <typename Function>
  void for_rows(const PixelRect& rect, Function function) {
    for (std::int32_t y = rect.y0; y < rect.y1; ++y) {
      function(&pixels_[static_cast<std::size_t>(y) * view_.width], y);
    }
  }
  SeenBrick look_up(const CutBrick& brick, std::vector<LackingElement>& lacking) const;
  void count_colors(const CutBrick& brick, const SeenBrick& seen);
  RowShading row_shading(std::span<const SeenBrick> seen) const;
  void shade_row_plainly(const RowShading& rows, SurfacePixel* row, std::uint32_t y, std::uint32_t x0,
                         std::uint32_t x1) const;

  exec::Device cpu_;
  SurfaceView view_;
  exec::TileGrid grid_;
  std::vector<SurfaceInstance> instances_;
  std::vector<SurfaceLight> lights_;      // of each instance
  std::vector<NormalsToCamera> normals_;  // of each instance
  SurfaceCut cut_;
  std::vector<std::uint64_t> orders_;  // of the cut's bricks
  std::vector<SurfacePixel> pixels_;
  // Of each tile: nothing was drawn into it, some of what was is not shaded, or all is.
  static constexpr std::uint8_t kBlank = 0, kUnshaded = 1, kShaded = 2;
  std::vector<std::uint8_t> tiles_;
  std::vector<float> farthest_;  // of each block of kBlock x kBlock pixels
  SurfaceCounts counts_;
  bool complete_ = false;

  static constexpr std::uint32_t kBlock = 16;
  std::uint32_t blocks_x_ = 0;
};

}  // namespace gvx::surface
