/// \file
/// Distances to a mesh as fields, below 0 inside: the exact one, and the quick one of the 2008 report's
/// appendix.
#pragma once

#include <memory>

#include "gvx/core/affine.h"
#include "gvx/mesh/mesh_query.h"
#include "gvx/produce/field.h"

namespace gvx::mesh {

/// A mesh in the tree's cube: the middle of its bounds in the middle, `margin` of the cube free at either end
/// of its longest side. `tree_to_world` takes the cube back to where the mesh came from.
struct PlacedMesh {
  io::TriangleMesh mesh;
  Affine3 tree_to_world;
  Box3d extent;  ///< of the mesh with its margin, in tree space

  static PlacedMesh in_cube(io::TriangleMesh mesh, double margin);
};

/// The distance, no farther from 0 than `band`.
class MeshDistanceField final : public produce::Field {
 public:
  MeshDistanceField(std::shared_ptr<const MeshQuery> mesh, double band)
      : mesh_(std::move(mesh)), band_(band) {}

  void sample(const produce::VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override;

 private:
  std::shared_ptr<const MeshQuery> mesh_;
  double band_;
};

/// The distance to the plane through the nearest points of the mesh along the three axes (appendix A): exact
/// beside a plane, elsewhere of the right order. Lines instead of the report's slices of a rasteriser.
class AxisDistanceField final : public produce::Field {
 public:
  AxisDistanceField(std::shared_ptr<const MeshQuery> mesh, double band)
      : mesh_(std::move(mesh)), band_(band) {}

  void sample(const produce::VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override;

 private:
  std::shared_ptr<const MeshQuery> mesh_;
  double band_;
};

}  // namespace gvx::mesh
