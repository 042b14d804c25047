/// \file
/// From a Pass to the PassView of its voxel type, N and M. Private to this room.
#pragma once

#include <type_traits>

#include "gvx/core/result.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/reference/march.h"

namespace gvx::render {

inline WalkView walk_view_of(const Pass& pass) {
  return {pass.frame, pass.nodes, pass.hidden, pass.tile_usage, pass.brick_usage, pass.requests, pass.number};
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
PassView<Voxel, N, M> view_of(const Pass& pass) {
  return {walk_view_of(pass), {pass.bricks, brick_bytes(pass.frame.format, M), pass.frame.format.planes}};
}

/// Calls function(PassView) for the pass's N and M.
template <typename Voxel, typename Function>
decltype(auto) with_view(const Pass& pass, Function function) {
  return with_children(pass.n, [&](auto n) {
    return with_edge(pass.m, [&](auto m) {
      return function(view_of<Voxel, decltype(n)::value, decltype(m)::value>(pass));
    });
  });
}

}  // namespace gvx::render
