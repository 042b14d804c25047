/// \file
/// SurfaceBrick: a piece of a surface as samples: the cells that it is in, as a grid of columns
/// (primary_grid.h), and in an array of their own the samples' attributes, which only visible pixels read.
///
/// After Reichl, Chajdas, Buerger, Westermann 2012, section 3.2. Cells are found along three axes through
/// their centres, so that no path from cell to adjacent cell goes through a closed surface without meeting
/// one (mesh/surface_sampler.h).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gvx/core/macros.h"
#include "gvx/surface/cell_set.h"
#include "gvx/surface/primary_grid.h"
#include "gvx/surface/sample_attributes.h"
#include "gvx/surface/sampled_cells.h"

namespace gvx::surface {

/// Of kBlock x kBlock columns, the least and the greatest depth at which there is a cell.
struct DepthRange {
  std::uint8_t least = kCells, most = 0;  ///< least > most: there is none

  GVX_HD bool meets(int first, int last) const { return first <= most && least <= last; }
  constexpr bool operator==(const DepthRange&) const = default;
};

/// What a ray is cast through.
struct SurfaceBrickView {
  int axis = 2;  ///< the primary one
  PrimaryGridView grid;
  const DepthRange* blocks = nullptr;
  const SampleAttributes* attributes = nullptr;  ///< by rank

  static constexpr int kBlock = 4, kBlocks = kCells / kBlock;
  GVX_HD const DepthRange& block(int u, int v) const { return blocks[u / kBlock + kBlocks * (v / kBlock)]; }
};

struct SurfaceBrick {
  int axis = 2;
  PrimaryGrid grid;
  std::array<DepthRange, SurfaceBrickView::kBlocks * SurfaceBrickView::kBlocks> blocks;
  std::vector<SampleAttributes> attributes;

  SurfaceBrickView view() const { return {axis, grid.view(), blocks.data(), attributes.data()}; }
};

SurfaceBrick make_brick(const SampledCells& samples);

}  // namespace gvx::surface
