/// \file
/// tile_march: the march of march.h for all rays of a tile of the film at once, on a CPU. Rays that stand
/// before the same brick go through it together, in the lanes of vectors, nearest bricks first: so that a
/// brick is in the caches for all of them, and those behind catch up.
///
/// The order in which bricks are taken is the tile's, what a ray does is its own: its bits depend neither on
/// the other rays nor on what is resident.
#pragma once

#include "gvx/exec/tile_grid.h"
#include "gvx/render/march_pass.h"

namespace gvx::render {

/// As march_exact of march_pass.h, on a CPU, for frames of which composites_batches() is true.
bool tile_march(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished);

}  // namespace gvx::render
