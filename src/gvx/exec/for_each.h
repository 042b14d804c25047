/// \file
/// for_each: the one way to launch a kernel. A kernel is a functor over views; its name appears in errors.
/// Include this from device sources only: compiled as C++ it knows the CPU, compiled as CUDA both devices.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/exec/parallel.h"
#include "gvx/exec/tile_grid.h"

#if defined(__CUDACC__)
#include <cuda_runtime.h>
#endif

namespace gvx::exec {

#if defined(__CUDACC__)
namespace detail {

template <typename Functor>
__global__ void count_kernel(std::size_t count, Functor functor) {
  const std::size_t i = blockIdx.x * std::size_t(blockDim.x) + threadIdx.x;
  if (i < count) functor(i);
}

/// So many of a tile's pixels are a thread block's: more blocks than tiles keep a GPU busy.
constexpr std::uint32_t kBlockPixels = 1024;

template <typename Functor>
__global__ void tile_kernel(TileGrid grid, const std::uint32_t* tiles, Functor functor) {
  const std::uint32_t tile_x = tiles[blockIdx.x] % grid.tiles_x(),
                      tile_y = tiles[blockIdx.x] / grid.tiles_x();
  const std::uint32_t first = blockIdx.y * kBlockPixels, pixels = grid.tile * grid.tile;
  const std::uint32_t end = first + kBlockPixels < pixels ? first + kBlockPixels : pixels;
  for (std::uint32_t i = first + threadIdx.x; i < end; i += blockDim.x) {
    const std::uint32_t x = tile_x * grid.tile + i % grid.tile, y = tile_y * grid.tile + i / grid.tile;
    if (x < grid.width && y < grid.height) functor(x, y);
  }
}

}  // namespace detail
#endif

/// Calls functor(i) for every i below `count`, in any order, and waits.
template <typename Functor>
void for_each(const Device& device, [[maybe_unused]] const char* name, std::size_t count, Functor functor) {
  if (count == 0) return;
#if defined(__CUDACC__)
  if (device.kind() == DeviceKind::cuda) {
    const auto blocks = static_cast<unsigned>((count + 255) / 256);
    detail::count_kernel<<<blocks, 256>>>(count, functor);
    cuda_support::synchronize(name);
    return;
  }
#endif
  constexpr std::size_t kPiece = 256;
  parallel_for(device, (count + kPiece - 1) / kPiece, [&](std::size_t piece) {
    const std::size_t end = (piece + 1) * kPiece < count ? (piece + 1) * kPiece : count;
    for (std::size_t i = piece * kPiece; i != end; ++i) functor(i);
  });
}

/// for_each_pixel on a CPU.
template <typename Functor>
bool for_each_pixel_on_cpu(const Device& cpu, TileGrid grid, BufferView<const std::uint32_t> tiles,
                           Deadline deadline, Functor functor) {
  std::atomic<bool> all_done{true};
  parallel_for(cpu, tiles.size, [&](std::size_t t) {
    const std::uint32_t x0 = tiles[t] % grid.tiles_x() * grid.tile,
                        y0 = tiles[t] / grid.tiles_x() * grid.tile;
    const std::uint32_t x1 = x0 + grid.tile < grid.width ? x0 + grid.tile : grid.width;
    const std::uint32_t y1 = y0 + grid.tile < grid.height ? y0 + grid.tile : grid.height;
    for (std::uint32_t y = y0; y < y1; ++y) {
      if (late(deadline)) {
        all_done.store(false, std::memory_order_relaxed);
        return;
      }
      for (std::uint32_t x = x0; x < x1; ++x) functor(x, y);
    }
  });
  return all_done.load();
}

/// Calls functor(x, y) for every pixel of the listed tiles, a tile at a time (on CUDA a thread block for each
/// part of a tile), and waits. Rows of tiles that have not begun at the deadline are left out; returns
/// whether all were done.
template <typename Functor>
bool for_each_pixel(const Device& device, [[maybe_unused]] const char* name, TileGrid grid,
                    BufferView<const std::uint32_t> tiles, Deadline deadline, Functor functor) {
#if defined(__CUDACC__)
  if (device.kind() == DeviceKind::cuda) {
    // A band of tiles is the unit that a deadline can stop between; without one all are launched at once.
    constexpr std::size_t kBandPixels = 512 * detail::kBlockPixels;
    const std::size_t pixels = std::size_t(grid.tile) * grid.tile;
    const std::size_t band = deadline == no_deadline() ? tiles.size : (kBandPixels + pixels - 1) / pixels;
    const auto parts = static_cast<unsigned>((pixels + detail::kBlockPixels - 1) / detail::kBlockPixels);
    for (std::size_t first = 0; first < tiles.size; first += band) {
      if (late(deadline)) return false;
      const std::size_t count = band < tiles.size - first ? band : tiles.size - first;
      const dim3 blocks(static_cast<unsigned>(count), parts);
      detail::tile_kernel<<<blocks, 256>>>(grid, tiles.data + first, functor);
      cuda_support::synchronize(name);
    }
    return true;
  }
#endif
  return for_each_pixel_on_cpu(device, grid, tiles, deadline, functor);
}

}  // namespace gvx::exec
