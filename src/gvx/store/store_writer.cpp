#include "gvx/store/store_writer.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "gvx/store/header.h"
#include "gvx/store/shape_check.h"

namespace gvx::store {

namespace {

/// Is it of the volume that the store was created for?
Status check_info(const std::string& path, const VolumeInfo& info, const TreeShape& shape,
                  const RecordLayout& layout) {
  const TreeShape& other = info.shape;
  if (other.n != shape.n || other.m != shape.m || other.levels != shape.levels ||
      other.dimensions != shape.dimensions) {
    return Error{path + ": finish: the tree is of another shape than the store was created with"};
  }
  if (!info.format.valid() || RecordLayout(info.format).bytes() > layout.bytes()) {
    return Error{path + ": finish: the voxels are of another format than the store was created with"};
  }
  const auto complete = [](const auto& histogram) { return histogram.size() == kHistogramBins; };
  if (info.histograms.size() != info.format.channels() || !std::ranges::all_of(info.histograms, complete)) {
    return Error{path + ": finish: expected a histogram of " + std::to_string(kHistogramBins) +
                 " bins for each channel"};
  }
  return {};
}

}  // namespace

StoreWriter::StoreWriter(PartialFile file, const TreeShape& shape, const RecordLayout& layout)
    : file_(std::move(file), sizeof(FileHeader)),
      shape_(shape),
      layout_(layout),
      index_(shape, layout, [this](std::span<const std::byte> bytes) { return add_block(bytes); }) {}

Result<std::unique_ptr<StoreWriter>> StoreWriter::create(const std::string& path, const TreeShape& shape,
                                                         const RecordLayout& layout) {
  if (const Status sound = check_shape(shape); !sound.ok()) return Error{path + ": " + sound.error().message};
  GVX_ASSIGN(PartialFile file, PartialFile::create(path));
  return std::unique_ptr<StoreWriter>(new StoreWriter(std::move(file), shape, layout));
}

Result<NodeRecord> StoreWriter::add_brick(std::span<const std::byte> compressed,
                                          const ChannelRanges& ranges) {
  GVX_ASSIGN(const BlockRef block, add_block(compressed));
  return NodeRecord{block.offset, block.bytes, block.checksum, ranges};
}

Status StoreWriter::set_background(std::uint32_t level, const ChannelRanges& constant) {
  std::vector<std::byte> record(layout_.bytes());
  layout_.encode({0, 0, 0, constant}, record.data());
  return index_.set_background(level, record);
}

Status StoreWriter::add_page(std::uint32_t level, Vec3i page, std::span<const std::byte> records) {
  return index_.add_page(level, page, records);
}

Status StoreWriter::add_page_layer(std::uint32_t level, std::int64_t page_z,
                                   std::span<const NodeRecord> records) {
  constexpr std::int64_t kEdge = kPageEdge;
  if (level >= shape_.levels) {
    return Error{file_.partial_path() + ": level " + std::to_string(level) + ": the tree has " +
                 std::to_string(shape_.levels) + " levels"};
  }
  const Vec3i pages = shape_.level_pages(level);
  const std::int64_t row = pages.x * kEdge, slice = row * pages.y * kEdge;
  if (static_cast<std::int64_t>(records.size()) != slice * kEdge) {
    return Error{file_.partial_path() + ": a layer of " + std::to_string(records.size()) +
                 " records; expected " + std::to_string(slice * kEdge)};
  }
  std::vector<std::byte> page(std::size_t{kPageNodes} * layout_.bytes());
  for (std::int64_t py = 0; py < pages.y; ++py) {
    for (std::int64_t px = 0; px < pages.x; ++px) {
      std::byte* to = page.data();
      for (std::int64_t i = 0; i < kPageNodes; ++i, to += layout_.bytes()) {
        const std::int64_t x = px * kEdge + i % kEdge, y = py * kEdge + i / kEdge % kEdge,
                           z = i / (kEdge * kEdge);
        layout_.encode(records[static_cast<std::size_t>(z * slice + y * row + x)], to);
      }
      GVX_TRY(add_page(level, {px, py, page_z}, page));
    }
  }
  return {};
}

Status StoreWriter::finish(const VolumeInfo& info) {
  GVX_TRY(check_info(file_.partial_path(), info, shape_, layout_));
  GVX_ASSIGN(const auto directory, index_.finish());
  GVX_TRY(add_section(kDirectorySection, 1, true, std::as_bytes(std::span(directory))));
  GVX_TRY(add_section(kRecordsSection, 1, true, std::as_bytes(std::span(layout_.fields()))));

  nlohmann::json channels = nlohmann::json::array();
  for (std::uint32_t c = 0; c < info.format.channels(); ++c) {
    const ValueRange range = info.ranges.channel[c];
    channels.push_back({{"range", {range.minimum, range.maximum}}, {"histogram", info.histograms.at(c)}});
  }
  nlohmann::json metadata = {
      {"source", info.source}, {"anatomical", info.anatomical}, {"channels", channels}};
  if (info.no_data) metadata["noData"] = true;
  if (info.up != UpAxis::z) metadata["up"] = kUpAxisNames[static_cast<std::size_t>(info.up)];
  if (info.bounds) {
    const Vec3d low = info.bounds->minimum, high = info.bounds->maximum;
    metadata["bounds"] = {low.x, low.y, low.z, high.x, high.y, high.z};
  }
  const std::string text = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  GVX_TRY(add_section(kMetadataSection, 1, true, std::as_bytes(std::span(text))));

  FileHeader header = header_of(info, layout_.bytes());
  GVX_ASSIGN(const SectionTable table, file_.add_table());
  header.sections = table.sections;
  header.table_offset = table.offset;
  header.table_checksum = table.checksum;
  header.file_bytes = file_.end();
  const auto header_bytes = std::as_bytes(std::span(&header, 1));
  header.header_checksum = checksum(header_bytes.first(offsetof(FileHeader, header_checksum)));
  return file_.finish(header_bytes);
}

}  // namespace gvx::store
