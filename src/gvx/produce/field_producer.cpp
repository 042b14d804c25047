#include "gvx/produce/field_producer.h"

#include <cstring>

namespace gvx::produce {

FieldProducer::FieldProducer(TreeDescription description, Values values, Bounds bounds)
    : description_(std::move(description)), values_(std::move(values)), bounds_(std::move(bounds)) {
  description_.format = {VoxelType::f32, VoxelContent::scalar, 1};
  description_.ranges = bounds_(bordered_box(NodeKey{}));
}

Box3d FieldProducer::bordered_box(const NodeKey& key) const {
  const double across = nodes_across(static_cast<int>(description_.n), key.level),
               border = static_cast<double>(description_.n) / (across * description_.m);
  const Vec3d low = Vec3d(key.x, key.y, key.z) / across;
  return {low - Vec3d(border), low + Vec3d(1 / across + border)};
}

Status FieldProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    infos[i] = {bounds_(bordered_box(keys[i])), keys[i].level == description_.max_level};
  }
  return {};
}

Status FieldProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  const int m = static_cast<int>(description_.m);
  const double voxel = 1.0 / (nodes_across(static_cast<int>(description_.n), key.level) * m);
  const Vec3d low = Vec3d(key.x, key.y, key.z) * (voxel * m);
  std::size_t offset = 0;
  for (int z = -1; z <= m; ++z) {
    for (int y = -1; y <= m; ++y) {
      for (int x = -1; x <= m; ++x, offset += sizeof(float)) {
        const float value = values_(low + voxel * Vec3d(x + 0.5, y + 0.5, z + 0.5));
        std::memcpy(&voxels[offset], &value, sizeof(float));
      }
    }
  }
  return {};
}

}  // namespace gvx::produce
