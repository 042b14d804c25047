#include "gvx/store/format.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace gvx::store {

const char* codec_name(Codec codec) {
  return codec == Codec::none ? "none" : codec == Codec::zstd ? "zstd" : "lz4";
}

std::uint64_t checksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
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

Vec3i TreeShape::level_pages(std::uint32_t level) const {
  const Vec3i edge(std::int64_t{kPageEdge});
  return (level_nodes(level) + edge - Vec3i(1)) / edge;
}

std::uint64_t TreeShape::pages_before(std::uint32_t level) const {
  std::uint64_t pages = 0;
  for (std::uint32_t i = 0; i < level; ++i) {
    const Vec3i p = level_pages(i);
    const std::uint64_t of_level = saturating_product(
        saturating_product(static_cast<std::uint64_t>(p.x), static_cast<std::uint64_t>(p.y)),
        static_cast<std::uint64_t>(p.z));
    if (__builtin_add_overflow(pages, of_level, &pages)) return UINT64_MAX;
  }
  return pages;
}

std::uint64_t TreeShape::nodes() const {
  std::uint64_t all = 0;
  for (std::uint32_t level = 0; level < levels; ++level) {
    const Vec3i here = level_nodes(level);
    all += static_cast<std::uint64_t>(here.x * here.y * here.z);
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
