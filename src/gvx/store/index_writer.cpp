#include "gvx/store/index_writer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "gvx/store/codec.h"

namespace gvx::store {
namespace {

constexpr std::int64_t kEdge = kPageEdge;

/// References that a block of a height has room for.
std::size_t block_refs(Vec3i pages) {
  return static_cast<std::size_t>(pages.x * pages.y * std::min(pages.z, kEdge));
}

Error wrong(std::uint32_t level, const std::string& what) {
  return Error{"store index: level " + std::to_string(level) + ": " + what};
}

Status check_page(const TreeShape& shape, std::uint32_t level, Vec3i page) {
  if (level >= shape.levels) return wrong(level, "the tree has " + std::to_string(shape.levels) + " levels");
  const Vec3i pages = shape.level_pages(level);
  for (int axis = 0; axis < 3; ++axis) {
    if (page[axis] < 0 || page[axis] >= pages[axis]) {
      return wrong(level, "there is no page " + std::to_string(page.x) + ", " + std::to_string(page.y) +
                              ", " + std::to_string(page.z) + " in " + std::to_string(pages.x) + " x " +
                              std::to_string(pages.y) + " x " + std::to_string(pages.z));
    }
  }
  return {};
}

Error page_is_missing(std::uint32_t level) {
  return wrong(level, "a page is missing; call add_page() for each, or set_background()");
}

}  // namespace

IndexWriter::IndexWriter(const TreeShape& shape, const RecordLayout& layout, Append append)
    : shape_(shape), layout_(layout), append_(std::move(append)), levels_(shape.levels) {
  for (std::uint32_t level = 0; level < shape.levels; ++level) {
    for (std::uint32_t height = 0; height < shape.index_height(level); ++height) {
      levels_[level].heights.push_back({shape.index_pages(level, height), 0, false, {}});
    }
  }
}

std::uint64_t IndexWriter::most_bytes(const TreeShape& shape) {
  std::uint64_t bytes = 0;
  for (std::uint32_t level = 0; level < shape.levels; ++level) {
    for (std::uint32_t height = 0; height < shape.index_height(level); ++height) {
      bytes += block_refs(shape.index_pages(level, height)) * sizeof(PageRef);
    }
  }
  return bytes;
}

Status IndexWriter::set_background(std::uint32_t level, std::span<const std::byte> record) {
  if (level >= shape_.levels)
    return wrong(level, "the tree has " + std::to_string(shape_.levels) + " levels");
  if (record.size() != layout_.bytes() || !layout_.decode(record.data()).constant()) {
    return wrong(level, "background: expected one record, of a constant");
  }
  const auto has_pages = [](const Height& height) { return height.begun || height.block > 0; };
  if (levels_[level].top.bytes != 0 || std::ranges::any_of(levels_[level].heights, has_pages)) {
    return wrong(level, "set_background() comes once, before the first page");
  }
  GVX_ASSIGN(levels_[level].background, page_of_one_record(record));
  levels_[level].top = levels_[level].background;
  return {};
}

Status IndexWriter::add_page(std::uint32_t level, Vec3i page, std::span<const std::byte> records) {
  GVX_TRY(check_page(shape_, level, page));
  const std::vector<Height>& heights = levels_[level].heights;
  if (!heights.empty() && page.z / kEdge < heights[0].block) {
    return wrong(level, "a page comes too late; layers of pages come in ascending order of z");
  }
  if (records.size() != std::size_t{kPageNodes} * layout_.bytes()) {
    return wrong(level, "a page of " + std::to_string(records.size()) + " bytes; expected " +
                            std::to_string(kPageNodes) + " records of " + std::to_string(layout_.bytes()));
  }
  const auto one = one_record(level, page, records);
  GVX_ASSIGN(const PageRef ref, one.empty() ? write_page(layout_.bytes(), records) : page_of_one_record(one));
  return put(level, 0, page, ref);
}

Result<std::vector<PageRef>> IndexWriter::finish() {
  std::vector<PageRef> tops;
  for (std::uint32_t level = 0; level < shape_.levels; ++level) {
    for (std::uint32_t height = 0; height < levels_[level].heights.size(); ++height) {
      const std::int64_t layers = levels_[level].heights[height].pages.z;
      GVX_TRY(write_blocks(level, height, (layers + kEdge - 1) / kEdge));
    }
    if (levels_[level].top.bytes == 0) return page_is_missing(level);
    tops.push_back(levels_[level].top);
  }
  return tops;
}

Result<PageRef> IndexWriter::page_of_one_record(std::span<const std::byte> record) {
  if (!std::equal(record.begin(), record.end(), last_record_.begin(), last_record_.end())) {
    GVX_ASSIGN(const BlockRef written, append_(record));
    last_ref_ = {written};
    last_ref_.bytes |= PageRef::kOneRecord;
    last_record_.assign(record.begin(), record.end());
  }
  return last_ref_;
}

std::span<const std::byte> IndexWriter::one_record(std::uint32_t level, Vec3i page,
                                                   std::span<const std::byte> records) const {
  const std::size_t bytes = layout_.bytes();
  const auto first = records.first(bytes);
  if (!layout_.decode(first.data()).constant()) return {};
  const NodeBox nodes = shape_.page_nodes(level, 0, page);
  const Vec3i size = nodes.last - nodes.first;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const auto at = static_cast<std::size_t>((z * kEdge + y) * kEdge + x);
        if (std::memcmp(records.data() + at * bytes, first.data(), bytes) != 0) return {};
      }
    }
  }
  return first;
}

