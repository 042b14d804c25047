#include "gvx/surface/surface_reader.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "gvx/store/checksum.h"
#include "gvx/store/codec.h"
#include "gvx/surface/surface_pieces.h"

namespace gvx::surface {
namespace {

// What a sound file may have, by which absurd ones are told.
constexpr std::uint64_t kMostPagesBytes = std::uint64_t{1} << 30, kMostMetadataBytes = 1 << 20;
constexpr std::uint64_t kMostPieceBytes = std::uint64_t{1} << 32;

std::string node_text(std::uint32_t level, std::uint64_t place) {
  return "node " + std::to_string(place) + " of level " + std::to_string(level);
}

/// Numbers of a section, all of it.
template <typename T>
Result<std::vector<T>> read_list(const store::StoreFile& file, std::span<const store::Section> sections,
                                 const char* name, std::uint64_t most_bytes) {
  GVX_ASSIGN(const store::Section section, store::find_section(file, sections, name, most_bytes));
  GVX_ASSIGN(const auto bytes, store::read_section(file, section));
  if (bytes.size() % sizeof(T) != 0) return file.corrupt(std::string("section \"") + name + "\" is cut");
  std::vector<T> list(bytes.size() / sizeof(T));
  if (!list.empty()) std::memcpy(list.data(), bytes.data(), bytes.size());
  return list;
}

}  // namespace

Result<std::unique_ptr<SurfaceReader>> SurfaceReader::open(const std::string& path) {
  GVX_ASSIGN(auto ranges, store::open_file_ranges(path));
  auto reader = std::unique_ptr<SurfaceReader>(new SurfaceReader(path, std::move(ranges)));
  GVX_TRY(reader->read_header());
  GVX_TRY(reader->read_levels());
  GVX_TRY(reader->read_metadata());
  return reader;
}

Status SurfaceReader::read_header() {
  SurfaceHeader header{};
  const auto bytes = std::as_writable_bytes(std::span(&header, 1));
  const auto is_none = [&](const char* why) { return Error{path() + ": not a surface store: " + why}; };
  if (file_.size_bytes() < bytes.size()) return is_none("too short for a header");
  GVX_TRY(file_.read(0, bytes));
  if (header.magic != kSurfaceMagic) return is_none("no GVXSURFC at its start");
  if (header.version > kSurfaceVersion) {
    return Error{path() + ": made by a newer gvx: surface version " + std::to_string(header.version) +
                 "; this program reads up to " + std::to_string(kSurfaceVersion)};
  }
  if (store::checksum(bytes.first(offsetof(SurfaceHeader, header_checksum))) != header.header_checksum) {
    return file_.corrupt("the header's checksum does not match");
  }
  if (header.file_bytes != file_.size_bytes()) {
    return file_.corrupt(std::to_string(file_.size_bytes()) + " bytes long, " +
                         std::to_string(header.file_bytes) + " expected");
  }
  if (header.flags != 0) return Error{path() + ": made by a newer gvx: the header has unknown flags"};
  const auto wrong = [&](const char* field) {
    return file_.corrupt(std::string("the header's ") + field + " is not one that gvx writes");
  };
  if (header.version == 0 || header.header_bytes != sizeof(header)) return wrong("version or size");
  if (header.codec > 2) return wrong("codec");
  if (header.levels < 1 || header.levels > kMostSurfaceLevels) return wrong("number of levels");
  info_.codec = static_cast<store::Codec>(header.codec);
  info_.levels = header.levels;
  info_.triangles = header.triangles;
  const double* m = header.cells_to_world;
  for (int i = 0; i < 12; ++i) {
    if (!std::isfinite(m[i])) return wrong("cells-to-world matrix");
  }
  for (int c = 0; c < 3; ++c) info_.cells_to_world.column[c] = {m[3 * c], m[3 * c + 1], m[3 * c + 2]};
  info_.cells_to_world.origin = {m[9], m[10], m[11]};
  if (const Status placed = check_placement(info_.cells_to_world); !placed.ok()) {
    return file_.corrupt("the surface's placement in the world has no usable inverse");
  }
  const store::SectionTable table{header.sections, header.table_offset, header.table_checksum};
  GVX_ASSIGN(sections_, store::read_sections(file_, table, sizeof(header)));
  constexpr const char* kKnown[] = {kLevelsSection, kPagesSection, kSurfaceMetadataSection};
  return store::check_required(file_, sections_, kKnown);
}

Status SurfaceReader::read_levels() {
  GVX_ASSIGN(const auto nodes, read_list<std::uint64_t>(file_, sections_, kLevelsSection,
                                                        kMostSurfaceLevels * sizeof(std::uint64_t)));
  GVX_ASSIGN(const auto pages, read_list<store::BlockRef>(file_, sections_, kPagesSection, kMostPagesBytes));
  if (nodes.size() != info_.levels || nodes.front() != 1) return file_.corrupt("it has no root");
  auto next = pages.begin();
  for (const std::uint64_t count : nodes) {
    const std::uint64_t of_level = pages_of(count);
    if (count > UINT32_MAX || of_level > static_cast<std::uint64_t>(pages.end() - next)) {
      return file_.corrupt("pages of nodes are missing");
    }
    const auto end = next + static_cast<std::ptrdiff_t>(of_level);
    levels_.push_back({count, {next, end}});
    next = end;
  }
  if (next != pages.end()) return file_.corrupt("there are more pages than nodes");
  return {};
}

Status SurfaceReader::read_metadata() {
  GVX_ASSIGN(const store::Section section,
             store::find_section(file_, sections_, kSurfaceMetadataSection, kMostMetadataBytes));
  GVX_ASSIGN(const auto bytes, store::read_section(file_, section));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto metadata = nlohmann::json::parse(text, nullptr, false);
  const Error wrong = file_.corrupt("the metadata is not the JSON that gvx writes");
  if (!metadata.is_object() || !metadata.contains("source") || !metadata["source"].is_string() ||
      !metadata.contains("up") || !metadata["up"].is_string() || !metadata.contains("bounds") ||
      !metadata["bounds"].is_array() || metadata["bounds"].size() != 6) {
    return wrong;
  }
  info_.source = metadata["source"].get<std::string>();
  const std::string up = metadata["up"].get<std::string>();
  if (up != kUpAxisNames[0] && up != kUpAxisNames[1]) return wrong;
  info_.up = up == kUpAxisNames[0] ? UpAxis::y : UpAxis::z;
  for (int i = 0; i < 6; ++i) {
    const auto& number = metadata["bounds"][static_cast<std::size_t>(i)];
    if (!number.is_number()) return wrong;
    const double place = number.get<double>();
    if (!(place >= -1) || !(place <= info_.cells() + 1)) return wrong;
    (i < 3 ? info_.bounds.minimum : info_.bounds.maximum)[i % 3] = place;
  }
  return info_.bounds.empty() ? Status(wrong) : Status();
}

Status SurfaceReader::check_node(const SurfaceNode& node, std::uint32_t level) const {
  const auto wrong = [&](const char* what) { return file_.corrupt(std::string("a node's ") + what); };
  if ((node.children != 0) && level + 1 == info_.levels) return wrong("children are beyond the finest level");
  if (node.children != 0) {
    const std::uint64_t last = std::uint64_t{node.first_child} + std::uint64_t(bits_in(node.children));
    if (last > levels_[level + 1].nodes) return wrong("children are not there");
  }
  if (node.axis() > 2 || node.form > 15) return wrong("form is none that gvx writes");
  if (node.samples > kCells * kCells * kCells) return wrong("samples are more than a brick has cells");
  for (int axis = 0; axis < 3; ++axis) {
    if (node.low[axis] > node.high[axis] || node.high[axis] >= kCells) return wrong("bounds are none");
  }
  if (!node.resolved() && node.triangles == 0 && node.children == 0) return wrong("content is missing");
  std::uint64_t end = node.offset;
  for (int piece = 0; piece < kPieces; ++piece) {
    const std::uint64_t raw = piece_bytes(node, static_cast<Piece>(piece));
    if ((raw == 0) != (node.bytes[piece] == 0)) return wrong("pieces are not those that it names");
    // zstd makes at most a block of 128 KiB of four bytes.
    constexpr std::uint64_t kMostRatio = 1 << 16;
    if (raw > kMostPieceBytes || raw > kMostRatio * node.bytes[piece]) return wrong("size is absurd");
    end += node.bytes[piece];
  }
  if (node.offset > file_.size_bytes() || end > file_.size_bytes())
    return wrong("pieces are not within the file");
  return {};
}

Result<std::vector<SurfaceNode>> SurfaceReader::read_page(std::uint32_t level, std::uint64_t page) const {
  GVX_CHECK(level < levels_.size() && page < levels_[level].pages.size());
  const store::BlockRef& block = levels_[level].pages[page];
  const std::uint64_t first = page * kPageNodes;
  std::vector<SurfaceNode> nodes(std::min<std::uint64_t>(kPageNodes, levels_[level].nodes - first));
  const auto raw = std::as_writable_bytes(std::span(nodes));
  const auto wrong = [&](const std::string& what) {
    return file_.corrupt("the page of " + node_text(level, first) + ": " + what);
  };
  if (!file_.has(block.offset, block.bytes) || block.bytes > 2 * sizeof(SurfaceNode) * kPageNodes) {
    return wrong("is not within the file");
  }
  std::vector<std::byte> compressed(block.bytes);
  GVX_TRY(file_.read(block.offset, compressed));
  if (static_cast<std::uint32_t>(store::checksum(compressed)) != block.checksum) {
    return wrong("its checksum does not match");
  }
  const Status done = store::decompress(info_.codec, {}, compressed, raw);
  if (!done.ok()) return wrong(done.error().message);
  for (const SurfaceNode& node : nodes) GVX_TRY(check_node(node, level));
  return nodes;
}

Result<std::vector<std::byte>> SurfaceReader::read_piece(const SurfaceNode& node, Piece piece) const {
  const int number = static_cast<int>(piece);
  const auto wrong = [&](const std::string& what) {
    return file_.corrupt(std::string("the ") + kPieceNames[number] + " at byte " +
                         std::to_string(node.offset) + ": " + what);
  };
  std::uint64_t offset = node.offset;
  for (int before = 0; before < number; ++before) offset += node.bytes[before];
  std::vector<std::byte> compressed(node.bytes[number]);
  GVX_TRY(file_.read(offset, compressed));
  const TimeSum::Span decoding(file_.decoding());
  if (static_cast<std::uint32_t>(store::checksum(compressed)) != node.checksums[number]) {
    return wrong("its checksum does not match");
  }
  std::vector<std::byte> raw(piece_bytes(node, piece));
  const Status done = store::decompress(info_.codec, piece_layout(node, piece), compressed, raw);
  if (!done.ok()) return wrong(done.error().message);
  const Status sound = check_piece(node, piece, raw);
  if (!sound.ok()) return wrong(sound.error().message);
  return raw;
}

bool is_surface_store(const std::string& path) {
  // To look into a pipe would take away what is in it.
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::binary);
  std::array<char, 8> magic{};
  file.read(magic.data(), magic.size());
  return file.good() && magic == kSurfaceMagic;
}

