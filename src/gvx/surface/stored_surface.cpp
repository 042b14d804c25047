#include "gvx/surface/stored_surface.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace gvx::surface {
namespace {

constexpr std::size_t kMostPages = 64;  // 256 KiB

Error no_voxels() {
  return Error{"a surface has no voxels: gvx build --as voxels makes some of a mesh"};
}

}  // namespace

produce::TreeDescription describe_surface(const SurfaceInfo& info) {
  produce::TreeDescription tree;
  tree.surface = true;
  tree.n = 2;
  tree.m = kCells;
  tree.max_level = info.levels - 1;
  tree.tree_to_world = info.cells_to_world * scaling(Vec3d(info.cells()));
  tree.bounds = Box3d{info.bounds.minimum / info.cells(), info.bounds.maximum / info.cells()};
  tree.format = {VoxelType::u8, VoxelContent::color_normal, 7};  // what functions take for colours
  tree.up = info.up;
  return tree;
}

/// Corners of the nodes of a level, in tree space: of the finest that has few.
Result<std::vector<Vec3d>> outline_of(const SurfaceReader& reader) {
  constexpr std::uint64_t kMostNodes = 512;
  std::vector<NodeKey> keys = {{}};
  std::vector<SurfaceNode> nodes;
  for (std::uint32_t level = 0;; ++level) {
    nodes.clear();
    for (std::uint64_t page = 0; page < pages_of(reader.nodes(level)); ++page) {
      GVX_ASSIGN(const auto some, reader.read_page(level, page));
      nodes.insert(nodes.end(), some.begin(), some.end());
    }
    if (nodes.size() != keys.size()) return reader.file().corrupt("nodes have no parent");
    if (level + 1 == reader.info().levels || reader.nodes(level + 1) > kMostNodes) break;
    std::vector<NodeKey> finer;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (int octant = 0; octant < 8; ++octant) {
        if ((nodes[i].children >> octant & 1) != 0) finer.push_back(child(keys[i], 2, octant));
      }
    }
    keys = std::move(finer);
  }
  std::vector<Vec3d> outline;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const SurfaceNode& node = nodes[i];
    for (int c = 0; c < 8; ++c) {
      const auto along = [&](int axis) {
        return double((c >> axis & 1) != 0 ? node.high[axis] + 1 : node.low[axis]);
      };
      const Vec3d cells = double(kCells) * corner(keys[i]) + Vec3d(along(0), along(1), along(2));
      outline.push_back(cells / (kCells * nodes_across(2, keys[i].level)));
    }
  }
  return outline;
}

Result<std::shared_ptr<const StoredSurface>> StoredSurface::open(const std::string& path) {
  GVX_ASSIGN(auto reader, SurfaceReader::open(path));
  return of(std::move(reader));
}

Result<std::shared_ptr<const StoredSurface>> StoredSurface::of(std::unique_ptr<SurfaceReader> reader) {
  GVX_ASSIGN(auto outline, outline_of(*reader));
  auto surface = std::shared_ptr<StoredSurface>(new StoredSurface(std::move(reader)));
  surface->description_.outline = std::move(outline);
  return std::shared_ptr<const StoredSurface>(std::move(surface));
}

StoredSurface::StoredSurface(std::unique_ptr<SurfaceReader> reader)
    : reader_(std::move(reader)), description_(describe_surface(reader_->info())) {}

Result<StoredSurface::Page> StoredSurface::page_of(std::uint32_t level, std::uint64_t place) const {
  const std::uint64_t number = place / kPageNodes;
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(pages_.begin(), pages_.end(), [&](const KeptPage& kept) {
      return kept.level == level && kept.number == number;
    });
    if (found != pages_.end()) {
      pages_.splice(pages_.begin(), pages_, found);
      return found->page;
    }
  }
  GVX_ASSIGN(auto nodes, reader_->read_page(level, number));
  const auto page = std::make_shared<const std::vector<SurfaceNode>>(std::move(nodes));
  const std::lock_guard lock(mutex_);
  pages_.push_front({level, number, page});
  if (pages_.size() > kMostPages) pages_.pop_back();
  return page;
}

Result<produce::Element> StoredSurface::make(produce::ElementKind kind, const NodeKey& key) const {
  produce::Element made;
  if (kind == produce::ElementKind::surface_nodes) {
    GVX_ASSIGN(const Page page, page_of(key.level, key.x * kPageNodes));
    const auto bytes = std::as_bytes(std::span(*page));
    made.bytes = std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
    return made;
  }
  if (!produce::of_surface(kind)) return no_voxels();
  GVX_ASSIGN(const Page page, page_of(key.level, key.x));
  const auto piece = static_cast<Piece>(static_cast<std::uint32_t>(kind) -
                                        static_cast<std::uint32_t>(produce::ElementKind::surface_geometry));
  GVX_ASSIGN(auto bytes, reader_->read_piece(page->at(key.x % kPageNodes), piece));
  made.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  return made;
}

void StoredSurface::start(const produce::ElementBatch& batch,
                          std::shared_ptr<produce::ElementSink> sink) const {
  for (std::size_t i = 0; i < batch.nodes.size(); ++i) {
    if (sink->cancelled(i)) {
      sink->drop(i);
    } else {
      sink->complete(i, make(batch.kind, batch.nodes[i]));
    }
  }
}

Status StoredSurface::describe(std::span<const NodeKey>, std::span<tree::NodeInfo>) const {
  return no_voxels();
}

Status StoredSurface::produce(const NodeKey&, std::span<std::byte>) const {
  return no_voxels();
}

}  // namespace gvx::surface
