/// \file
/// The march of march.h for all rays of a tile of the film at once, on a CPU. Each node that rays of a tile
/// come to is walked to once; rays that stand before the same brick go through it together, in the lanes of
/// vectors, nearest bricks first: so that a brick is in the caches for all of them, and those behind catch
/// up.
///
/// The order in which bricks are taken is the tile's, what a ray does is its own: its bits depend neither on
/// the other rays nor on what is resident.
#pragma once

#include "gvx/exec/tile_grid.h"
#include "gvx/render/march_pass.h"

namespace gvx::render {

/// Is a pass marched tile by tile on a CPU? Every way to look is, unless one ray at a time was asked for.
/// Within a tile, rays are taken in vectors where vectors_for (vectors.h) knows any for the view.
bool marches_tiles(const Pass& pass);

/// As march_exact of march_pass.h, on a CPU, where marches_tiles(pass).
bool tile_march(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished);

/// As march_preview of march_pass.h, there too; a tile that was begun is drawn whole.
bool tile_preview(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                  exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                  std::uint32_t generation, exec::BufferView<const RayState> rays,
                  exec::BufferView<PreviewPixel> pixels);

}  // namespace gvx::render
