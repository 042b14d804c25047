/// \file
/// Producer: where bricks come from. A producer is asked by NodeKey and never sees a ray. Beside making
/// voxels it is the oracle of the 2008 report: it bounds a node's values before anything is made, so that
/// what cannot be seen is never asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/node_key.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/core/voxel.h"
#include "gvx/exec/device.h"
#include "gvx/tree/node_pool.h"

namespace gvx::produce {

/// The tree that a producer fills, and where it stands in the world. *Tree space* is the cube [0, 1]^3 of the
/// root.
struct TreeDescription {
  std::uint32_t n = 2;          ///< children along an axis of a node: 2 or 3
  std::uint32_t m = 16;         ///< voxels along an axis of a brick, border not counted: 8, 16 or 32
  std::uint32_t max_level = 0;  ///< of the finest nodes
  VoxelFormat format;
  Affine3 tree_to_world;
  Box3d extent{{0, 0, 0}, {1, 1, 1}};  ///< the part of tree space that holds the volume
  /// The part of the extent that is not empty, where that is known: what cameras frame.
  std::optional<Box3d> bounds = {};
  bool anatomical = false;       ///< world is millimetres: x right, y to the front, z up
  UpAxis up = UpAxis::z;         ///< of the world
  double scale = 1, offset = 0;  ///< physical value = scale * stored value + offset
  ChannelRanges ranges;          ///< of all stored values
  float beyond_ranges = 0;       ///< how far voxels that are made may lie outside of these
  bool no_data = false;          ///< f32 voxels may be NaN: no data, which is transparent
  /// Of each channel's voxels, equal bins over its range; may be empty.
  std::vector<std::vector<std::uint64_t>> histograms;
  /// describe() tells the true ranges: no node is found to be constant only when its brick is made.
  bool exact_ranges = false;
  std::uint64_t bricks = 0;  ///< as many bricks as there can be, 0 for no bound: bounds the brick pool

  std::size_t brick_bytes() const { return gvx::brick_bytes(format, m); }
};

/// How long threads have been at parts of production, all of them together.
struct ProductionTimes {
  double reading_milliseconds = 0, decoding_milliseconds = 0;
};

/// Bricks that are made together.
struct BrickBatch {
  std::span<const NodeKey> keys;
  /// Of as many bricks, one after the other, filled with zeros.
  std::span<std::byte> voxels;
  /// For each: a producer that knows says here what value all its voxels have.
  std::span<std::optional<ChannelRanges>> constants;
};

/// How a producer likes its batches.
struct Batching {
  std::size_t most = 1;  ///< bricks in one, and nodes whose children are described
  std::optional<exec::Device> device =
      {};  ///< in whose memory the voxels are; the host's, where none is named
};

/// All calls are thread-safe and are made from several threads at once.
class Producer {
 public:
  virtual ~Producer() = default;

  virtual const TreeDescription& description() const = 0;

  /// The node whose content and sub-tree this node shares; itself in a tree without repetition. Must be a
  /// fixed point: canonical(canonical(key)) == canonical(key). Only canonical nodes are described below and
  /// produced.
  virtual NodeKey canonical(const NodeKey& key) const { return key; }

  /// The oracle: bounds each node's values and those of a rim of n voxels around it, conservatively. Ranges
  /// of one value say that the node is constant.
  virtual Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const = 0;

  /// Fills the brick of a node as core/voxel.h lays it out. `voxels` comes filled with zeros: a producer that
  /// knows no deviations leaves them so.
  virtual Status produce(const NodeKey& key, std::span<std::byte> voxels) const = 0;

  /// The same for many nodes at once, all or none; voxels are where batching() wants them.
  virtual Status produce_batch(const BrickBatch& batch) const {
    const std::size_t bytes = description().brick_bytes();
    for (std::size_t i = 0; i < batch.keys.size(); ++i) {
      GVX_TRY(produce(batch.keys[i], batch.voxels.subspan(i * bytes, bytes)));
    }
    return {};
  }
  virtual Batching batching() const { return {}; }

  /// Bytes read from files or servers so far.
  virtual std::uint64_t bytes_read() const { return 0; }
  /// Since it was opened.
  virtual ProductionTimes times() const { return {}; }
};

}  // namespace gvx::produce
