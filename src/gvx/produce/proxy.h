/// \file
/// Proxy: a mesh around all that may be seen of a volume. Rays march between the first and the last place
/// where they cross it (section 5.1 of the 2008 report: "proxy surfaces").
#pragma once

#include <functional>
#include <memory>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/produce/mesh_query.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// Thread-safe.
class Proxy {
 public:
  /// Of a closed mesh in the world of a tree. An error where there is no Embree.
  static Result<std::shared_ptr<const Proxy>> create(io::TriangleMesh mesh, const TreeDescription& tree);

  /// Of the nodes of a level that `hidden(ranges)` does not hide by what the oracle says: a mesh of their
  /// faces, in tree space. An error where the oracle fails.
  static Result<io::TriangleMesh> of_nodes(const Producer& producer, std::uint32_t level,
                                           const std::function<bool(const ChannelRanges&)>& hidden);
  static Result<std::shared_ptr<const Proxy>> around_nodes(
      const Producer& producer, std::uint32_t level, const std::function<bool(const ChannelRanges&)>& hidden);

  /// Is a place of tree space inside?
  bool inside(Vec3d p) const { return mesh_->inside(Vec3f(p)); }
  /// The part of a ray in tree space from the first crossing, or its origin if that is inside, to the last;
  /// empty where there is none.
  RayInterval span(const Ray& ray, bool origin_inside) const;

 private:
  explicit Proxy(std::unique_ptr<MeshQuery> mesh) : mesh_(std::move(mesh)) {}
  static Result<std::shared_ptr<const Proxy>> in_tree_space(io::TriangleMesh mesh);

  std::unique_ptr<MeshQuery> mesh_;
};

}  // namespace gvx::produce
