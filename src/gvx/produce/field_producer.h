/// \file
/// FieldProducer: a scalar field in closed form, sampled at voxel centres. What tests compare pictures with.
#pragma once

#include <functional>

#include "gvx/produce/producer.h"

namespace gvx::produce {

/// f32 voxels of values(p), p in tree space; the oracle is `bounds(box)`, which must hold every value in the
/// box.
class FieldProducer final : public Producer {
 public:
  using Values = std::function<float(Vec3d)>;
  using Bounds = std::function<ValueRange(const Box3d&)>;

  /// `description` gives n, m, max_level and placement; its type becomes f32 and its ranges those of the
  /// whole cube.
  FieldProducer(TreeDescription description, Values values, Bounds bounds);

  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;

 private:
  /// The box of a node with a rim of n voxels.
  Box3d bordered_box(const NodeKey& key) const;

  TreeDescription description_;
  Values values_;
  Bounds bounds_;
};

}  // namespace gvx::produce
