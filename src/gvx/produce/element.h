/// \file
/// Elements: what producers make, and how each is named. An element belongs to a node of a tree: its brick,
/// or the descriptions of its children.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/index.h"
#include "gvx/core/node_key.h"
#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/tree/node_pool.h"

namespace gvx::produce {

/// One of the trees whose elements are made; no two have the same.
using TreeId = Index<struct TreeTag>;

/// Of a volume: a brick, or the descriptions of a node's children. Of a surface (surface/surface_format.h): a
/// page of nodes, or a piece of a brick; x of their NodeKey is the place of the page or node in its level.
enum class ElementKind : std::uint32_t {
  brick,
  children,
  surface_nodes,
  surface_geometry,
  surface_attributes,
  surface_triangles
};
inline constexpr bool of_surface(ElementKind kind) {
  return kind >= ElementKind::surface_nodes;
}

/// The brick of a canonical node, or its N^3 children; or an element of a surface.
struct ElementKey {
  TreeId tree;
  NodeKey node;
  ElementKind kind = ElementKind::brick;

  constexpr bool operator==(const ElementKey&) const = default;
};

struct ElementKeyHash {
  std::size_t operator()(const ElementKey& key) const {
    constexpr std::size_t kOdd = 0x9e3779b97f4a7c15ull;
    return NodeKeyHash{}(key.node) + kOdd * (8 * std::size_t{key.tree.value} + std::size_t(key.kind));
  }
};

/// For messages: "the brick of node (1, 2, 3) of level 4".
inline std::string name_of(const NodeKey& node, ElementKind kind) {
  if (of_surface(kind)) {
    constexpr const char* kNames[] = {"page of nodes ", "geometry ", "attributes ", "triangles "};
    return kNames[std::size_t(kind) - std::size_t(ElementKind::surface_nodes)] + std::to_string(node.x) +
           " of level " + std::to_string(node.level) + " of a surface";
  }
  return std::string(kind == ElementKind::brick ? "the brick" : "the children") + " of node (" +
         std::to_string(node.x) + ", " + std::to_string(node.y) + ", " + std::to_string(node.z) +
         ") of level " + std::to_string(node.level);
}

/// What a producer makes. The members of the other kind stay empty.
struct Element {
  std::span<const std::byte> voxels;   ///< of a brick; core/voxel.h draws its bytes
  std::shared_ptr<const void> memory;  ///< that holds the voxels
  /// The one value of all of a brick's voxels, if the producer knows that there is but one.
  std::optional<ChannelRanges> constant;
  /// Of all values of a brick of scalars, border and all: examine_element() finds it.
  std::optional<ChannelRanges> found;
  std::shared_ptr<const std::vector<std::byte>> bytes;  ///< of an element of a surface
  std::vector<NodeKey> child_keys;                      ///< of children: canonical, N^3 of them
  std::vector<tree::NodeInfo> children;                 ///< of children: their descriptions
};

}  // namespace gvx::produce
