#include "gvx/produce/sponge_producer.h"

#include <algorithm>

#include "gvx/produce/check_arguments.h"

namespace gvx::produce {
namespace {

// What voxels resolve of the sponge: its first generation, 3 cells across, sampled with 4^3 points a voxel.
// More would be detail as fine as pixels, whose gradients are noise.
constexpr int kGenerations = 1;
constexpr int kSamples = 4;

/// The node that stands for every hole: the middle of the root.
constexpr NodeKey kHole{1, 1, 1, 1};

bool inside(double x, double y, double z) {
  for (int g = 0; g < kGenerations; ++g) {
    x *= 3, y *= 3, z *= 3;
    const auto ix = static_cast<int>(x), iy = static_cast<int>(y), iz = static_cast<int>(z);
    if (!SpongeProducer::solid(std::uint64_t(ix), std::uint64_t(iy), std::uint64_t(iz))) return false;
    x -= ix, y -= iy, z -= iz;
  }
  return true;
}

/// The node that a node is the same as: the root, or kHole where it is in a hole.
NodeKey same_as(const NodeKey& key) {
  for (NodeKey k = key; k.level > 0; k = parent(k, 3)) {
    if (!SpongeProducer::solid(k.x % 3, k.y % 3, k.z % 3)) return kHole;
  }
  return {};
}

}  // namespace

SpongeProducer::SpongeProducer(std::uint32_t m, Nodes nodes) : nodes_(nodes) {
  description_.n = 3;
  description_.m = m;
  description_.max_level = kMaxLevel;
  description_.ranges = ValueRange{0, 255};
  if (nodes == Nodes::shared) description_.bricks = 1;
}

NodeKey SpongeProducer::canonical(const NodeKey& key) const {
  return nodes_ == Nodes::shared ? same_as(key) : key;
}

Status SpongeProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const bool finest = nodes_ == Nodes::stored && keys[i].level == kMaxLevel;
    infos[i] = same_as(keys[i]) == kHole ? tree::NodeInfo{ValueRange{0, 0}, true}
                                         : tree::NodeInfo{ValueRange{0, 255}, finest};
  }
  return {};
}

Status SpongeProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  GVX_TRY(check_brick(description_, voxels));
  if (same_as(key) == kHole) return Error{"sponge: the node is a hole, which has no brick"};
  const int m = static_cast<int>(description_.m);
  // What is beyond the brick depends on which of its places it stands in. It is taken as empty, so that faces
  // have a gradient; where the neighbour is solid too, coverage falls to a half on the shared face, which is
  // solid still.
  const auto coverage = [&](int x, int y, int z) {
    if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= m) return std::byte{0};
    int hits = 0;
    for (int s = 0; s < kSamples * kSamples * kSamples; ++s) {
      const auto at = [&](int voxel, int sample) { return (voxel + (sample + 0.5) / kSamples) / m; };
      hits +=
          inside(at(x, s % kSamples), at(y, s / kSamples % kSamples), at(z, s / kSamples / kSamples)) ? 1 : 0;
    }
    return static_cast<std::byte>(hits * 255 / (kSamples * kSamples * kSamples));
  };
  std::size_t i = 0;
  for (int z = -kBrickBorder; z < m + kBrickBorder; ++z) {
    for (int y = -kBrickBorder; y < m + kBrickBorder; ++y) {
      for (int x = -kBrickBorder; x < m + kBrickBorder; ++x) voxels[i++] = coverage(x, y, z);
    }
  }
  return {};
}

}  // namespace gvx::produce
