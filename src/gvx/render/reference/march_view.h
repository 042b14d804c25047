/// \file
/// From an ObjectView to the PassView of its voxel type, N and M. Private to this room.
#pragma once

#include <type_traits>

#include "gvx/core/result.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/reference/march.h"

namespace gvx::render {

inline WalkView walk_view_of(const ObjectView& object, std::uint32_t pass) {
  return {object.frame,       object.nodes,    object.hidden, object.tile_usage,
          object.brick_usage, object.requests, pass};
}

/// Calls function(std::integral_constant<int, M>) for a brick's edge.
template <typename Function>
decltype(auto) with_edge(std::uint32_t m, Function&& function) {
  switch (m) {
    case 8:
      return function(std::integral_constant<int, 8>{});
    case 16:
      return function(std::integral_constant<int, 16>{});
    default:
      GVX_CHECK(m == 32);
      return function(std::integral_constant<int, 32>{});
  }
}

/// Calls function(std::integral_constant<int, N>) for the children along an axis of a node.
template <typename Function>
decltype(auto) with_children(std::uint32_t n, Function&& function) {
  GVX_CHECK(n == 2 || n == 3);
  return n == 2 ? function(std::integral_constant<int, 2>{}) : function(std::integral_constant<int, 3>{});
}

template <typename Voxel, int N, int M>
PassView<Voxel, N, M> view_of(const ObjectView& object, std::uint32_t pass) {
  const VoxelFormat format = object.frame.format;
  return {walk_view_of(object, pass), {object.bricks, brick_bytes(format, M), format.planes}};
}

/// Calls function(PassView) for the object's N and M, in the pass of this number.
template <typename Voxel, typename Function>
decltype(auto) with_view(const ObjectView& object, std::uint32_t pass, Function function) {
  return with_children(object.n, [&](auto n) {
    return with_edge(object.m, [&](auto m) {
      return function(view_of<Voxel, decltype(n)::value, decltype(m)::value>(object, pass));
    });
  });
}

}  // namespace gvx::render
