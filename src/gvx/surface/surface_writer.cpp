#include "gvx/surface/surface_writer.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "gvx/store/checksum.h"
#include "gvx/surface/surface_brick.h"
#include "gvx/surface/surface_pieces.h"

namespace gvx::surface {

Result<std::unique_ptr<SurfaceWriter>> SurfaceWriter::create(const std::string& path, std::uint32_t levels,
                                                             store::Codec codec) {
  GVX_CHECK(levels > 0 && levels <= kMostSurfaceLevels);
  GVX_ASSIGN(PartialFile file, PartialFile::create(path));
  return std::unique_ptr<SurfaceWriter>(new SurfaceWriter(std::move(file), levels, codec));
}

void SurfaceWriter::Bounds::add(int axis, int first, int last) {
  low[axis] = std::min(low[axis], first);
  high[axis] = std::max(high[axis], last);
}

/// Of its samples, of its triangles as far as they are in the brick, and of the bricks below it, which are
/// the last of their level: triangles may lie where no sample is.
SurfaceWriter::Bounds SurfaceWriter::bounds_of(const SurfacePyramid::Made& brick) {
  Bounds bounds;
  const auto columns = brick.samples.cells().columns(2);
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const std::uint32_t column = columns[static_cast<std::size_t>(column_at(x, y))];
      if (column == 0) continue;
      bounds.add(0, x, x);
      bounds.add(1, y, y);
      bounds.add(2, lowest_bit(column), highest_bit(column));
    }
  }
  if (brick.triangles != nullptr) {
    brick.triangles->for_each([&](const std::array<TriangleVertex, 3>& triangle) {
      int first[3], last[3];
      for (int axis = 0; axis < 3; ++axis) {
        const auto [least, most] =
            std::minmax({triangle[0].place[axis], triangle[1].place[axis], triangle[2].place[axis]});
        constexpr int kMost = kCells * kCellParts - 1;
        if (most < 0 || least > kMost) return;
        first[axis] = std::max(least, 0) / kCellParts;
        last[axis] = std::min(most, kMost) / kCellParts;
      }
      for (int axis = 0; axis < 3; ++axis) bounds.add(axis, first[axis], last[axis]);
    });
  }
  if (brick.children == 0) return bounds;
  std::vector<Bounds>& below = levels_.at(brick.key.level + 1).without_parent;
  auto child = below.end() - bits_in(brick.children);
  for (int octant = 0; octant < 8; ++octant) {
    if ((brick.children >> octant & 1) == 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const int corner = (octant >> axis & 1) * kCells;
      bounds.add(axis, (corner + child->low[axis]) / 2, (corner + child->high[axis]) / 2);
    }
    ++child;
  }
  below.resize(below.size() - static_cast<std::size_t>(bits_in(brick.children)));
  return bounds;
}

SurfaceWriter::SurfaceWriter(PartialFile file, std::uint32_t levels, store::Codec codec)
    : file_(std::move(file), sizeof(SurfaceHeader)), codec_(codec), levels_(levels) {}

std::uint64_t SurfaceWriter::bricks() const {
  std::uint64_t bricks = 0;
  for (const Level& level : levels_) bricks += level.nodes;
  return bricks;
}

Status SurfaceWriter::add_piece(SurfaceNode& node, Piece piece, store::BlockLayout layout,
                                std::span<const std::byte> raw) {
  store::compress(codec_, layout, raw, compressed_);
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (compressed_.size() > kMost) return Error{file_.partial_path() + ": a brick has too many triangles"};
  GVX_ASSIGN(const store::BlockRef block, file_.add_block(compressed_));
  node.bytes[static_cast<int>(piece)] = block.bytes;
  node.checksums[static_cast<int>(piece)] = block.checksum;
  return {};
}

