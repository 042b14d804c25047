#include "gvx/store/page_index.h"

#include <algorithm>
#include <cstring>

#include "gvx/store/codec.h"

namespace gvx::store {
namespace {

/// Of a node in its page, or of a page in the page above it, x fastest.
std::size_t place_in_page(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  constexpr std::uint64_t kInPage = kPageEdge - 1;
  return static_cast<std::size_t>(((z & kInPage) * kPageEdge + (y & kInPage)) * kPageEdge + (x & kInPage));
}

std::string page_name(std::uint32_t level, std::uint32_t height, Vec3i page) {
  return "index page (level " + std::to_string(level) + ", height " + std::to_string(height) + ": " +
         std::to_string(page.x) + ", " + std::to_string(page.y) + ", " + std::to_string(page.z) + ")";
}

Result<RecordLayout> read_layout(const StoreFile& file, const StoreHeader& header) {
  if (header.version == 2) return RecordLayout::version2();
  if (header.record_bytes == 0 || header.record_bytes > kMostRecordBytes) {
    return file.corrupt("node records of " + std::to_string(header.record_bytes) + " bytes; at most " +
                        std::to_string(kMostRecordBytes) + " are expected");
  }
  GVX_ASSIGN(const Section section,
             find_section(file, header.sections, kRecordsSection, kMostFields * sizeof(RecordField)));
  GVX_ASSIGN(const auto bytes, read_section(file, section));
  std::vector<RecordField> fields(bytes.size() / sizeof(RecordField));
  if (fields.size() * sizeof(RecordField) != bytes.size()) {
    return file.corrupt("section \"" + section.name + "\" does not hold a whole number of fields");
  }
  std::memcpy(fields.data(), bytes.data(), bytes.size());
  return RecordLayout::parse(file, fields, header.record_bytes, header.info.format);
}

}  // namespace

PageIndex::PageIndex(const StoreFile& file, const TreeShape& shape, RecordLayout layout)
    : file_(file), shape_(shape), layout_(std::move(layout)) {
  std::uint64_t first = 0;
  for (std::uint32_t level = 0; level < shape.levels; ++level) {
    const Vec3i pages = shape.level_pages(level);
    levels_.push_back({shape.index_height(level), pages, first});
    if (__builtin_add_overflow(first, saturating_volume(pages), &first)) first = UINT64_MAX;
  }
}

Result<std::unique_ptr<PageIndex>> PageIndex::open(const StoreFile& file, const StoreHeader& header) {
  GVX_ASSIGN(RecordLayout layout, read_layout(file, header));
  std::unique_ptr<PageIndex> index(new PageIndex(file, header.info.shape, std::move(layout)));
  GVX_TRY(index->read_directory(header));
  return index;
}

Status PageIndex::read_directory(const StoreHeader& header) {
  flat_ = header.version == 2;
  std::uint64_t pages = levels_.size();
  if (flat_ &&
      __builtin_add_overflow(levels_.back().first, saturating_volume(levels_.back().pages), &pages)) {
    pages = UINT64_MAX;
  }
  const std::uint64_t bytes = saturating_product(pages, sizeof(PageRef));
  GVX_ASSIGN(const Section section, find_section(file_, header.sections, kDirectorySection, bytes));
  if (section.bytes != bytes) {
    return file_.corrupt("section \"" + section.name + "\" has " + std::to_string(section.bytes) +
                         " bytes; " + std::to_string(bytes) + " are expected");
  }
  directory_.resize(static_cast<std::size_t>(pages));
  const auto directory = std::as_writable_bytes(std::span(directory_));
  GVX_TRY(file_.read(section.offset, directory));
  if (checksum(directory) != section.checksum) {
    return file_.corrupt("the checksum of section \"" + section.name + "\" does not match");
  }
  return {};
}

std::size_t PageIndex::wanted_bytes() const {
  // Above a page of records stands one of references, and so on: together less than as many pages again.
  const std::uint64_t of_page =
      kPageNodes * std::max<std::uint64_t>(layout_.bytes(), sizeof(PageRef)) + PageCache::kOfEach;
  std::uint64_t bytes = 0;
  for (const Level& level : levels_) {
    const std::uint64_t pages = saturating_volume(level.pages);
    bytes += saturating_product(saturating_product(2, pages), of_page);
    if (bytes >= kCacheBytes) return kCacheBytes;
  }
  return static_cast<std::size_t>(bytes);
}

PageRef PageIndex::flat_page(std::uint32_t level, Vec3i page) const {
  const Level& l = levels_[level];
  return directory_[static_cast<std::size_t>(l.first) +
                    static_cast<std::size_t>((page.z * l.pages.y + page.y) * l.pages.x + page.x)];
}

Result<Page> PageIndex::load(const PageRef& ref, std::uint32_t level, std::uint32_t height,
                             Vec3i page) const {
  const bool of_records = height == 0 || ref.one_record();
  return cache_.get({ref, of_records}, [&]() -> Result<Page> {
    const auto wrong = [&](const std::string& what) {
      return file_.corrupt(page_name(level, height, page) + ": " + what);
    };
    const std::size_t element = of_records ? layout_.bytes() : sizeof(PageRef);
    const std::size_t count = ref.one_record() ? 1 : kPageNodes, raw = element * count;
    const std::uint32_t stored = ref.stored_bytes();
    if (ref.one_record() ? stored != raw : stored > 2 * raw) {
      return wrong(std::to_string(stored) + " bytes cannot be a page");
    }
    if (!file_.has(ref.offset, stored)) return wrong("not within the file");
    std::vector<std::byte> compressed(stored);
    GVX_TRY(file_.read(ref.offset, compressed));
    const TimeSum::Span decoding(file_.decoding());
    if (static_cast<std::uint32_t>(checksum(compressed)) != ref.checksum) {
      return wrong("its checksum does not match");
    }
    if (ref.one_record()) return std::make_shared<const std::vector<std::byte>>(std::move(compressed));
    auto bytes = std::make_shared<std::vector<std::byte>>(raw);
    if (const auto status = decompress(Codec::zstd, {element, count}, compressed, *bytes); !status.ok()) {
      return wrong(status.error().message);
    }
    return Page(std::move(bytes));
  });
}

Result<PageIndex::Record> PageIndex::record(const NodeKey& key) const {
  if (!shape_.contains(key)) return Error{file_.path() + ": " + node_name(key) + " is not in the tree"};
  const auto page_of = [&](std::uint32_t height) {
    const std::uint32_t shift = 3 * (height + 1);
    return Vec3i(static_cast<std::int64_t>(key.x >> shift), static_cast<std::int64_t>(key.y >> shift),
                 static_cast<std::int64_t>(key.z >> shift));
  };
  std::uint32_t height = flat_ ? 0 : levels_[key.level].height;
  PageRef ref = flat_ ? flat_page(key.level, page_of(0)) : directory_[key.level];
  for (; height > 0 && !ref.one_record(); --height) {
    GVX_ASSIGN(const Page page, load(ref, key.level, height, page_of(height)));
    const std::uint32_t shift = 3 * height;
    std::memcpy(&ref,
                page->data() + place_in_page(key.x >> shift, key.y >> shift, key.z >> shift) * sizeof(ref),
                sizeof(ref));
  }
  GVX_ASSIGN(Page page, load(ref, key.level, height, page_of(height)));
  const std::size_t place = ref.one_record() ? 0 : place_in_page(key.x, key.y, key.z);
  const std::byte* bytes = page->data() + place * layout_.bytes();
  return Record{std::move(page), bytes, ref.one_record()};
}

Result<NodeRecord> PageIndex::node(const NodeKey& key) const {
  GVX_ASSIGN(const Record found, record(key));
  const NodeRecord node = layout_.decode(found.bytes);
  // One brick cannot be that of many nodes.
  if (found.of_many && !node.constant()) {
    return file_.corrupt("the record of " + node_name(key) + " stands for many nodes but has a brick");
  }
  return node;
}

Status PageIndex::for_each_page(const NodeBox& box, const Take& take) const {
  std::uint64_t bytes = 0;
  if (!flat_) return walk(directory_[box.level], levels_[box.level].height, Vec3i(), box, bytes, take);
  const Vec3i edge(std::int64_t{kPageEdge});
  const Vec3i first = box.first / edge, last = (box.last + edge - Vec3i(1)) / edge;
  for (std::int64_t z = first.z; z < last.z; ++z) {
    for (std::int64_t y = first.y; y < last.y; ++y) {
      for (std::int64_t x = first.x; x < last.x; ++x) {
        GVX_TRY(walk(flat_page(box.level, {x, y, z}), 0, {x, y, z}, box, bytes, take));
      }
    }
  }
  return {};
}

Status PageIndex::walk(const PageRef& ref, std::uint32_t height, Vec3i page, const NodeBox& box,
                       std::uint64_t& page_bytes, const Take& take) const {
  NodeBox part = shape_.page_nodes(box.level, height, page);
  for (int axis = 0; axis < 3; ++axis) {
    part.first[axis] = std::max(part.first[axis], box.first[axis]);
    part.last[axis] = std::min(part.last[axis], box.last[axis]);
    if (part.first[axis] >= part.last[axis]) return {};
  }
  if (!ref.one_record()) page_bytes += ref.bytes;
  if (height == 0 || ref.one_record()) return take({part, ref.one_record(), page_bytes});
  GVX_ASSIGN(const Page below, load(ref, box.level, height, page));
  const Vec3i first = page * std::int64_t{kPageEdge};
  const Vec3i all = shape_.index_pages(box.level, height - 1);
  for (std::uint32_t i = 0; i < kPageNodes; ++i) {
    const Vec3i at = first + Vec3i(i % kPageEdge, i / kPageEdge % kPageEdge, i / (kPageEdge * kPageEdge));
    if (at.x >= all.x || at.y >= all.y || at.z >= all.z) continue;
    PageRef next{};
    std::memcpy(&next, below->data() + i * sizeof(next), sizeof(next));
    GVX_TRY(walk(next, height - 1, at, box, page_bytes, take));
  }
  return {};
}

}  // namespace gvx::store
