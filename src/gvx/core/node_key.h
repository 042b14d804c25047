/// \file
/// NodeKey: names a node of an N3-tree, a tree in which each node has N*N*N children (N is 2 or 3). The node
/// need not be in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"

namespace gvx {

/// The most levels of a tree. With N = 3 the finest then has 3^40 nodes along each axis; 64 bits hold no
/// more.
inline constexpr int kMaxLevels = 41;

/// The node at (x, y, z) of a level, which has N^level nodes along each axis. The root is {0, 0, 0, 0}. Each
/// axis has 64 bits (the localization code of the GPU Pro text, 3.6.6, has 10).
struct NodeKey {
  std::uint32_t level = 0;
  std::uint64_t x = 0, y = 0, z = 0;

  constexpr bool operator==(const NodeKey&) const = default;
};

/// One of the N^3 children, x fastest: index = cx + N*(cy + N*cz).
GVX_HD inline NodeKey child(const NodeKey& parent, int n, int index) {
  const auto nn = static_cast<std::uint64_t>(n);
  const auto i = static_cast<std::uint64_t>(index);
  return {parent.level + 1, parent.x * nn + i % nn, parent.y * nn + i / nn % nn,
          parent.z * nn + i / (nn * nn)};
}

/// The node of the next coarser level that contains this one. The root has none.
GVX_HD inline NodeKey parent(const NodeKey& key, int n) {
  const auto nn = static_cast<std::uint64_t>(n);
  return {key.level - 1, key.x / nn, key.y / nn, key.z / nn};
}

/// The low corner of a node, in nodes of its level. Exact up to 2^53.
GVX_HD inline Vec3d corner(const NodeKey& key) {
  return {static_cast<double>(key.x), static_cast<double>(key.y), static_cast<double>(key.z)};
}

/// N^level, the number of nodes along an axis. Exact up to 2^53.
GVX_HD inline double nodes_across(int n, std::uint32_t level) {
  double across = 1;
  for (std::uint32_t i = 0; i < level; ++i) across *= n;
  return across;
}

struct NodeKeyHash {
  std::size_t operator()(const NodeKey& key) const {
    std::uint64_t h = 0x9e3779b97f4a7c15ull * (key.level + 1);
    for (const std::uint64_t v : {key.x, key.y, key.z}) {
      h ^= v;
      h *= 0xff51afd7ed558ccdull;
      h ^= h >> 32;
    }
    return static_cast<std::size_t>(h);
  }
};

}  // namespace gvx
