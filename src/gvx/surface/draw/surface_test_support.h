/// \file
/// For tests and benches: a surface store that is in memory as a whole, or of which tests say what is.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "gvx/surface/draw/surface_cut.h"
#include "gvx/surface/surface_reader.h"

namespace gvx::surface {

class WholeSurface final : public ResidentSurface {
 public:
  /// A sound store.
  explicit WholeSurface(const SurfaceReader& reader) : info_(reader.info()), levels_(info_.levels) {
    for (std::uint32_t level = 0; level < info_.levels; ++level) {
      for (std::uint64_t page = 0; page < pages_of(reader.nodes(level)); ++page) {
        const auto nodes = reader.read_page(level, page).value();
        levels_[level].nodes.insert(levels_[level].nodes.end(), nodes.begin(), nodes.end());
      }
      for (const SurfaceNode& node : levels_[level].nodes) {
        for (int piece = 0; piece < kPieces; ++piece) {
          auto& bytes = levels_[level].pieces[piece].emplace_back();
          if (node.bytes[piece] > 0) bytes = reader.read_piece(node, static_cast<Piece>(piece)).value();
        }
      }
    }
  }

  const SurfaceNode* node(std::uint32_t level, std::uint32_t place) override {
    return &levels_[level].nodes[place];
  }
  const std::byte* piece(std::uint32_t level, std::uint32_t place, Piece piece) override {
    return levels_[level].pieces[static_cast<int>(piece)][place].data();
  }
  SurfaceInstance instance(std::int32_t object = 0) {
    return {this, info_.levels, info_.cells_to_world, object};
  }
  const SurfaceInfo& info() const { return info_; }

 private:
  struct Level {
    std::vector<SurfaceNode> nodes;
    std::vector<std::vector<std::byte>> pieces[kPieces];
  };

  SurfaceInfo info_;
  std::vector<Level> levels_;
};

}  // namespace gvx::surface
