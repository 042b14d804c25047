/// \file
/// RepeatProducer: a volume many times along each axis, which costs what one costs: all copies share its
/// sub-tree and its bricks (example 1 of the 2008 report, which made 8192^3 out of 1024^3 so).
#pragma once

#include <memory>

#include "gvx/produce/producer.h"

namespace gvx::produce {

/// Each copy ends at the faces of its cube; levels above the copies are made by averaging.
class RepeatProducer final : public Producer {
 public:
  /// n^levels copies along each axis, n being that of the volume's tree: 2, since bricks must be cut into as
  /// many parts. An error where they would be more nodes than a key can name.
  static Result<std::shared_ptr<const RepeatProducer>> create(std::shared_ptr<const Producer> volume,
                                                              std::uint32_t levels);

  const TreeDescription& description() const override { return description_; }
  NodeKey canonical(const NodeKey& key) const override;
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;
  std::uint64_t wanted_memory() const override { return volume_->wanted_memory(); }
  void keep_at_most(std::uint64_t bytes) const override { volume_->keep_at_most(bytes); }
  std::uint64_t bytes_read() const override { return volume_->bytes_read(); }
  ProductionTimes times() const override { return volume_->times(); }

 private:
  RepeatProducer(std::shared_ptr<const Producer> volume, std::uint32_t levels);
  NodeKey in_volume(const NodeKey& key) const;
  void average(std::span<const std::byte> root, std::uint32_t level, std::span<std::byte> voxels) const;

  std::shared_ptr<const Producer> volume_;
  std::uint32_t levels_;
  TreeDescription description_;
};

}  // namespace gvx::produce