Result<SurfaceVerifyReport> verify_surface(
    const std::string& path, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  GVX_ASSIGN(const auto reader, SurfaceReader::open(path));
  for (const store::Section& section : reader->sections()) {
    GVX_ASSIGN(const std::uint64_t sum, reader->file().checksum_of(section.offset, section.bytes));
    if (sum != section.checksum) {
      return reader->file().corrupt("the checksum of section \"" + section.name + "\" does not match");
    }
  }
  SurfaceVerifyReport report;
  std::uint64_t all = 0;
  for (std::uint32_t level = 0; level < reader->info().levels; ++level) all += reader->nodes(level);
  for (std::uint32_t level = 0; level < reader->info().levels; ++level) {
    std::uint64_t expected_child = 0;
    for (std::uint64_t page = 0; page < pages_of(reader->nodes(level)); ++page) {
      GVX_ASSIGN(const auto nodes, reader->read_page(level, page));
      for (const SurfaceNode& node : nodes) {
        // Each node has one parent.
        if (node.children != 0 && node.first_child != expected_child) {
          return reader->file().corrupt("the children of " + node_text(level, report.nodes) +
                                        " are another's, too");
        }
        expected_child += static_cast<std::uint64_t>(bits_in(node.children));
        for (int piece = 0; piece < kPieces; ++piece) {
          if (node.bytes[piece] == 0) continue;
          GVX_ASSIGN(const auto bytes, reader->read_piece(node, static_cast<Piece>(piece)));
          (void)bytes;
        }
        ++report.nodes;
        report.samples += node.samples;
        report.triangles += node.triangles;
        if (progress) progress(report.nodes, all);
      }
    }
    if (level + 1 < reader->info().levels && expected_child != reader->nodes(level + 1)) {
      return reader->file().corrupt("nodes of level " + std::to_string(level + 1) + " have no parent");
    }
  }
  report.bytes_read = reader->bytes_read();
  return report;
}

}  // namespace gvx::surface
