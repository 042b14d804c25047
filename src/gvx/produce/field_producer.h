/// \file
/// FieldProducer: makes bricks of a field, which it samples at the centres of voxels.
#pragma once

#include <memory>

#include "gvx/produce/field.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

class FieldProducer final : public Producer {
 public:
  /// `description` gives n, m, max_level, the place in the world, the type of voxels, scale and offset.
  /// Stored values are (value - offset) / scale, rounded and clamped to the type. The description's ranges
  /// are set to the bounds of the whole cube. Of a description that cannot be, or no field, describe() and
  /// produce(), and so Engine::create(), return an error.
  FieldProducer(TreeDescription description, std::shared_ptr<const Field> field);

  /// The same for f32 voxels of a function: values(p), with p in tree space. `bounds(box)` must hold every
  /// value in the box.
  FieldProducer(TreeDescription description, FunctionField::Values values, FunctionField::Bounds bounds);

  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;

 private:
  Status check() const;
  ValueRange stored_bounds(const NodeKey& key) const;

  TreeDescription description_;
  std::shared_ptr<const Field> field_;
};

}  // namespace gvx::produce
