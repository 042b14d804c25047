/// \file
/// MeshProxy: a mesh around all that may be seen of a volume, which cuts rays.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/mesh/mesh_query.h"
#include "gvx/produce/producer.h"
#include "gvx/scene/proxy.h"

namespace gvx::mesh {

/// Thread-safe.
class MeshProxy final : public scene::Proxy {
 public:
  /// Of a closed mesh in the world of a tree. An error where there is no Embree, or the tree's place in the
  /// world has no inverse.
  static Result<std::shared_ptr<const scene::Proxy>> create(io::TriangleMesh mesh,
                                                            const produce::TreeDescription& tree);

  /// Of the nodes of a level that `hidden(ranges)` does not hide by what the oracle says: a mesh of their
  /// faces, in tree space. An error where the oracle fails, or the level has more than 512 nodes along an
  /// axis.
  static Result<io::TriangleMesh> of_nodes(const produce::Producer& producer, std::uint32_t level,
                                           const std::function<bool(const ChannelRanges&)>& hidden);
  static Result<std::shared_ptr<const scene::Proxy>> around_nodes(
      const produce::Producer& producer, std::uint32_t level,
      const std::function<bool(const ChannelRanges&)>& hidden);

  bool inside(Vec3d place) const override { return mesh_->inside(Vec3f(place)); }
  RayInterval span(const Ray& ray, bool origin_inside) const override;

 private:
  explicit MeshProxy(std::unique_ptr<MeshQuery> mesh) : mesh_(std::move(mesh)) {}
  static Result<std::shared_ptr<const scene::Proxy>> in_tree_space(io::TriangleMesh mesh);

  std::unique_ptr<MeshQuery> mesh_;
};

}  // namespace gvx::mesh
