/// \file
/// KernelProducer: bricks and bounds made by kernels, on a GPU or on a CPU's threads (the GPU producers of
/// the 2008 report). For device sources only.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "gvx/exec/for_each.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/stored_value.h"

namespace gvx::produce {

/// A voxel of a brick.
template <typename Voxel, typename Kernel>
struct FillBrick {
  Kernel kernel;
  StoredValue stored;
  Vec3d first;  ///< the centre of the brick's first voxel
  double spacing;
  std::uint32_t edge;
  exec::BufferView<Voxel> voxels;

  GVX_HD void operator()(std::size_t i) const {
    const std::size_t row = i / edge, slice = row / edge;
    const Vec3d place(double(i % edge), double(row % edge), double(slice));
    voxels[i] = stored.template of<Voxel>(kernel.value(first + spacing * place, spacing));
  }
};

/// What bounds a node.
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

/// Kernel: a trivially copyable functor over views, with
///
///     GVX_HD float value(Vec3d centre, double spacing) const;                        of a voxel in tree
///     space GVX_HD ValueRange bounds(const Box3d& box, double coarsest_spacing) const;     of such values
///     (Field::bounds)
template <typename Kernel>
class KernelProducer final : public Producer {
 public:
  /// As FieldProducer's; `owner` keeps what the kernel's views show.
  KernelProducer(const exec::Device& device, TreeDescription description, const Kernel& kernel,
                 std::shared_ptr<const void> owner)
      : device_(device), description_(std::move(description)), kernel_(kernel), owner_(std::move(owner)) {
    const NodeKey root;
    tree::NodeInfo info;
    GVX_CHECK(describe(std::span(&root, 1), std::span(&info, 1)).ok());
    description_.ranges = info.ranges;
  }

  const TreeDescription& description() const override { return description_; }

  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    exec::Buffer<NodeKey> of(device_, keys.size());
    exec::Buffer<ValueRange> ranges(device_, keys.size());
    std::copy(keys.begin(), keys.end(), of.view().begin());
    const exec::BufferView<const NodeKey> nodes{of.view().data, of.size()};
    exec::for_each(device_, "bound_nodes", keys.size(),
                   BoundNodes<Kernel>{kernel_, description_.n, description_.m, nodes, ranges.view()});
    for (std::size_t i = 0; i < keys.size(); ++i) {
      infos[i] = {stored_range(ranges.view()[i], description_), keys[i].level == description_.max_level};
    }
    return {};
  }

  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    const VoxelBlock block = block_of(key, description_.n, description_.m);
    with_voxel_type(description_.format.type, [&](auto zero) {
      using Voxel = decltype(zero);
      exec::Buffer<Voxel> brick(device_, block.voxels());
      exec::for_each(device_, "fill_brick", block.voxels(),
                     FillBrick<Voxel, Kernel>{kernel_, StoredValue(description_), block.first, block.spacing,
                                              block.edge, brick.view()});
      std::memcpy(voxels.data(), brick.view().data, block.voxels() * sizeof(Voxel));
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