Status SurfaceWriter::add_pieces(SurfaceNode& node, const SurfacePyramid::Made& brick) {
  node.offset = file_.end();
  if (!brick.unresolved) {
    const SurfaceBrick samples = make_brick(brick.samples);
    node.samples = static_cast<std::uint32_t>(samples.attributes.size());
    node.grid_bytes = static_cast<std::uint16_t>(samples.grid.bytes.size());
    node.set_form(samples.axis, samples.grid.form, node.wide());
    samples_ += node.samples;
    GVX_TRY(add_piece(node, Piece::geometry, piece_layout(node, Piece::geometry), geometry_bytes(samples)));
    GVX_TRY(add_piece(node, Piece::attributes, piece_layout(node, Piece::attributes),
                      std::as_bytes(std::span(samples.attributes))));
  }
  if (brick.triangles == nullptr || brick.triangles->triangles() == 0) return {};
  node.triangles = brick.triangles->triangles();
  node.vertices = brick.triangles->vertices();
  node.set_form(node.axis(), node.grid_form(), brick.triangles->wide());
  return add_piece(node, Piece::triangles, piece_layout(node, Piece::triangles), brick.triangles->bytes());
}

Status SurfaceWriter::add(const SurfacePyramid::Made& brick) {
  Level& level = levels_.at(brick.key.level);
  if (level.nodes == std::numeric_limits<std::uint32_t>::max()) {
    return Error{file_.partial_path() + ": a level has too many bricks"};
  }
  SurfaceNode node;
  const Bounds bounds = bounds_of(brick);
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis] = static_cast<std::uint8_t>(bounds.low[axis]);
    node.high[axis] = static_cast<std::uint8_t>(bounds.high[axis]);
  }
  level.without_parent.push_back(bounds);
  node.children = brick.children;
  // Its children were the last to be added to their level.
  if (brick.children != 0) {
    const auto children = static_cast<std::uint64_t>(bits_in(brick.children));
    node.first_child = static_cast<std::uint32_t>(levels_.at(brick.key.level + 1).nodes - children);
  }
  GVX_TRY(add_pieces(node, brick));
  level.page.push_back(node);
  ++level.nodes;
  return level.page.size() == kPageNodes ? end_page(level) : Status();
}

Status SurfaceWriter::end_page(Level& level) {
  if (level.page.empty()) return {};
  store::compress(codec_, {}, std::as_bytes(std::span(level.page)), compressed_);
  GVX_ASSIGN(const store::BlockRef block, file_.add_block(compressed_));
  level.pages.push_back(block);
  level.page.clear();
  return {};
}

Status SurfaceWriter::finish(const SurfaceInfo& info) {
  GVX_CHECK(info.levels == levels_.size());
  std::vector<std::uint64_t> nodes;
  std::vector<store::BlockRef> pages;
  for (Level& level : levels_) {
    GVX_TRY(end_page(level));
    nodes.push_back(level.nodes);
    pages.insert(pages.end(), level.pages.begin(), level.pages.end());
  }
  if (nodes.front() != 1) return Error{file_.partial_path() + ": the surface has no root: nothing was added"};
  GVX_TRY(file_.add_section(kLevelsSection, 1, true, std::as_bytes(std::span(nodes))));
  GVX_TRY(file_.add_section(kPagesSection, 1, true, std::as_bytes(std::span(pages))));
  const Vec3d low = info.bounds.minimum, high = info.bounds.maximum;
  const nlohmann::json metadata = {{"source", info.source},
                                   {"up", kUpAxisNames[static_cast<std::size_t>(info.up)]},
                                   {"bounds", {low.x, low.y, low.z, high.x, high.y, high.z}}};
  const std::string text = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  GVX_TRY(file_.add_section(kSurfaceMetadataSection, 1, true, std::as_bytes(std::span(text))));
  GVX_ASSIGN(const store::SectionTable table, file_.add_table());

  SurfaceHeader header{};
  header.magic = kSurfaceMagic;
  header.version = kSurfaceVersion;
  header.header_bytes = sizeof(header);
  header.codec = static_cast<std::uint32_t>(codec_);
  header.levels = info.levels;
  for (int i = 0; i < 12; ++i) {
    header.cells_to_world[i] =
        i < 9 ? info.cells_to_world.column[i / 3][i % 3] : info.cells_to_world.origin[i % 3];
  }
  header.triangles = info.triangles;
  header.sections = table.sections;
  header.table_offset = table.offset;
  header.table_checksum = table.checksum;
  header.file_bytes = file_.end();
  const auto bytes = std::as_bytes(std::span(&header, 1));
  header.header_checksum = store::checksum(bytes.first(offsetof(SurfaceHeader, header_checksum)));
  return file_.finish(bytes);
}

}  // namespace gvx::surface
