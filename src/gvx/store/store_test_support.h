/// \file
/// For tests: a small volume whose every voxel is known, and its store.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "gvx/exec/device.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/store_writer.h"

namespace gvx::store {

/// A volume in memory, x fastest.
template <typename Voxel>
struct TestVolume {
  Vec3i dimensions;
  std::vector<Voxel> voxels;

  template <typename Function>
  TestVolume(Vec3i d, Function value) : dimensions(d) {
    for (std::int64_t z = 0; z < d.z; ++z) {
      for (std::int64_t y = 0; y < d.y; ++y) {
        for (std::int64_t x = 0; x < d.x; ++x) voxels.push_back(static_cast<Voxel>(value(x, y, z)));
      }
    }
  }

  /// The voxel, or the nearest at the volume's faces.
  Voxel at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const auto clamp = [](std::int64_t v, std::int64_t size) { return v < 0 ? 0 : v < size ? v : size - 1; };
    x = clamp(x, dimensions.x), y = clamp(y, dimensions.y), z = clamp(z, dimensions.z);
    return voxels[static_cast<std::size_t>((z * dimensions.y + y) * dimensions.x + x)];
  }
};

template <typename Voxel>
constexpr VoxelType voxel_type_of() {
  return sizeof(Voxel) == 1 ? VoxelType::u8 : sizeof(Voxel) == 2 ? VoxelType::u16 : VoxelType::f32;
}

template <typename Voxel>
Status write_store(const TestVolume<Voxel>& volume, const std::string& path, std::uint32_t n, std::uint32_t m,
                   Codec codec = Codec::zstd, int threads = 2, std::uint32_t border = 1,
                   VoxelContent content = VoxelContent::scalar) {
  VolumeInfo info;
  info.shape = TreeShape::covering(volume.dimensions, n, m);
  info.format.type = voxel_type_of<Voxel>();
  info.format.content = content;
  info.codec = codec;
  info.border = border;
  info.source = "test";
  GVX_ASSIGN(const auto writer, StoreWriter::create(path, info.shape, info.format));
  PyramidBuilder builder(exec::Device::cpu(threads), *writer, info);
  GVX_TRY(builder.push_slices(volume.dimensions.z, std::as_bytes(std::span(volume.voxels))));
  return builder.finish();
}

}  // namespace gvx::store
