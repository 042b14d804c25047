/// \file
/// SpongeProducer: the Sierpinski (Menger) sponge, by one recursive tile and one brick, as example 2 of the
/// 2008 report and figure 3.27 of the GPU Pro text: every solid child of the root is the root again.
#pragma once

#include "gvx/produce/producer.h"

namespace gvx::produce {

/// N = 3. Stored values are coverage, 0 to 255; the cube is one world unit wide.
class SpongeProducer final : public Producer {
 public:
  static constexpr std::uint32_t kMaxLevel = kMaxLevels - 1;

  /// `stored`: every node has its own children and brick, as a volume's would.
  enum class Nodes { shared, stored };

  explicit SpongeProducer(std::uint32_t m = 16, Nodes nodes = Nodes::shared);

  /// Is the child (x, y, z) of a sponge, each 0 to 2, part of it? It is not where two or more coordinates
  /// are 1.
  static bool solid(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    return (x == 1) + (y == 1) + (z == 1) < 2;
  }

  const TreeDescription& description() const override { return description_; }
  NodeKey canonical(const NodeKey& key) const override;
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;

 private:
  Nodes nodes_;
  TreeDescription description_;
};

}  // namespace gvx::produce
