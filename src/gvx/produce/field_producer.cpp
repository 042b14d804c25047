#include "gvx/produce/field_producer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace gvx::produce {
namespace {

/// What a value is stored as.
template <typename Voxel>
Voxel stored(float value, const TreeDescription& tree) {
  if constexpr (std::is_same_v<Voxel, float>) {
    return static_cast<float>((value - tree.offset) / tree.scale);
  } else {
    const double v = std::floor((value - tree.offset) / tree.scale + 0.5);
    // What is no number is the least.
    return static_cast<Voxel>(std::fmin(std::fmax(v, 0.0), double(std::numeric_limits<Voxel>::max())));
  }
}

TreeDescription as_floats(TreeDescription description) {
  description.format = {VoxelType::f32, VoxelContent::scalar, 1};
  return description;
}

}  // namespace

FieldProducer::FieldProducer(TreeDescription description, std::shared_ptr<const Field> field)
    : description_(std::move(description)), field_(std::move(field)) {
  GVX_CHECK(description_.format.content == VoxelContent::scalar && description_.format.planes == 1 &&
            description_.scale > 0);
  description_.ranges = stored_bounds(NodeKey{});
}

FieldProducer::FieldProducer(TreeDescription description, FunctionField::Values values,
                             FunctionField::Bounds bounds)
    : FieldProducer(as_floats(std::move(description)),
                    std::make_shared<FunctionField>(std::move(values), std::move(bounds))) {}

/// Of a node with a rim of n voxels; its coarsest voxels are those of the level above, which is blended in.
ValueRange FieldProducer::stored_bounds(const NodeKey& key) const {
  const double n = description_.n, across = nodes_across(static_cast<int>(description_.n), key.level),
               rim = n / (across * description_.m);
  const Vec3d low = corner(key) / across;
  const ValueRange range = field_->bounds({low - Vec3d(rim), low + Vec3d(1 / across + rim)}, rim);
  return with_voxel_type(description_.format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    // To store never changes the order of two values.
    return ValueRange{static_cast<float>(stored<Voxel>(range.minimum, description_)),
                      static_cast<float>(stored<Voxel>(range.maximum, description_))};
  });
}

Status FieldProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    infos[i] = {stored_bounds(keys[i]), keys[i].level == description_.max_level};
  }
  return {};
}

Status FieldProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  const double m = description_.m,
               voxel = 1 / (nodes_across(static_cast<int>(description_.n), key.level) * m);
  const VoxelBlock block{voxel * (m * corner(key) - Vec3d(0.5)), voxel, description_.m + 2};
  thread_local std::vector<float> values;
  values.resize(block.voxels());
  field_->sample(block, values);
  with_voxel_type(description_.format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    auto* out = reinterpret_cast<Voxel*>(voxels.data());
    std::transform(values.begin(), values.end(), out,
                   [&](float value) { return stored<Voxel>(value, description_); });
  });
  return {};
}

}  // namespace gvx::produce
