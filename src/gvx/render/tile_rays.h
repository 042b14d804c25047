/// \file
/// TileRays: the rays of a tile of the film side by side, and their way from node to node in vectors of
/// doubles. What is computed for a ray is what RayMarcher of march.h computes: its bits depend neither on the
/// other rays nor on the instruction set.
#pragma once

#include <bit>
#include <cstdint>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/frame.h"
#include "gvx/render/stretch_batch.h"

namespace gvx::render {

struct TileRays {
  static constexpr std::uint32_t kMost = exec::TileGrid::kTile * exec::TileGrid::kTile;
  static constexpr double kNever = 9e15;  ///< a tick that never comes

  /// In tree space; t is the distance in the world.
  alignas(64) double origin[3][kMost];
  alignas(64) double direction[3][kMost];
  alignas(64) double inverse[3][kMost];  ///< of the direction
  alignas(64) double enter[kMost];       ///< the visible volume
  alignas(64) double exit[kMost];
  alignas(64) double world_origin[3][kMost];
  alignas(64) float world_direction[3][kMost];

  /// Where the next step starts, and the zone that it is in (FrameView::Zone).
  alignas(64) double tick[kMost];
  alignas(64) double stride[kMost];
  alignas(64) double zone_end[kMost];
  alignas(64) double across[kMost];  ///< nodes of the zone's level along an axis
  std::int32_t level[kMost];
  bool blended[kMost];

  /// The stretch that a ray stands before.
  alignas(64) double centre[kMost];  ///< of its first step
  alignas(64) std::int32_t steps[kMost];

  /// RayState.
  alignas(64) float color[3][kMost];
  alignas(64) float opacity[kMost];
  alignas(64) std::int32_t samples[kMost];
};

/// Some rays of a tile, in any order.
struct RayList {
  std::uint32_t size = 0;
  alignas(64) std::int32_t ray[TileRays::kMost];

  void push(std::uint32_t index) { ray[size++] = static_cast<std::int32_t>(index); }
  /// Those from `first` on whose bits are set, in their order.
  void push_bits(std::uint32_t first, std::uint64_t bits) {
    for (; bits != 0; bits &= bits - 1) push(first + static_cast<std::uint32_t>(std::countr_zero(bits)));
  }
};

/// The next steps of the rays of a list, and the nodes that hold them.
struct RaySteps {
  alignas(64) double centre[TileRays::kMost];         ///< of the step; negative: behind the visible volume
  alignas(64) std::int32_t cell[3][TileRays::kMost];  ///< of the ray's level
  alignas(64) std::int32_t node[TileRays::kMost];     ///< its place in NodeFaces
  alignas(64) double steps[TileRays::kMost];          ///< whose centres are in the node
};

/// What rays must know of nodes to leave them.
struct NodeFaces {
  static constexpr std::uint32_t kMost = 1024;

  alignas(64) double face[3][2 * kMost];  ///< in tree space: the low ones, then the high ones
  alignas(64) double stride[kMost];       ///< of the steps in the node
  alignas(64) double most_steps[kMost];
  alignas(64) double zoned[kMost];  ///< 1: steps end with the ray's zone; 0: a preview's coarser steps do not
};

/// The finest level whose cells are counted here.
inline constexpr double kMostAcross = 1 << 30;

/// The rays through the pixels (x0 + i * apart, y0 + j * apart) for i below the tile's edge and j below
/// `rows`; the place of each is j * edge + i.
void set_up(const FrameView& frame, double x0, double y0, double apart, std::uint32_t rows, TileRays& rays);

/// The centre and cell of each ray's next step.
void find_cells(const FrameView& frame, const TileRays& rays, RayList& list, RaySteps& steps);

/// Moves each ray behind all its steps whose centres are in its node.
void leave_nodes(const FrameView& frame, const NodeFaces& nodes, RayList& list, RaySteps& steps,
                 TileRays& rays);

/// A brick's place in tree space: bricks like it along an axis, and its corner in bricks.
struct BrickPlace {
  double across = 1;
  Vec3d corner;
};

/// Puts the stretches of rays through a brick, and the coarser one where the batch is blended, into the
/// batch: where they go and what they have gathered. `level` is that of their steps.
void fill_batch(const FrameView& frame, const TileRays& rays, RayList& list, int level,
                const BrickPlace& fine, const BrickPlace& coarse, StretchBatch& batch);

/// Gives the rays what the batch has gathered.
void take_back(const StretchBatch& batch, const RayList& list, TileRays& rays);

}  // namespace gvx::render
