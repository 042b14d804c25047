/// \file
/// SurfaceReader: reads parts of a surface store (surface_format.h): pages of nodes, and pieces of bricks.
/// Several threads can read at once.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/sections.h"
#include "gvx/store/store_file.h"
#include "gvx/surface/surface_format.h"
#include "gvx/surface/surface_writer.h"

namespace gvx::surface {

class SurfaceReader {
 public:
  /// Reads the header, the sections and where pages are; an error if the file is no complete surface store.
  static Result<std::unique_ptr<SurfaceReader>> open(const std::string& path);

  const SurfaceInfo& info() const { return info_; }
  const std::string& path() const { return file_.path(); }
  std::uint64_t nodes(std::uint32_t level) const { return levels_.at(level).nodes; }
  const std::vector<store::Section>& sections() const { return sections_; }

  /// Nodes page * kPageNodes and on of a level, as many as there are. What they refer to is within the file,
  /// and their children are there.
  Result<std::vector<SurfaceNode>> read_page(std::uint32_t level, std::uint64_t page) const;

  /// A piece of a node, which it must have; the bytes are sound (surface_pieces.h).
  Result<std::vector<std::byte>> read_piece(const SurfaceNode& node, Piece piece) const;

  const store::StoreFile& file() const { return file_; }
  std::uint64_t bytes_read() const { return file_.bytes_read(); }

 private:
  struct Level {
    std::uint64_t nodes = 0;
    std::vector<store::BlockRef> pages;
  };

  SurfaceReader(std::string path, std::unique_ptr<store::RangeReader> ranges)
      : file_(std::move(path), std::move(ranges)) {}
  Status read_header();
  Status read_levels();
  Status read_metadata();
  Status check_node(const SurfaceNode& node, std::uint32_t level) const;

  store::StoreFile file_;
  SurfaceInfo info_;
  std::vector<store::Section> sections_;
  std::vector<Level> levels_;
};

/// Is the file a surface store, by its first bytes?
bool is_surface_store(const std::string& path);

/// What was found sound.
struct SurfaceVerifyReport {
  std::uint64_t nodes = 0, samples = 0, triangles = 0;
  std::uint64_t bytes_read = 0;
};

/// Reads every byte of a surface store that means something, and checks it. The first error names the part.
/// `progress` (may be empty) is called with done and all nodes.
Result<SurfaceVerifyReport> verify_surface(const std::string& path,
                                           const std::function<void(std::uint64_t, std::uint64_t)>& progress);

}  // namespace gvx::surface
