/// \file
/// The march of march.h for all rays of a tile of the film at once, on a CPU. Each node that rays of a tile
/// come to is walked to once; rays that stand before the same brick go through it together, in the lanes of
/// vectors, nearest bricks first: so that a brick is in the caches for all of them, and those behind catch
/// up.
///
/// The order in which bricks are taken is the tile's, what a ray does is its own: its bits depend neither on
/// the other rays nor on what is resident.
#pragma once

#include <cstdint>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/tile/tile_rays.h"

namespace gvx::render {

/// Is a pass marched tile by tile on a CPU? Every way to look is, unless one ray at a time was asked for.
/// Within a tile, rays are taken in vectors where vectors_for (vectors.h) knows any for the view.
bool marches_tiles(const Pass& pass);

/// As march_exact of march_pass.h, on a CPU, where marches_tiles(pass).
bool tile_march(const exec::Device& cpu, const ExactMarch& march);

/// As march_preview of march_pass.h, there too; a tile that was begun is drawn whole.
bool tile_preview(const exec::Device& cpu, const PreviewMarch& march);

/// Marches some rays of a tile through one object of several, from their states on, which have a place for
/// each ray of a whole tile. A ray that is through is finished. To `pixels`, for previews, is added what they
/// wanted. Returns the rays that it has left as they are, since they must be marched by themselves: of
/// projections those that have no whole step in the object. A thread does one at a time.
ActiveRays march_object(const Pass& pass, const ObjectView& object, const RaysOfTile& tile,
                        const ActiveRays& rays, RayState* states, PreviewPixel* pixels,
                        exec::Deadline deadline);

}  // namespace gvx::render
