#include "gvx/surface/surface_pieces.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace gvx::surface {

static_assert(sizeof(DepthRange) == 2 && sizeof(SampleAttributes) == 6, "their bytes are those of the store");

std::vector<std::byte> geometry_bytes(const SurfaceBrick& brick) {
  std::vector<std::byte> bytes(kBlockBytes + brick.grid.bytes.size());
  std::memcpy(bytes.data(), brick.blocks.data(), kBlockBytes);
  std::copy(brick.grid.bytes.begin(), brick.grid.bytes.end(), bytes.begin() + kBlockBytes);
  return bytes;
}

std::uint64_t piece_bytes(const SurfaceNode& node, Piece piece) {
  switch (piece) {
    case Piece::geometry:
      return node.resolved() ? kBlockBytes + node.grid_bytes : 0;
    case Piece::attributes:
      return node.samples * sizeof(SampleAttributes);
    case Piece::triangles:
      return TriangleListView::size(node.vertices, node.triangles, node.wide());
  }
  return 0;
}

store::BlockLayout piece_layout(const SurfaceNode& node, Piece piece) {
  if (piece == Piece::attributes) return {sizeof(SampleAttributes), node.samples};
  if (piece == Piece::triangles) return {TriangleListView::place_bytes(node.wide()), node.vertices};
  return {};
}

Status check_piece(const SurfaceNode& node, Piece piece, std::span<const std::byte> bytes) {
  if (bytes.size() != piece_bytes(node, piece)) return Error{"surface brick: it has another size"};
  if (piece == Piece::triangles) return check_triangles(node.vertices, node.triangles, node.wide(), bytes);
  if (piece == Piece::attributes || !node.resolved()) return {};
  GVX_ASSIGN(const std::uint32_t samples, check_grid(node.grid_form(), bytes.subspan(kBlockBytes)));
  if (samples != node.samples) {
    return Error{"surface brick: its grid has " + std::to_string(samples) + " samples, not " +
                 std::to_string(node.samples)};
  }
  return {};
}

}  // namespace gvx::surface
