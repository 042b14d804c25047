#include "gvx/mesh/mesh_proxy.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace gvx::mesh {
namespace {

/// Which nodes of a level may be seen, x fastest.
class SeenNodes {
 public:
  SeenNodes(const produce::Producer& producer, std::uint32_t level,
            const std::function<bool(const ChannelRanges&)>& hidden)
      : producer_(producer), hidden_(hidden), level_(level), n_(static_cast<int>(producer.description().n)) {
    edge_ = static_cast<std::int64_t>(nodes_across(n_, level));
    seen_.resize(static_cast<std::size_t>(edge_ * edge_ * edge_));
  }

  Status find(const NodeKey& key) {
    const NodeKey one = producer_.canonical(key);
    tree::NodeInfo info;
    GVX_TRY(producer_.describe(std::span(&one, 1), std::span(&info, 1)));
    if (hidden_(info.ranges)) return {};
    if (key.level == level_ || info.terminal || info.ranges.constant()) {
      fill(key);
      return {};
    }
    for (int index = 0; index < n_ * n_ * n_; ++index) GVX_TRY(find(child(key, n_, index)));
    return {};
  }

  std::int64_t edge() const { return edge_; }
  bool has(Vec3i node) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (node[axis] < 0 || node[axis] >= edge_) return false;
    }
    return seen_[index_of(node)];
  }

 private:
  std::size_t index_of(Vec3i node) const {
    return static_cast<std::size_t>((node.z * edge_ + node.y) * edge_ + node.x);
  }
  /// All that is below a node.
  void fill(const NodeKey& key) {
    const auto across = static_cast<std::int64_t>(nodes_across(n_, level_ - key.level));
    const Vec3i first = across * Vec3i(corner(key));
    for (std::int64_t z = 0; z < across; ++z) {
      for (std::int64_t y = 0; y < across; ++y) {
        for (std::int64_t x = 0; x < across; ++x) seen_[index_of(first + Vec3i(x, y, z))] = true;
      }
    }
  }

  const produce::Producer& producer_;
  const std::function<bool(const ChannelRanges&)>& hidden_;
  std::uint32_t level_;
  int n_;
  std::int64_t edge_;
  std::vector<bool> seen_;
};

}  // namespace

Result<std::shared_ptr<const scene::Proxy>> MeshProxy::in_tree_space(io::TriangleMesh mesh) {
  const InsideRule rule = settle_inside(mesh);
  GVX_ASSIGN(auto query, MeshQuery::create(std::move(mesh), rule));
  return std::shared_ptr<const scene::Proxy>(new MeshProxy(std::move(query)));
}

Result<std::shared_ptr<const scene::Proxy>> MeshProxy::create(io::TriangleMesh mesh,
                                                              const produce::TreeDescription& tree) {
  GVX_TRY(check_placement(tree.tree_to_world));
  const Affine3 to_tree = inverse(tree.tree_to_world);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices[v] = Vec3f(to_tree.point(mesh.place(v)));
  mesh.origin = {};
  return in_tree_space(std::move(mesh));
}

Result<io::TriangleMesh> MeshProxy::of_nodes(const produce::Producer& producer, std::uint32_t level,
                                             const std::function<bool(const ChannelRanges&)>& hidden) {
  constexpr double kMostAcross = 512;
  if (nodes_across(static_cast<int>(producer.description().n), level) > kMostAcross) {
    return Error{"proxy: level " + std::to_string(level) +
                 " has more than 512 nodes along an axis; expected a coarser one"};
  }
  SeenNodes seen(producer, level, hidden);
  GVX_TRY(seen.find(NodeKey{}));
  io::TriangleMesh mesh;
  const auto add_face = [&](Vec3i node, int axis, int side) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int k = 0; k < 4; ++k) {
      Vec3i at = node;
      at[axis] += side;
      at[u] += k & 1;
      at[v] += k >> 1;
      mesh.vertices.push_back(Vec3f(Vec3d(at) / double(seen.edge())));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first + 1, first + 3, first + 2});
  };
  for (std::int64_t z = 0; z < seen.edge(); ++z) {
    for (std::int64_t y = 0; y < seen.edge(); ++y) {
      for (std::int64_t x = 0; x < seen.edge(); ++x) {
        const Vec3i node(x, y, z);
        if (!seen.has(node)) continue;
        for (int face = 0; face < 6; ++face) {
          Vec3i beside = node;
          beside[face / 2] += face % 2 == 0 ? -1 : 1;
          if (!seen.has(beside)) add_face(node, face / 2, face % 2);
        }
      }
    }
  }
  return mesh;
}

Result<std::shared_ptr<const scene::Proxy>> MeshProxy::around_nodes(
    const produce::Producer& producer, std::uint32_t level,
    const std::function<bool(const ChannelRanges&)>& hidden) {
  GVX_ASSIGN(io::TriangleMesh mesh, of_nodes(producer, level, hidden));
  return in_tree_space(std::move(mesh));
}

RayInterval MeshProxy::span(const Ray& ray, bool origin_inside) const {
  const auto ends = mesh_->first_and_last(Vec3f(ray.origin), Vec3f(ray.direction));
  if (!ends) return {1, 0};
  return {origin_inside ? 0.0 : double(ends->first), double(ends->second)};
}

}  // namespace gvx::mesh
