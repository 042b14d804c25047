/// \file
/// NodeKey: the name of a node of an N3-tree, independent of where (and whether) it is in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"

namespace gvx {

/// Levels that a tree may have: 3^40 nodes across are as many as NodeKey can name.
inline constexpr int kMaxLevels = 41;

/// Node (x, y, z) of the N^level nodes along each axis of `level`; the root is {0, 0, 0, 0}. 64 bits an axis
/// (the GPU Pro text, 3.6.6, packs its localization code into 10 bits an axis).
struct NodeKey {
  std::uint32_t level = 0;
  std::uint64_t x = 0, y = 0, z = 0;

  constexpr bool operator==(const NodeKey&) const = default;
};

/// Child `index` of N^3, x fastest: index = cx + N*(cy + N*cz).
GVX_HD inline NodeKey child(const NodeKey& parent, int n, int index) {
  const auto nn = static_cast<std::uint64_t>(n);
  const auto i = static_cast<std::uint64_t>(index);
  return {parent.level + 1, parent.x * nn + i % nn, parent.y * nn + i / nn % nn,
          parent.z * nn + i / (nn * nn)};
}

/// The node of the level above that contains this one; not for the root.
GVX_HD inline NodeKey parent(const NodeKey& key, int n) {
  const auto nn = static_cast<std::uint64_t>(n);
  return {key.level - 1, key.x / nn, key.y / nn, key.z / nn};
}

/// The low corner of a node in nodes of its level; exact up to 2^53.
GVX_HD inline Vec3d corner(const NodeKey& key) {
  return {static_cast<double>(key.x), static_cast<double>(key.y), static_cast<double>(key.z)};
}

/// N^level, the number of nodes along an axis; exact up to 2^53.
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
