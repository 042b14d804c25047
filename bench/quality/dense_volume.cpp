#include "dense_volume.h"

#include <cstring>

#include "gvx/exec/parallel.h"
#include "gvx/store/store_reader.h"

namespace gvx::bench {

Result<DenseVolume> DenseVolume::load(const std::string& store_path) {
  GVX_ASSIGN(const auto reader, store::StoreReader::open(store_path));
  const store::VolumeInfo& info = reader->info();
  if (info.format.content != VoxelContent::scalar || info.format.planes != 1) {
    return Error{store_path + ": a volume of one scalar channel was expected"};
  }
  DenseVolume volume;
  volume.dimensions_ = info.shape.dimensions;
  volume.voxel_to_world_ = info.voxel_to_world;
  volume.anatomical_ = info.anatomical;
  const Vec3i size = info.shape.dimensions;
  volume.stride_[1] = size.x + 2 * kRim;
  volume.stride_[2] = volume.stride_[1] * (size.y + 2 * kRim);
  volume.voxels_.resize(static_cast<std::size_t>(volume.stride_[2] * (size.z + 2 * kRim)));

  const std::uint32_t level = info.shape.levels - 1;
  const std::int64_t m = info.shape.m, edge = m + 2 * kBrickBorder;
  const Vec3i nodes = info.shape.level_nodes(level);
  std::vector<std::byte> bytes(info.brick_bytes());
  for (std::int64_t node = 0; node < nodes.x * nodes.y * nodes.z; ++node) {
    const Vec3i n{node % nodes.x, node / nodes.x % nodes.y, node / nodes.x / nodes.y};
    const NodeKey key{level, static_cast<std::uint32_t>(n.x), static_cast<std::uint32_t>(n.y),
                      static_cast<std::uint32_t>(n.z)};
    GVX_ASSIGN(const store::NodeRecord record, reader->node(key));
    GVX_TRY(reader->read_brick(key, record, bytes));
    with_voxel_type(info.format.type, [&](auto v) {
      for (std::int64_t z = 0; z < std::min(m, size.z - n.z * m); ++z) {
        for (std::int64_t y = 0; y < std::min(m, size.y - n.y * m); ++y) {
          for (std::int64_t x = 0; x < std::min(m, size.x - n.x * m); ++x) {
            const auto i = static_cast<std::size_t>(x + kBrickBorder +
                                                    edge * (y + kBrickBorder + edge * (z + kBrickBorder)));
            std::memcpy(&v, &bytes[i * sizeof(v)], sizeof(v));
            volume.at(n.x * m + x, n.y * m + y, n.z * m + z) =
                static_cast<float>(info.scale * static_cast<double>(v) + info.offset);
          }
        }
      }
    });
  }
  for (std::int64_t z = -kRim; z < size.z + kRim; ++z) {
    for (std::int64_t y = -kRim; y < size.y + kRim; ++y) {
      for (std::int64_t x = -kRim; x < size.x + kRim; ++x) {
        const Vec3i inside{std::clamp<std::int64_t>(x, 0, size.x - 1),
                           std::clamp<std::int64_t>(y, 0, size.y - 1),
                           std::clamp<std::int64_t>(z, 0, size.z - 1)};
        volume.at(x, y, z) = volume.at(inside.x, inside.y, inside.z);
      }
    }
  }
  volume.find_ranges();
  return volume;
}

double DenseVolume::spacing() const {
  const Affine3& place = voxel_to_world_;
  return std::min({length(place.column[0]), length(place.column[1]), length(place.column[2])});
}

void DenseVolume::find_ranges() {
  blocks_ = (dimensions_ + Vec3i(kBlock - 1)) / Vec3i(kBlock);
  ranges_.resize(static_cast<std::size_t>(blocks_.x * blocks_.y * blocks_.z));
  exec::parallel_for(exec::Device::cpu(), static_cast<std::size_t>(blocks_.z), [&](std::size_t block_z) {
    const auto bz = static_cast<std::int64_t>(block_z);
    for (std::int64_t by = 0; by < blocks_.y; ++by) {
      for (std::int64_t bx = 0; bx < blocks_.x; ++bx) {
        float least = INFINITY, most = -INFINITY;
        for (std::int64_t z = bz * kBlock - 1; z <= std::min((bz + 1) * kBlock, dimensions_.z); ++z) {
          for (std::int64_t y = by * kBlock - 1; y <= std::min((by + 1) * kBlock, dimensions_.y); ++y) {
            for (std::int64_t x = bx * kBlock - 1; x <= std::min((bx + 1) * kBlock, dimensions_.x); ++x) {
              const float v = at(x, y, z);
              least = std::min(least, v);
              most = std::max(most, v);
            }
          }
        }
        ranges_[block_index({bx, by, bz})] = {least, most};
      }
    }
  });
}

}  // namespace gvx::bench