Status IndexWriter::put(std::uint32_t level, std::uint32_t height, Vec3i page, const PageRef& ref) {
  Level& l = levels_[level];
  if (height == l.heights.size()) {
    l.top = ref;
    return {};
  }
  GVX_TRY(write_blocks(level, height, page.z / kEdge));
  Height& h = l.heights[height];
  GVX_CHECK(page.z / kEdge == h.block);
  if (!h.begun) h.refs.assign(block_refs(h.pages), l.background);
  h.begun = true;
  h.refs[static_cast<std::size_t>((page.z % kEdge * h.pages.y + page.y) * h.pages.x + page.x)] = ref;
  return {};
}

/// Writes the pages above the blocks before `end`.
Status IndexWriter::write_blocks(std::uint32_t level, std::uint32_t height, std::int64_t end) {
  while (levels_[level].heights[height].block < end) GVX_TRY(write_block(level, height));
  return {};
}

Status IndexWriter::write_block(std::uint32_t level, std::uint32_t height) {
  Level& l = levels_[level];
  Height& h = l.heights[height];
  const Vec3i above = shape_.index_pages(level, height + 1);
  for (std::int64_t y = 0; y < above.y; ++y) {
    for (std::int64_t x = 0; x < above.x; ++x) {
      PageRef ref = l.background;
      if (h.begun) {
        GVX_ASSIGN(ref, page_above(h, x, y));
      }
      // A page that nobody added, in a level without a background, has no bytes.
      if (ref.bytes == 0) return page_is_missing(level);
      GVX_TRY(put(level, height + 1, {x, y, h.block}, ref));
    }
  }
  h.begun = false;
  ++h.block;
  return {};
}

/// The page (x, y) above the block; without bytes where a page of the block is missing.
Result<PageRef> IndexWriter::page_above(const Height& h, std::int64_t x, std::int64_t y) {
  std::array<PageRef, kPageNodes> page{};
  const std::int64_t across = std::min(h.pages.x - x * kEdge, kEdge),
                     down = std::min(h.pages.y - y * kEdge, kEdge),
                     layers = std::min(h.pages.z - h.block * kEdge, kEdge);
  bool same = true;
  for (std::int64_t k = 0; k < layers; ++k) {
    for (std::int64_t j = 0; j < down; ++j) {
      const PageRef* from = h.refs.data() + (k * h.pages.y + y * kEdge + j) * h.pages.x + x * kEdge;
      PageRef* to = page.data() + (k * kEdge + j) * kEdge;
      std::copy(from, from + across, to);
      same = same && std::all_of(to, to + across, [&](const PageRef& r) { return r == page[0]; });
      if (std::any_of(to, to + across, [](const PageRef& r) { return r.bytes == 0; })) {
        return PageRef{};
      }
    }
  }
  if (same && page[0].one_record()) return page[0];
  return write_page(sizeof(PageRef), std::as_bytes(std::span(page)));
}

Result<PageRef> IndexWriter::write_page(std::size_t element_bytes, std::span<const std::byte> raw) {
  compress(Codec::zstd, {element_bytes, kPageNodes}, raw, compressed_);
  GVX_ASSIGN(const BlockRef written, append_(compressed_));
  return PageRef{written};
}

}  // namespace gvx::store
