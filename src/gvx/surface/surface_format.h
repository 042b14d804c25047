/// \file
/// The bytes of a surface store. docs/store-format.md is the specification.
///
///     offset 0     SurfaceHeader, 256 bytes, little-endian, written last
///     256 ..       the pieces of bricks, and between them pages of nodes, each compressed on its own
///     sections     levels: of each level, from the root on, how many nodes it has
///                  pages: where the pages of nodes are, level by level
///                  metadata: JSON
///     table        of the sections
///
/// A surface is a tree in which each node has up to eight children. A node's brick may have three pieces:
/// the geometry of its samples, their attributes, and the triangles that it meets. The nodes of a level are
/// in the tree's order (Morton 1966), so a node's children are side by side in the next level.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "gvx/surface/cell_set.h"
#include "gvx/surface/primary_grid.h"

namespace gvx::surface {

static_assert(std::endian::native == std::endian::little, "the store's structs are its bytes");

inline constexpr std::array<char, 8> kSurfaceMagic = {'G', 'V', 'X', 'S', 'U', 'R', 'F', 'C'};
inline constexpr std::uint32_t kSurfaceVersion = 1;

inline constexpr const char* kLevelsSection = "levels";
inline constexpr const char* kPagesSection = "pages";
inline constexpr const char* kSurfaceMetadataSection = "metadata";

struct SurfaceHeader {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t header_bytes;
  std::uint32_t codec;        ///< store::Codec
  std::uint32_t levels;       ///< depth of the tree, the root included
  double cells_to_world[12];  ///< three columns and the origin of an Affine3, from cells of the finest level
  std::uint64_t triangles;    ///< of the mesh
  std::uint64_t table_offset, table_checksum;
  std::uint64_t file_bytes;
  std::uint32_t sections;  ///< entries of the table of sections
  std::uint32_t flags;     ///< a reader must know all that are set
  std::uint64_t reserved[11];
  std::uint64_t header_checksum;  ///< of the bytes before it
};
static_assert(sizeof(SurfaceHeader) == 256);

/// What a brick consists of.
enum class Piece : std::uint8_t { geometry, attributes, triangles };
inline constexpr int kPieces = 3;
inline constexpr const char* kPieceNames[kPieces] = {"geometry", "attributes", "triangles"};

/// A node of the tree, 64 bytes.
struct SurfaceNode {
  std::uint64_t offset = 0;                ///< of its pieces in the file, one behind the other
  std::uint32_t bytes[kPieces] = {};       ///< of each piece, compressed; 0: it has none
  std::uint32_t checksums[kPieces] = {};   ///< of the compressed pieces
  std::uint32_t first_child = 0;           ///< its place in the next level
  std::uint32_t samples = 0;               ///< cells with some of the surface; 0: it is unresolved
  std::uint32_t triangles = 0;             ///< that the brick's piece has
  std::uint32_t vertices = 0;              ///< of these
  std::uint16_t grid_bytes = 0;            ///< of the samples' primary grid
  std::uint8_t children = 0;               ///< a bit for each that is there: x + 2 * (y + 2 * z)
  std::uint8_t form = 0;                   ///< bits 0 and 1: the primary axis; 2: GridForm; 3: wide places
  std::uint8_t low[3] = {}, high[3] = {};  ///< the cells that the surface is in
  std::uint8_t reserved[6] = {};

  constexpr bool operator==(const SurfaceNode&) const = default;

  int axis() const { return form & 3; }
  GridForm grid_form() const { return static_cast<GridForm>(form >> 2 & 1); }
  /// Are the triangles' places numbers of 32 bits, not of 16?
  bool wide() const { return (form >> 3 & 1) != 0; }
  void set_form(int axis, GridForm grid, bool wide) {
    form = static_cast<std::uint8_t>(axis | static_cast<int>(grid) << 2 | (wide ? 8 : 0));
  }
  bool resolved() const { return samples > 0; }
  /// The place of a child that is there.
  std::uint32_t child_at(int octant) const {
    const std::uint32_t before = children & ((std::uint32_t{1} << octant) - 1);
    return first_child + static_cast<std::uint32_t>(bits_in(before));
  }
};
static_assert(sizeof(SurfaceNode) == 64);

/// Nodes of a level that are read at once. The last page of a level may hold fewer.
inline constexpr std::uint32_t kPageNodes = 64;

/// Pages of a level of so many nodes.
constexpr std::uint64_t pages_of(std::uint64_t nodes) {
  return (nodes + kPageNodes - 1) / kPageNodes;
}

/// The most levels of a surface: cells of the finest are numbers of 32 bits.
inline constexpr std::uint32_t kMostSurfaceLevels = 26;

}  // namespace gvx::surface
