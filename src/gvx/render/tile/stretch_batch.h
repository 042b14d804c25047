/// \file
/// StretchBatch: the stretches of many rays through one brick, side by side for a processor's vectors; and
/// composite_batch, which composites them as composite.h does one. The vectors are the widest that the
/// processor has (Google Highway, chosen at run time).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/frame/frame.h"

namespace gvx::render {

struct StretchBatch {
  /// As many rays as a tile of a film has.
  static constexpr std::uint32_t kMost = exec::TileGrid::kTile * exec::TileGrid::kTile;

  /// A brick of the tree's format, and the rays' way through it: in voxels from its low corner, from the
  /// centre of the first step. Rows are of one ray each, and one more than there are rays:
  ///
  ///     fine     first x, y, z, steps    way of a step x, y, z, the ray's number (an integer's bits)
  ///     coarse   first x, y, z, blend    way of a step x, y, z, growth of blend a step
  ///
  /// `blend` is the coarse brick's share at the centre of the first step; it is held from 0 to 1.
  struct Path {
    const std::byte* brick = nullptr;
    bool deviates = false;
    float gradient_scale = 1;
    float voxels_across = 1;  ///< of its level, in all of tree space
    alignas(64) float row[kMost + 1][8];

    /// Of the brick's texels those that places of the rays are behind, along y and z: the first and last, as
    /// far as there are any.
    std::uint32_t first_row[2] = {}, last_row[2] = {32, 32};
    /// Where these are put, if that pays. Of bytes, of each texel: itself, the next along y, the next along
    /// z, and the one that is next along both, from the lowest bits up.
    alignas(64) std::uint32_t quads[plane_texels(32)];
    /// And of deviations, at half the resolution: the same, each the upper half of a float.
    alignas(64) std::uint64_t deviations[plane_texels(16, 1)];
  };

  std::uint32_t m = 16;  ///< the bricks' edge, 8, 16 or 32
  int level = 0;         ///< of the steps
  float units = 1;       ///< unit distances of the extinctions a step
  bool blended = false;  ///< the coarse brick is seen too
  ChannelRanges ranges;  ///< of the node's values, where these are projected
  Path fine, coarse;
  /// Where in the world the centre of the first step is, and the way of a step: x, y, z and one of no
  /// concern, twice. Only where lights are near.
  alignas(64) float place[kMost + 1][8];

  /// Of the fine brick's cells those that can be seen (visible_cells.h); for batches of one brick.
  std::uint64_t cells = ~std::uint64_t(0);

  std::uint32_t count = 0;                ///< rows
  std::uint8_t length[kMost + 16];        ///< of each row: its steps, or 255; of runs those in it
  alignas(64) std::int32_t order[kMost];  ///< in which rows are put side by side: those of like lengths

  /// Where only some steps are taken, those that can be seen by `cells`: of each row the run that is taken
  /// now, its first step and from kRunBits on how many; and of a window of 31 steps those that are left.
  static constexpr int kRunBits = 16;
  alignas(64) std::int32_t run[kMost + 16];
  alignas(64) std::uint32_t to_take[kMost + 16];

  /// Of all rays, by their numbers: unit directions towards the eye (x, y, z and one of no concern); what
  /// they have gathered (RayState: red, green, blue, opacity).
  const float (*to_eye)[4] = nullptr;
  float (*gathered)[4] = nullptr;
  std::int32_t* samples = nullptr;

  /// Rays that are looked at in turns (composite_batch): their rows, and of each row the next step, and the
  /// value and deviation at its front end and its back end, in entries of the function.
  std::uint32_t waiting_count = 0;
  std::int32_t waiting_row[kMost];
  alignas(64) float waiting[kMost + 1][8];

  /// Out: the numbers of those rays that see nothing more.
  std::uint32_t opaque_count = 0;
  std::int32_t opaque[kMost + 16];

  float steps(std::uint32_t i) const { return fine.row[i][3]; }
  std::uint32_t ray(std::uint32_t i) const { return std::bit_cast<std::uint32_t>(fine.row[i][7]); }

  /// Fills `order`: rays of a vector go as far as the one that goes farthest.
  void put_in_order();
};

/// Adds what is seen of every ray's stretch of scalars of one channel to what it has gathered. A ray's bits
/// do not depend on the others in the batch. (All of these put the rows in order.)
void composite_batch(const FrameView& frame, StretchBatch& batch);

/// The same of several channels.
void composite_channels_batch(const FrameView& frame, StretchBatch& batch);

/// The same by post-classification (post_classified.h), of any number of channels.
void composite_post_batch(const FrameView& frame, StretchBatch& batch);

/// The same for labels, and for colours with or without normals (classified.h).
void composite_classified_batch(const FrameView& frame, StretchBatch& batch);

/// Takes the values of scalars of one to four channels into what projecting rays have gathered
/// (projection.h).
void project_batch(const FrameView& frame, StretchBatch& batch);

/// Finds the first place where a scalar is the isovalue, and lights it (isosurface.h).
void find_surface_batch(const FrameView& frame, StretchBatch& batch);

}  // namespace gvx::render
