/// \file
/// The .gvx store on disk, version 2. docs/store-format.md is the specification; these structs are its bytes.
///
///     offset 0     FileHeader, 256 bytes, little-endian, written last
///     256 ..       bricks, laid out as core/voxel.h draws them, each compressed on its own,
///                  and between them index pages, each 8^3 NodeRecords, compressed
///     directory    a PageEntry for every page of every level: level 0 first, then x fastest
///     metadata     JSON: the source's name, its orientation's meaning, the histogram
///
/// To sample a voxel: header -> directory entry of the node's page -> page -> NodeRecord -> brick. Each step
/// is one range of bytes, so a store is read piecewise from a disk or by HTTP ranges.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/node_key.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"

namespace gvx::store {

static_assert(std::endian::native == std::endian::little, "the store's structs are its bytes");

inline constexpr std::array<char, 8> kMagic = {'G', 'V', 'X', 'S', 'T', 'O', 'R', 'E'};
inline constexpr std::uint32_t kVersion = 2;
/// Nodes along an edge of an index page.
inline constexpr std::uint32_t kPageEdge = 8;
inline constexpr std::uint32_t kPageNodes = kPageEdge * kPageEdge * kPageEdge;

/// Bins of a channel's histogram.
inline constexpr std::size_t kHistogramBins = 1024;

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
  ValueRange range;  ///< of all stored values of the first channel
  std::uint64_t directory_offset, directory_bytes, directory_checksum;
  std::uint64_t metadata_offset, metadata_bytes, metadata_checksum;
  std::uint64_t file_bytes;
  std::uint32_t content;          ///< VoxelContent
  std::uint32_t planes;           ///< numbers a voxel
  std::uint64_t header_checksum;  ///< of the bytes before it
};
static_assert(sizeof(FileHeader) == 256);

/// What the index says of one node. Its ranges hold the voxels of its brick, of all bricks below it, and of a
/// rim of n voxels around each: so also whatever the coarser level, blended in, can show within the node.
/// Colour voxels have the range of their opacity there, from 0.
struct NodeRecord {
  std::uint64_t offset;    ///< of its compressed brick in the file
  std::uint32_t bytes;     ///< of its compressed brick; 0: all of the node is ranges.at_minimum()
  std::uint32_t checksum;  ///< of the compressed brick
  ChannelRanges ranges;

  bool constant() const { return bytes == 0; }
};
static_assert(sizeof(NodeRecord) == 48);

/// Where an index page is.
struct PageEntry {
  std::uint64_t offset;
  std::uint32_t bytes;
  std::uint32_t checksum;
};
static_assert(sizeof(PageEntry) == 16);

/// XXH3, 64 bits; where a field has 32, its low half.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// a * b, or the greatest number there is: sizes that come from files may be absurd.
inline std::uint64_t saturating_product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}

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
  /// Index pages of a level.
  Vec3i level_pages(std::uint32_t level) const;
  /// Index pages of all levels before this one; the greatest number there is where they are more.
  std::uint64_t pages_before(std::uint32_t level) const;
  /// Does the node hold voxels of the volume?
  bool contains(const NodeKey& key) const;
  /// Nodes of all levels.
  std::uint64_t nodes() const;
  /// Voxels along the edge of the tree's cube at the finest level: m * n^(levels-1).
  double cube_voxels() const { return m * nodes_across(static_cast<int>(n), levels - 1); }
};

/// What a store says of its volume.
struct VolumeInfo {
  TreeShape shape;
  VoxelFormat format;
  Codec codec = Codec::zstd;
  /// Voxel space (voxel i covers [i, i+1]) to world space; millimetres, x right, y anterior, z superior if
  /// anatomical.
  Affine3 voxel_to_world;
  bool anatomical = false;
  double scale = 1, offset = 0;  ///< physical value = scale * stored value + offset
  ChannelRanges ranges;          ///< of all stored values
  std::string source;            ///< the name of the file it was built from
  /// Of each channel: voxels of the finest level in equal bins over its range.
  std::vector<std::vector<std::uint64_t>> histograms;

  std::size_t brick_bytes() const { return gvx::brick_bytes(format, shape.m); }
};

}  // namespace gvx::store
