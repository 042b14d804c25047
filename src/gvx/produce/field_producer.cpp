#include "gvx/produce/field_producer.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "gvx/produce/stored_value.h"

namespace gvx::produce {
namespace {

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

ValueRange FieldProducer::stored_bounds(const NodeKey& key) const {
  const NodeBounds node(key, description_.n, description_.m);
  return stored_range(field_->bounds(node.box, node.coarsest_spacing), description_);
}

Status FieldProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    infos[i] = {stored_bounds(keys[i]), keys[i].level == description_.max_level};
  }
  return {};
}

Status FieldProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  const VoxelBlock block = block_of(key, description_.n, description_.m);
  thread_local std::vector<float> values;
  values.resize(block.voxels());
  field_->sample(block, values);
  with_voxel_type(description_.format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    auto* out = reinterpret_cast<Voxel*>(voxels.data());
    const StoredValue stored(description_);
    std::transform(values.begin(), values.end(), out, [&](float value) { return stored.of<Voxel>(value); });
  });
  return {};
}

}  // namespace gvx::produce
