/// \file
/// SurfaceCut: which bricks of surfaces' trees a picture shows: from the root down, those whose cells are no
/// wider than a pixel, or the finest. Which they are is a matter of the camera and the trees alone.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/node_key.h"
#include "gvx/surface/draw/oracle.h"
#include "gvx/surface/draw/placed_brick.h"
#include "gvx/surface/surface_format.h"

namespace gvx::surface {

/// What of a surface is in memory. What is looked up counts as used.
class ResidentSurface {
 public:
  virtual ~ResidentSurface() = default;

  /// A node by its place in its level; null where its page is not there. Valid until the next commit.
  virtual const SurfaceNode* node(std::uint32_t level, std::uint32_t place) = 0;
  /// A piece that the node has; null where it is not there. Valid until the next commit.
  virtual const std::byte* piece(std::uint32_t level, std::uint32_t place, Piece piece) = 0;
};

/// A surface at a place.
struct SurfaceInstance {
  ResidentSurface* surface = nullptr;
  std::uint32_t levels = 1;
  Affine3 cells_to_world;   ///< from cells of the finest level
  std::int32_t object = 0;  ///< its number in the scene
};

/// What a picture lacks: a page of nodes, or a piece of a node's brick.
struct LackingElement {
  std::uint32_t instance = 0, level = 0;
  std::uint32_t place = 0;  ///< of the page, or of the node
  bool page = false;
  Piece piece = Piece::geometry;
  std::uint64_t bytes = 0;  ///< that it takes
  double nearest = 0;       ///< depth

  bool operator==(const LackingElement&) const = default;
};

/// A brick of the cut.
struct CutBrick {
  std::uint32_t instance = 0, level = 0, place = 0;
  NodeKey key;
  SurfaceNode node;
  PlacedBrick::Seen seen;
  Technique technique = Technique::cast;
  bool drawn = false;

  /// In which order bricks win where depths are equal.
  std::uint64_t order() const { return std::uint64_t{instance} << 38 | std::uint64_t{level} << 32 | place; }
};

/// The camera and what it asks of surfaces.
struct SurfaceCamera {
  FilmPlane film;
  Affine3 world_to_camera;
  double widest_cell = kWidestCell;    ///< in pixels; 0: the finest everywhere
  std::optional<Technique> only = {};  ///< where a brick can be drawn so; for tests and benches

  /// From cells of a level of an instance to camera space.
  Affine3 cells_to_camera(const SurfaceInstance& instance, std::uint32_t level) const {
    const double finer = std::ldexp(1.0, static_cast<int>(instance.levels - 1 - level));
    return world_to_camera * instance.cells_to_world * scaling(Vec3d(finer));
  }
  PlacedBrick place(const SurfaceInstance& instance, std::uint32_t level, const NodeKey& key) const {
    return PlacedBrick::at(cells_to_camera(instance, level), double(kCells) * corner(key));
  }
};

class SurfaceCut {
 public:
  /// Is something nearer than this depth in all pixels of a rectangle? Then nothing there is looked for.
  using Hidden = std::function<bool(const PixelRect&, double nearest)>;

  SurfaceCut(const SurfaceCamera& camera, std::span<const SurfaceInstance> instances);

  const SurfaceCamera& camera() const { return camera_; }
  const std::vector<SurfaceInstance>& instances() const { return instances_; }
  std::vector<CutBrick>& bricks() { return bricks_; }
  const std::vector<CutBrick>& bricks() const { return bricks_; }

  /// Goes down as far as nodes are in memory, front to back; what is found is appended to bricks(). Pages
  /// that it lacks are appended to `lacking`, each once.
  void descend(const Hidden& hidden, std::vector<LackingElement>& lacking);
  /// Is the cut whole?
  bool complete() const { return waiting_.empty(); }

  /// Makes a cut of what is in memory as a whole: bricks whose children are not all there stand in for them.
  /// What it lacks is appended to `lacking`.
  void descend_resident(std::vector<LackingElement>& lacking);

 private:
  struct Place {
    std::uint32_t instance = 0, level = 0, place = 0;
    NodeKey key;
  };

  void visit(const Place& at, const Hidden& hidden);
  /// Its children, the nearest first.
  template <typename Function>
  void for_children(const Place& at, const SurfaceNode& node, Function function) const;
  bool seen(const Place& at, const SurfaceNode& node, PlacedBrick::Seen& seen) const;
  bool refines(const SurfaceNode& node, const PlacedBrick::Seen& seen) const;
  CutBrick brick(const Place& at, const SurfaceNode& node, const PlacedBrick::Seen& seen) const;
  const SurfaceNode* node(const Place& at) const {
    return instances_[at.instance].surface->node(at.level, at.place);
  }
  void lack_page(const Place& at, double nearest, std::vector<LackingElement>& lacking) const;
  bool ready(CutBrick& brick, std::vector<LackingElement>& lacking) const;
  bool can_show(const Place& at, double nearest, std::vector<LackingElement>& lacking) const;
  void visit_resident(const Place& at, std::vector<LackingElement>& lacking);

  SurfaceCamera camera_;
  std::vector<SurfaceInstance> instances_;
  std::vector<std::vector<Affine3>> cells_to_camera_;  // of each instance, of each level
  std::vector<Vec3d> eye_;                             // of each instance, in cells of the finest level
  std::vector<Vec3d> forward_;                         // and the way of a camera without an eye
  std::vector<CutBrick> bricks_;
  std::vector<Place> waiting_;  // for their pages
};

/// What techniques draw with.
inline bool needs(Technique technique, Piece piece) {
  return (technique == Technique::rasterise) == (piece == Piece::triangles);
}

}  // namespace gvx::surface
