/// \file
/// Producer: provides the bricks of a volume. A brick is a small cube of voxels, the content of a node; the
/// nodes form a tree, in which children are finer than their parent. A producer makes the brick of a NodeKey.
/// It is also the oracle of the 2008 report: it bounds a node's values before its brick is made, so that
/// invisible bricks are never made. docs/write-a-producer.md is a tutorial.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
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
#include "gvx/produce/element_sink.h"
#include "gvx/tree/node_pool.h"
#include "gvx/tree/tree_description.h"

namespace gvx::produce {

using tree::TreeDescription;

/// How long parts of production took, summed over all threads.
struct ProductionTimes {
  double reading_milliseconds = 0, decoding_milliseconds = 0;
};

/// Bricks that are made together.
struct BrickBatch {
  std::span<const NodeKey> keys;
  /// The bricks' bytes, one brick after the other, filled with zeros.
  std::span<std::byte> voxels;
  /// For each brick: its value, if the producer knows that all voxels have the same.
  std::span<std::optional<ChannelRanges>> constants;
};

/// How a producer wants its batches.
struct Batching {
  std::size_t most = 1;  ///< bricks at once; also nodes whose children are described at once
  std::optional<exec::Device> device = {};  ///< whose memory holds the voxels; none: the host's
};

/// All functions are called from several threads at once.
class Producer {
 public:
  virtual ~Producer() = default;

  virtual const TreeDescription& description() const = 0;

  /// For trees with parts that repeat: of all nodes with the same content and sub-tree, the one that stands
  /// for them. canonical(canonical(key)) must equal canonical(key). Only canonical nodes are described and
  /// produced. It reads nothing, as renderers call it between frames.
  virtual NodeKey canonical(const NodeKey& key) const { return key; }

  /// The oracle: bounds the values of each node, of all nodes below it, and of a rim of n voxels around it.
  /// Bounds that are too narrow cut holes into pictures; bounds that are too wide cost time. Bounds of a
  /// single value: the node is constant.
  virtual Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const = 0;

  /// Fills the brick of a node; core/voxel.h draws its bytes. `voxels` is filled with zeros before. A
  /// producer that knows no deviations leaves these as they are.
  virtual Status produce(const NodeKey& key, std::span<std::byte> voxels) const = 0;

  /// The same for several nodes at once. The memory is that of batching(). It succeeds or fails as a whole.
  virtual Status produce_batch(const BrickBatch& batch) const {
    const std::size_t bytes = description().brick_bytes();
    for (std::size_t i = 0; i < batch.keys.size(); ++i) {
      GVX_TRY(produce(batch.keys[i], batch.voxels.subspan(i * bytes, bytes)));
    }
    return {};
  }
  /// How many bricks produce_batch() gets at most, and in which device's memory.
  virtual Batching batching() const { return {}; }

  /// Starts to make elements; at most batching().most of them. Every element is handed over to the sink,
  /// now or later, from any thread. `batch` is valid during the call only. Later, the producer may be gone
  /// before its sinks are. By default, all are made before the call returns.
  virtual void start(const ElementBatch& batch, std::shared_ptr<ElementSink> sink) const;
  /// How many batches may be under way at once; 0: as many as threads make elements.
  virtual std::size_t most_under_way() const { return 0; }

  /// How many bytes it would keep in memory for itself, such as a file's index.
  virtual std::uint64_t wanted_memory() const { return 0; }
  /// It may keep so many, at most, from now on. They count as memory of the cache that says so.
  virtual void keep_at_most([[maybe_unused]] std::uint64_t bytes) const {}

  /// Bytes read from files or servers so far.
  virtual std::uint64_t bytes_read() const { return 0; }
  /// Times since the producer was opened.
  virtual ProductionTimes times() const { return {}; }
};

/// Are the voxels that it makes in the host's memory?
bool makes_host_memory(const Producer& producer);

}  // namespace gvx::produce
