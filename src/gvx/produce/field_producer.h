/// \file
/// FieldProducer: a scalar field, sampled at voxel centres where rays ask.
#pragma once

#include <memory>

#include "gvx/produce/field.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

class FieldProducer final : public Producer {
 public:
  /// `description` gives n, m, max_level, placement, the voxels' type, and scale and offset: stored values
  /// are (value - offset) / scale, rounded and held to what the type holds. Its ranges become those of the
  /// whole cube.
  FieldProducer(TreeDescription description, std::shared_ptr<const Field> field);

  /// f32 voxels of values(p), p in tree space; `bounds(box)` must hold every value in the box.
  FieldProducer(TreeDescription description, FunctionField::Values values, FunctionField::Bounds bounds);

  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;

 private:
  ValueRange stored_bounds(const NodeKey& key) const;

  TreeDescription description_;
  std::shared_ptr<const Field> field_;
};

}  // namespace gvx::produce
