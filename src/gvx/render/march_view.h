/// \file
/// From a Pass to the PassView of its voxel type, N and M. Private to this room.
#pragma once

#include <type_traits>

#include "gvx/core/result.h"
#include "gvx/render/march.h"
#include "gvx/render/march_pass.h"

namespace gvx::render {

template <typename Voxel, int N, int M>
PassView<Voxel, N, M> view_of(const Pass& pass) {
  return {pass.frame,
          pass.nodes,
          {pass.bricks, brick_bytes(pass.frame.format, M), pass.frame.format.planes},
          pass.tile_usage,
          pass.brick_usage,
          pass.requests,
          pass.cells,
          pass.number};
}

/// Calls function(PassView) for the pass's N and M.
template <typename Voxel, typename Function>
bool with_view(const Pass& pass, Function function) {
  const auto with_m = [&](auto n) {
    constexpr int N = decltype(n)::value;
    switch (pass.m) {
      case 8:
        return function(view_of<Voxel, N, 8>(pass));
      case 16:
        return function(view_of<Voxel, N, 16>(pass));
      default:
        GVX_CHECK(pass.m == 32);
        return function(view_of<Voxel, N, 32>(pass));
    }
  };
  GVX_CHECK(pass.n == 2 || pass.n == 3);
  return pass.n == 2 ? with_m(std::integral_constant<int, 2>{}) : with_m(std::integral_constant<int, 3>{});
}

}  // namespace gvx::render
