/// \file
/// The pieces of a surface brick, as they are in a store and in memory.
///
///     geometry     the depth ranges of 8 x 8 blocks of columns, 128 bytes; the primary grid
///     attributes   of each sample, by rank
///     triangles    triangle_list.h
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/codec.h"
#include "gvx/surface/surface_brick.h"
#include "gvx/surface/surface_format.h"
#include "gvx/surface/triangle_list.h"

namespace gvx::surface {

inline constexpr std::size_t kBlockBytes =
    SurfaceBrickView::kBlocks * SurfaceBrickView::kBlocks * sizeof(DepthRange);

/// The geometry of a brick.
std::vector<std::byte> geometry_bytes(const SurfaceBrick& brick);

/// How many bytes a node's piece has; 0 where it has none.
std::uint64_t piece_bytes(const SurfaceNode& node, Piece piece);
/// How it is compressed.
store::BlockLayout piece_layout(const SurfaceNode& node, Piece piece);

/// An error where the bytes, which may be of a damaged file, are not what the node says.
Status check_piece(const SurfaceNode& node, Piece piece, std::span<const std::byte> bytes);

/// Of pieces that were checked; pieces that are not needed may be null.
inline SurfaceBrickView brick_view(const SurfaceNode& node, const std::byte* geometry,
                                   const std::byte* attributes) {
  return {node.axis(),
          {geometry != nullptr ? geometry + kBlockBytes : nullptr, node.grid_form()},
          reinterpret_cast<const DepthRange*>(geometry),
          reinterpret_cast<const SampleAttributes*>(attributes)};
}
inline TriangleListView triangle_view(const SurfaceNode& node, const std::byte* triangles) {
  return {triangles, node.vertices, node.triangles, node.wide()};
}

}  // namespace gvx::surface
