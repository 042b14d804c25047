#include "gvx/produce/field_producer.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "gvx/produce/check_arguments.h"
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
  if (check().ok()) description_.ranges = stored_bounds(NodeKey{});
}

FieldProducer::FieldProducer(TreeDescription description, FunctionField::Values values,
                             FunctionField::Bounds bounds)
    : FieldProducer(as_floats(std::move(description)),
                    values && bounds ? std::make_shared<FunctionField>(std::move(values), std::move(bounds))
                                     : nullptr) {}

Status FieldProducer::check() const {
  if (field_ == nullptr) return Error{"field: there is none; expected a field, or two functions"};
  return check_scalar_tree(description_);
}

ValueRange FieldProducer::stored_bounds(const NodeKey& key) const {
  const NodeBounds node(key, description_.n, description_.m);
  return stored_range(field_->bounds(node.box, node.coarsest_spacing), description_);
}

Status FieldProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  GVX_TRY(check());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    infos[i] = {stored_bounds(keys[i]), keys[i].level == description_.max_level};
  }
  return {};
}

Status FieldProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  GVX_TRY(check());
  GVX_TRY(check_brick(description_, voxels));
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
