#include "gvx/store/format.h"

#include <algorithm>

namespace gvx::store {

const char* codec_name(Codec codec) {
  return codec == Codec::none ? "none" : codec == Codec::zstd ? "zstd" : "lz4";
}

TreeShape TreeShape::covering(Vec3i dimensions, std::uint32_t n, std::uint32_t m) {
  TreeShape shape{n, m, dimensions, 1};
  while (shape.cube_voxels() < static_cast<double>(max_component(dimensions))) ++shape.levels;
  return shape;
}

Vec3i TreeShape::level_dimensions(std::uint32_t level) const {
  Vec3i d = dimensions;
  const Vec3i nn(std::int64_t{n});
  for (std::uint32_t i = level; i + 1 < levels; ++i) d = (d + nn - Vec3i(1)) / nn;
  return d;
}

Vec3i TreeShape::level_nodes(std::uint32_t level) const {
  const Vec3i mm(std::int64_t{m});
  return (level_dimensions(level) + mm - Vec3i(1)) / mm;
}

Vec3i TreeShape::index_pages(std::uint32_t level, std::uint32_t height) const {
  const Vec3i edge(std::int64_t{kPageEdge});
  Vec3i pages = level_nodes(level);
  for (std::uint32_t h = 0; h <= height; ++h) pages = (pages + edge - Vec3i(1)) / edge;
  return pages;
}

std::uint32_t TreeShape::index_height(std::uint32_t level) const {
  std::uint32_t height = 0;
  while (max_component(index_pages(level, height)) > 1) ++height;
  return height;
}

NodeBox TreeShape::page_nodes(std::uint32_t level, std::uint32_t height, Vec3i page) const {
  const Vec3i edge(std::int64_t{kPageEdge} << 3 * height), all = level_nodes(level);
  NodeBox box{level, page * edge, (page + Vec3i(1)) * edge};
  for (int axis = 0; axis < 3; ++axis) box.last[axis] = std::min(box.last[axis], all[axis]);
  return box;
}

std::uint64_t TreeShape::nodes() const {
  std::uint64_t all = 0;
  for (std::uint32_t level = 0; level < levels; ++level) {
    if (__builtin_add_overflow(all, saturating_volume(level_nodes(level)), &all)) return UINT64_MAX;
  }
  return all;
}

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string((bytes + (1 << 20) - 1) >> 20) + "M";
}

std::string node_name(const NodeKey& key) {
  return "node (level " + std::to_string(key.level) + ": " + std::to_string(key.x) + ", " +
         std::to_string(key.y) + ", " + std::to_string(key.z) + ")";
}

bool TreeShape::contains(const NodeKey& key) const {
  if (key.level >= levels) return false;
  const Vec3i nodes = level_nodes(key.level);
  return key.x < static_cast<std::uint64_t>(nodes.x) && key.y < static_cast<std::uint64_t>(nodes.y) &&
         key.z < static_cast<std::uint64_t>(nodes.z);
}

}  // namespace gvx::store
