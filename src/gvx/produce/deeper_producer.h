/// \file
/// DeeperProducer: a producer's tree, said to have more levels than it has. Its nodes are the same; but rays
/// take steps as short as those levels' voxels, for what is added to the values on the way
/// (core/added_noise.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "gvx/produce/check_arguments.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

class DeeperProducer final : public Producer {
 public:
  /// An error where that is more levels than a tree may have, or the tree is null.
  static Result<std::shared_ptr<const DeeperProducer>> create(std::shared_ptr<const Producer> tree,
                                                              std::uint32_t levels) {
    GVX_TRY(check_base(tree, "deeper"));
    const std::uint32_t have = tree->description().max_level + 1;
    if (levels > std::uint32_t{kMaxLevels} - std::min(have, std::uint32_t{kMaxLevels})) {
      return Error{std::to_string(have) + " levels and " + std::to_string(levels) +
                   " more: a tree has at most " + std::to_string(kMaxLevels)};
    }
    return std::shared_ptr<const DeeperProducer>(new DeeperProducer(std::move(tree), levels));
  }

  const TreeDescription& description() const override { return description_; }
  NodeKey canonical(const NodeKey& key) const override { return tree_->canonical(key); }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    return tree_->describe(keys, infos);
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    return tree_->produce(key, voxels);
  }
  Status produce_batch(const BrickBatch& batch) const override { return tree_->produce_batch(batch); }
  Batching batching() const override { return tree_->batching(); }
  void start(const ElementBatch& batch, std::shared_ptr<ElementSink> sink) const override {
    tree_->start(batch, std::move(sink));
  }
  std::size_t most_under_way() const override { return tree_->most_under_way(); }
  std::uint64_t wanted_memory() const override { return tree_->wanted_memory(); }
  void keep_at_most(std::uint64_t bytes) const override { tree_->keep_at_most(bytes); }
  std::uint64_t bytes_read() const override { return tree_->bytes_read(); }
  ProductionTimes times() const override { return tree_->times(); }

 private:
  DeeperProducer(std::shared_ptr<const Producer> tree, std::uint32_t levels)
      : tree_(std::move(tree)), description_(tree_->description()) {
    description_.max_level += levels;
  }

  std::shared_ptr<const Producer> tree_;
  TreeDescription description_;
};

}  // namespace gvx::produce
