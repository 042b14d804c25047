/// \file
/// SpongeProducer: the Sierpinski (Menger) sponge, by one recursive tile and one brick, as example 2 of the
/// 2008 report and figure 3.27 of the GPU Pro text: every solid child of the root is the root again.
#pragma once

#include "gvx/produce/producer.h"

namespace gvx::produce {

/// N = 3. Stored values are coverage, 0 to 255; the cube is one world unit wide.
class SpongeProducer final : public Producer {
 public:
  /// The finest level: 3^20 nodes across are as many as NodeKey can name.
  static constexpr std::uint32_t kMaxLevel = 20;

  explicit SpongeProducer(std::uint32_t m = 16);

  /// Is the child (x, y, z) of a sponge, each 0 to 2, part of it? It is not where two or more coordinates
  /// are 1.
  static bool solid(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (x == 1) + (y == 1) + (z == 1) < 2;
  }

  const TreeDescription& description() const override { return description_; }
  NodeKey canonical(const NodeKey& key) const override;
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;

 private:
  TreeDescription description_;
};

}  // namespace gvx::produce
