/// \file
/// The .gvx store on disk, version 3. docs/store-format.md is the specification; these structs are its bytes.
///
///     offset 0     FileHeader, 256 bytes, little-endian, written last
///     256 ..       bricks, laid out as core/voxel.h draws them, each compressed on its own,
///                  and between them pages of the index, compressed
///     sections     directory: where the top of each level's index is
///                  records: the fields of a node's record
///                  metadata: JSON, the source's name, its orientation's meaning, the histograms
///                  and any others
///     table        of the sections
///
/// The index of a level is a tree of pages. At the foot a page holds the records of 8^3 nodes, above that the
/// references to 8^3 pages, up to one page that holds all. To sample a voxel: directory -> pages, top to foot
/// -> NodeRecord -> brick. Each step is one range of bytes, so a store is read piecewise from a disk or by
/// HTTP ranges, and how much is read first does not depend on its size.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/node_key.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/core/volume_description.h"
#include "gvx/store/checksum.h"

namespace gvx::store {

static_assert(std::endian::native == std::endian::little, "the store's structs are its bytes");

inline constexpr std::array<char, 8> kMagic = {'G', 'V', 'X', 'S', 'T', 'O', 'R', 'E'};
/// What this program writes, and the oldest that it reads.
inline constexpr std::uint32_t kVersion = 3, kOldestVersion = 2;
/// Nodes along an edge of an index page, and pages along an edge of the page above them.
inline constexpr std::uint32_t kPageEdge = 8;
inline constexpr std::uint32_t kPageNodes = kPageEdge * kPageEdge * kPageEdge;

/// Bins of a channel's histogram.
inline constexpr std::size_t kHistogramBins = 1024;

/// The range of no value: whatever it is joined with stays as it is.
inline constexpr ValueRange kNoValues = {std::numeric_limits<float>::infinity(),
                                         -std::numeric_limits<float>::infinity()};

/// How bricks are compressed. The numbers are those of the file.
enum class Codec : std::uint32_t { none = 0, zstd = 1, lz4 = 2 };

const char* codec_name(Codec codec);

struct FileHeader {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t header_bytes;
  std::uint32_t n;           ///< children along an axis of a node: 2 or 3
  std::uint32_t m;           ///< voxels along an axis of a brick, border not counted: 8, 16 or 32
  std::uint32_t voxel_type;  ///< VoxelType
  std::uint32_t codec;       ///< Codec
  std::uint64_t dimensions[3];
  std::uint32_t levels;  ///< depth of the tree, the root included
  std::uint32_t page_edge;
  double voxel_to_world[12];  ///< three columns and the origin of an Affine3
  double scale;               ///< physical value = scale * stored value + offset
  double offset;
  std::uint32_t content;       ///< VoxelContent
  std::uint32_t planes;        ///< numbers a voxel
  std::uint32_t border;        ///< voxels around a brick, on each side: 1 or 2
  std::uint32_t flags;         ///< kNoData; a reader must know all that are set
  std::uint32_t record_bytes;  ///< of a node's record
  std::uint32_t sections;      ///< entries of the table of sections
  std::uint64_t table_offset, table_checksum;
  std::uint64_t file_bytes;
  std::uint64_t reserved[3];
  std::uint64_t header_checksum;  ///< of the bytes before it
};
static_assert(sizeof(FileHeader) == 256);

/// Voxels of type f32 may be NaN: nothing was measured there.
inline constexpr std::uint32_t kNoData = 1;

/// The widest border of a brick, in voxels.
inline constexpr std::uint32_t kMostBorder = 2;

/// Where some bytes of the file are, and their checksum.
struct BlockRef {
  std::uint64_t offset;
  std::uint32_t bytes;
  std::uint32_t checksum;

  constexpr bool operator==(const BlockRef&) const = default;
};
static_assert(sizeof(BlockRef) == 16);

/// Where an index page is, or in its place the one record that all nodes below have: so a large part of a
/// volume that has one value costs nothing.
struct PageRef : BlockRef {
  static constexpr std::uint32_t kOneRecord = 1u << 31;

  bool one_record() const { return (bytes & kOneRecord) != 0; }
  std::uint32_t stored_bytes() const { return bytes & ~kOneRecord; }

