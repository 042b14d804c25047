/// \file
/// KernelProducer: makes bricks and bounds with kernels, on a GPU or on the threads of a CPU (the GPU
/// producers of the 2008 report). Only for source files that are compiled as CUDA where there is a GPU.
#pragma once

#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "gvx/exec/for_each.h"
#include "gvx/exec/relaxed.h"
#include "gvx/produce/check_arguments.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/stored_value.h"

namespace gvx::produce {

/// Kernel: computes the voxels of a batch of bricks.
template <typename Voxel, typename Kernel>
struct FillBricks {
  Kernel kernel;
  StoredValue stored;
  exec::BufferView<const VoxelBlock> blocks;  ///< of the bricks
  std::byte* bytes;
  std::size_t brick_bytes;

  GVX_HD void operator()(std::size_t i) const {
    const std::size_t edge = blocks[0].edge, row = i / edge, slice = row / edge, brick = slice / edge;
    const VoxelBlock& block = blocks[brick];
    const Vec3d place(double(i % edge), double(row % edge), double(slice % edge));
    const Vec3d centre = block.first + block.spacing * place;
    auto* voxels = reinterpret_cast<Voxel*>(bytes + brick * brick_bytes);
    voxels[i - brick * edge * edge * edge] = stored.template of<Voxel>(kernel.value(centre, block.spacing));
  }
};

/// Kernel: finds the bricks that have more than one value.
template <typename Voxel>
struct FindChanges {
  std::size_t texels;
  const std::byte* bytes;
  std::size_t brick_bytes;
  exec::BufferView<std::uint32_t> changes;  ///< set to 1 for these bricks

  GVX_HD void operator()(std::size_t i) const {
    const std::size_t brick = i / texels;
    const auto* voxels = reinterpret_cast<const Voxel*>(bytes + brick * brick_bytes);
    if (voxels[i % texels] != voxels[0]) exec::store_relaxed(&changes[brick], 1);
  }
};

/// Kernel: bounds the values of nodes.
template <typename Kernel>
struct BoundNodes {
  Kernel kernel;
  std::uint32_t n, m;
  exec::BufferView<const NodeKey> keys;
  exec::BufferView<ValueRange> ranges;

  GVX_HD void operator()(std::size_t i) const {
    const NodeBounds node(keys[i], n, m);
    ranges[i] = kernel.bounds(node.box, node.coarsest_spacing);
  }
};

/// `Kernel` is a trivially copyable functor over views, with
///
///     GVX_HD float value(Vec3d centre, double spacing) const;  // of a voxel in tree space
///     GVX_HD ValueRange bounds(const Box3d& box, double coarsest_spacing) const;  // as Field::bounds
///
/// Bricks are made in batches in the device's memory. Kernels also find the constant ones there. So bricks
/// get to the brick pool without a copy on the host.
template <typename Kernel>
class KernelProducer final : public Producer {
 public:
  /// `description` is that of FieldProducer, and what it refuses is. `owner` keeps the memory alive to which
  /// the kernel's views point.
  KernelProducer(const exec::Device& device, TreeDescription description, const Kernel& kernel,
                 std::shared_ptr<const void> owner)
      : device_(device), description_(std::move(description)), kernel_(kernel), owner_(std::move(owner)) {
    const NodeKey root;
    tree::NodeInfo info;
    if (describe(std::span(&root, 1), std::span(&info, 1)).ok()) description_.ranges = info.ranges;
  }

  const TreeDescription& description() const override { return description_; }

  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    GVX_TRY(check_scalar_tree(description_));
    exec::Buffer<NodeKey> nodes(device_, keys.size());
    exec::Buffer<ValueRange> ranges(device_, keys.size());
    nodes.write(0, keys);
    exec::for_each(device_, "bound_nodes", keys.size(),
                   BoundNodes<Kernel>{kernel_, description_.n, description_.m, std::as_const(nodes).view(),
                                      ranges.view()});
    for (std::size_t i = 0; i < keys.size(); ++i) {
      infos[i] = {stored_range(ranges.view()[i], description_), keys[i].level == description_.max_level};
    }
    return {};
  }

  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    GVX_TRY(check_brick(description_, voxels));
    exec::Buffer<std::byte> brick(device_, description_.brick_bytes());
    std::optional<ChannelRanges> constant;
    GVX_TRY(produce_batch({std::span(&key, 1), {brick.view().data, brick.size()}, std::span(&constant, 1)}));
    std::memcpy(voxels.data(), brick.view().data, brick.size());
    return {};
  }

  /// 64 bricks with m = 16 have about 500,000 voxels, twice the threads that a large GPU runs at once (132
  /// times 2048).
  Batching batching() const override { return {64, device_}; }

  Status produce_batch(const BrickBatch& batch) const override {
    GVX_TRY(check_scalar_tree(description_));
    const std::size_t bricks = batch.keys.size(), bytes = description_.brick_bytes();
    const std::size_t texels = plane_texels(description_.m);
    exec::Buffer<VoxelBlock> blocks(device_, bricks);
    exec::Buffer<std::uint32_t> changes(device_, bricks);
    for (std::size_t i = 0; i < bricks; ++i) {
      blocks.view()[i] = block_of(batch.keys[i], description_.n, description_.m);
    }
    with_voxel_type(description_.format.type, [&](auto zero) {
      using Voxel = decltype(zero);
      exec::for_each(device_, "fill_bricks", bricks * texels,
                     FillBricks<Voxel, Kernel>{kernel_, StoredValue(description_),
                                               std::as_const(blocks).view(), batch.voxels.data(), bytes});
      exec::for_each(device_, "find_changes", bricks * texels,
                     FindChanges<Voxel>{texels, batch.voxels.data(), bytes, changes.view()});
      for (std::size_t i = 0; i < bricks; ++i) {
        if (changes.view()[i] != 0) continue;
        Voxel value;
        std::memcpy(&value, &batch.voxels[i * bytes], sizeof value);
        batch.constants[i] = ValueRange{static_cast<float>(value), static_cast<float>(value)};
      }
    });
    return {};
  }

 private:
  exec::Device device_;
  TreeDescription description_;
  Kernel kernel_;
  std::shared_ptr<const void> owner_;
};

}  // namespace gvx::produce
