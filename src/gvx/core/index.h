/// \file
/// Indices that must not be mixed up are types: a NodeIndex is no BrickIndex.
#pragma once

#include <cstdint>

#include "gvx/core/macros.h"

namespace gvx {

/// A 32-bit index into the pool that Tag names.
template <typename Tag>
struct Index {
  std::uint32_t value = 0;

  Index() = default;
  GVX_HD constexpr explicit Index(std::uint32_t v) : value(v) {}
  constexpr bool operator==(const Index&) const = default;
};

/// A node of a NodePool: tile * N^3 + child.
using NodeIndex = Index<struct NodeTag>;
/// A tile of N^3 sibling nodes of a NodePool.
using TileIndex = Index<struct TileTag>;
/// A slot of a BrickPool.
using BrickIndex = Index<struct BrickTag>;

}  // namespace gvx