  constexpr bool operator==(const PageRef&) const = default;
};
static_assert(sizeof(PageRef) == 16);

/// What the index says of one node; record_layout.h says how it is stored. Its ranges hold the voxels of its
/// brick, of all bricks below it, and of a rim of n voxels around each: so also whatever the coarser level,
/// blended in, can show within the node. Colour voxels have the range of their opacity there, from 0. Where
/// all voxels of a channel are no data, its range is kNoValues.
struct NodeRecord {
  std::uint64_t offset;    ///< of its compressed brick in the file
  std::uint32_t bytes;     ///< of its compressed brick; 0: all of the node is ranges.at_minimum(), or no data
  std::uint32_t checksum;  ///< of the compressed brick
  ChannelRanges ranges;

  bool constant() const { return bytes == 0; }
  /// Are there values of none of the first `channels`?
  bool no_data(std::uint32_t channels) const {
    bool none = true;
    for (std::uint32_t c = 0; c < channels; ++c) none = none && ranges.channel[c] == kNoValues;
    return none;
  }
};

/// a * b, or the greatest number there is: sizes that come from files may be absurd.
inline std::uint64_t saturating_product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}

/// How many are in a box of that size.
inline std::uint64_t saturating_volume(Vec3i size) {
  return saturating_product(
      saturating_product(static_cast<std::uint64_t>(size.x), static_cast<std::uint64_t>(size.y)),
      static_cast<std::uint64_t>(size.z));
}

/// The nodes first .. last - 1, along each axis, of a level.
struct NodeBox {
  std::uint32_t level = 0;
  Vec3i first, last;

  std::uint64_t nodes() const { return saturating_volume(last - first); }
};

/// As --memory takes it: "300M", rounded up.
std::string mebibytes(std::uint64_t bytes);

/// "node (level 3: 1, 2, 0)".
std::string node_name(const NodeKey& key);

/// The shape of a tree over a volume: which levels, nodes and pages there are.
struct TreeShape {
  std::uint32_t n = 2;
  std::uint32_t m = 16;
  Vec3i dimensions;          ///< of the volume, in voxels
  std::uint32_t levels = 1;  ///< the root included: the fewest with m * n^(levels-1) >= every dimension

  static TreeShape covering(Vec3i dimensions, std::uint32_t n, std::uint32_t m);

  /// Voxels of a level: the volume's, divided by n per level above the finest and rounded up.
  Vec3i level_dimensions(std::uint32_t level) const;
  /// Nodes of a level that hold voxels.
  Vec3i level_nodes(std::uint32_t level) const;
  /// Index pages of a level that hold its nodes' records.
  Vec3i level_pages(std::uint32_t level) const { return index_pages(level, 0); }
  /// Index pages of a height: 0 holds records of nodes, each above it 8^3 pages of the one below.
  Vec3i index_pages(std::uint32_t level, std::uint32_t height) const;
  /// The height of the one page that holds all of a level.
  std::uint32_t index_height(std::uint32_t level) const;
  /// The nodes of a page.
  NodeBox page_nodes(std::uint32_t level, std::uint32_t height, Vec3i page) const;
  /// Does the node hold voxels of the volume?
  bool contains(const NodeKey& key) const;
  /// Nodes of all levels; the greatest number there is where they are more.
  std::uint64_t nodes() const;
  /// Voxels along the edge of the tree's cube at the finest level: m * n^(levels-1).
  double cube_voxels() const { return m * nodes_across(static_cast<int>(n), levels - 1); }
};

/// What a store says of its volume.
struct VolumeInfo : VolumeDescription {
  TreeShape shape;
  Codec codec = Codec::zstd;
  std::uint32_t border = kBrickBorder;  ///< voxels around a stored brick, on each side: 1 or 2
  /// Voxel space (voxel i covers [i, i+1]) to world space.
  Affine3 voxel_to_world;
  std::optional<Box3d> bounds = {};  ///< in voxel space, of what is not empty; none where that is not known
  std::string source;                ///< the name of the file it was built from

  /// Numbers of one plane of a brick with such a border.
  std::size_t texels(std::uint32_t border_voxels) const { return plane_texels(shape.m, border_voxels); }
  /// Of a brick with such a border as core/voxel.h lays it out.
  std::size_t brick_bytes(std::uint32_t border_voxels = kBrickBorder) const {
    return gvx::brick_bytes(format, shape.m, border_voxels);
  }
};

}  // namespace gvx::store
