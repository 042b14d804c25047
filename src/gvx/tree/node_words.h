/// \file
/// The words of a node (GPU Pro text, 3.4.2), in separate arrays since a descent needs only the first:
///
///     child     31 terminal | 30 unused | 29..0 tile of its N^3 children, 0 for none
///     content   31..30 kind: none, constant, brick | 29..0 slot of its brick
///     range     least and greatest value of everything below, of each channel; of a constant node both are
///     its value
///
/// *Terminal*: there is nothing finer. What a viewer cannot see of a tree is the viewer's to know
/// (hidden_nodes.h).
#pragma once

#include <cstdint>

#include "gvx/core/index.h"
#include "gvx/core/macros.h"

namespace gvx::tree {

inline constexpr std::uint32_t kTerminalBit = 1u << 31;
inline constexpr std::uint32_t kPointerMask = (1u << 30) - 1;

enum class ContentKind : std::uint32_t { none = 0, constant = 1, brick = 2 };

struct ChildWord {
  std::uint32_t bits = 0;

  GVX_HD bool terminal() const { return (bits & kTerminalBit) != 0; }
  GVX_HD bool has_children() const { return (bits & kPointerMask) != 0; }
  GVX_HD TileIndex children() const { return TileIndex(bits & kPointerMask); }
};

struct ContentWord {
  std::uint32_t bits = 0;

  GVX_HD ContentKind kind() const { return static_cast<ContentKind>(bits >> 30); }
  GVX_HD BrickIndex brick() const { return BrickIndex(bits & kPointerMask); }
  GVX_HD static ContentWord of_brick(BrickIndex brick) {
    return {static_cast<std::uint32_t>(ContentKind::brick) << 30 | brick.value};
  }
  GVX_HD static ContentWord constant() { return {static_cast<std::uint32_t>(ContentKind::constant) << 30}; }
};

}  // namespace gvx::tree
