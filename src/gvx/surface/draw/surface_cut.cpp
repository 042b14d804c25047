#include "gvx/surface/draw/surface_cut.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gvx/surface/surface_pieces.h"

namespace gvx::surface {

SurfaceCut::SurfaceCut(const SurfaceCamera& camera, std::span<const SurfaceInstance> instances)
    : camera_(camera), instances_(instances.begin(), instances.end()) {
  for (std::uint32_t i = 0; i < instances_.size(); ++i) {
    const SurfaceInstance& instance = instances_[i];
    std::vector<Affine3>& levels = cells_to_camera_.emplace_back();
    for (std::uint32_t level = 0; level < instance.levels; ++level) {
      levels.push_back(camera_.cells_to_camera(instance, level));
    }
    const Affine3 back = inverse(levels.back());
    eye_.push_back(back.origin);
    forward_.push_back(back.column[2]);
    waiting_.push_back({i, 0, 0, {}});
  }
}

bool SurfaceCut::seen(const Place& at, const SurfaceNode& node, PlacedBrick::Seen& seen) const {
  Affine3 to_camera = cells_to_camera_[at.instance][at.level];
  to_camera.origin = to_camera.point(double(kCells) * corner(at.key));
  seen = seen_of(camera_.film, to_camera, node.low, node.high);
  return !seen.rect.empty();
}

bool SurfaceCut::refines(const SurfaceNode& node, const PlacedBrick::Seen& seen) const {
  return node.children != 0 && (!node.resolved() || seen.cell_pixels > camera_.widest_cell);
}

CutBrick SurfaceCut::brick(const Place& at, const SurfaceNode& node, const PlacedBrick::Seen& seen) const {
  CutBrick brick{at.instance, at.level, at.place, at.key, node, seen};
  BrickMeasures measures;
  measures.triangles = node.triangles;
  measures.samples = node.samples;
  measures.pixels = double(seen.rect.x1 - seen.rect.x0) * double(seen.rect.y1 - seen.rect.y0);
  measures.cell_pixels = seen.cell_pixels;
  measures.has_triangles = node.triangles > 0;
  measures.has_samples = node.resolved();
  // The view through the middle of its rectangle, as the grid's axis sees it.
  const Affine3 placed = inverse(cells_to_camera_[at.instance][at.level]);
  const double x = 0.5 * (seen.rect.x0 + seen.rect.x1), y = 0.5 * (seen.rect.y0 + seen.rect.y1);
  const Vec3d way = normalize(placed.vector(camera_.film.ray(x, y).direction));
  measures.along_grid = 1 - std::fabs(way[node.axis()]);
  brick.technique = choose_technique(measures);
  if (camera_.only) {
    const bool can = *camera_.only == Technique::rasterise ? measures.has_triangles : measures.has_samples;
    if (can) brick.technique = *camera_.only;
  }
  return brick;
}

template <typename Function>
void SurfaceCut::for_children(const Place& at, const SurfaceNode& node, Function function) const {
  // The octant that the eye is in comes first; of axes, those on its side first.
  const double finer =
      std::ldexp(double(kCells), static_cast<int>(instances_[at.instance].levels - 1 - at.level));
  const Vec3d middle = finer * (corner(at.key) + Vec3d(0.5));
  int nearest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const bool high =
        camera_.film.orthographic ? forward_[at.instance][axis] < 0 : eye_[at.instance][axis] > middle[axis];
    nearest |= high ? 1 << axis : 0;
  }
  for (int i = 0; i < 8; ++i) {
    const int octant = i ^ nearest;
    if ((node.children >> octant & 1) == 0) continue;
    function(Place{at.instance, at.level + 1, node.child_at(octant), child(at.key, 2, octant)});
  }
}

void SurfaceCut::visit(const Place& at, const Hidden& hidden) {
  const SurfaceNode* const node = this->node(at);
  if (node == nullptr) {
    waiting_.push_back(at);
    return;
  }
  PlacedBrick::Seen seen;
  if (!this->seen(at, *node, seen) || hidden(seen.rect, seen.nearest)) return;
  if (!refines(*node, seen)) {
    bricks_.push_back(brick(at, *node, seen));
    return;
  }
  const SurfaceNode copy = *node;
  for_children(at, copy, [&](const Place& below) { visit(below, hidden); });
}

void SurfaceCut::lack_page(const Place& at, double nearest, std::vector<LackingElement>& lacking) const {
  const LackingElement page{at.instance, at.level,        at.place / kPageNodes,
                            true,        Piece::geometry, kPageNodes * sizeof(SurfaceNode),
                            nearest};
  // Nodes of a page mostly come soon after each other; what is asked for twice does no harm.
  constexpr std::ptrdiff_t kLast = 32;
  const auto first = lacking.end() - std::min(kLast, lacking.end() - lacking.begin());
  const bool there = std::any_of(first, lacking.end(), [&](const LackingElement& other) {
    return other.page && other.instance == page.instance && other.level == page.level &&
           other.place == page.place;
  });
  if (!there) lacking.push_back(page);
}

void SurfaceCut::descend(const Hidden& hidden, std::vector<LackingElement>& lacking) {
  const std::vector<Place> waiting = std::exchange(waiting_, {});
  for (const Place& at : waiting) visit(at, hidden);
  for (const Place& at : waiting_) lack_page(at, 0, lacking);
}

/// Are the pieces there that a brick is drawn with? Where its triangles are not, samples do.
bool SurfaceCut::ready(CutBrick& brick, std::vector<LackingElement>& lacking) const {
  ResidentSurface& surface = *instances_[brick.instance].surface;
  const auto has_all = [&](Technique technique, std::vector<LackingElement>* list) {
    bool all = true;
    for (int i = 0; i < kPieces; ++i) {
      const auto piece = static_cast<Piece>(i);
      if (!needs(technique, piece) || surface.piece(brick.level, brick.place, piece) != nullptr) continue;
      all = false;
      if (list != nullptr) {
        list->push_back({brick.instance, brick.level, brick.place, false, piece,
                         piece_bytes(brick.node, piece), brick.seen.nearest});
      }
    }
    return all;
  };
  if (has_all(brick.technique, &lacking)) return true;
  const bool other = brick.technique == Technique::rasterise && brick.node.resolved();
  if (!other || !has_all(Technique::cast, nullptr)) return false;
  brick.technique = Technique::cast;
  return true;
}

/// Can all that the picture shows of a node be drawn, if roughly?
bool SurfaceCut::can_show(const Place& at, double nearest, std::vector<LackingElement>& lacking) const {
  const SurfaceNode* const node = this->node(at);
  if (node == nullptr) {
    lack_page(at, nearest, lacking);
    return false;
  }
  PlacedBrick::Seen seen;
  if (!this->seen(at, *node, seen)) return true;
  if (node->resolved() || node->children == 0) {
    CutBrick here = brick(at, *node, seen);
    return ready(here, lacking);
  }
  bool all = true;
  const SurfaceNode copy = *node;
  for_children(at, copy, [&](const Place& below) { all = can_show(below, seen.nearest, lacking) && all; });
  return all;
}

void SurfaceCut::visit_resident(const Place& at, std::vector<LackingElement>& lacking) {
  const SurfaceNode* const node = this->node(at);
  PlacedBrick::Seen seen;
  if (node == nullptr || !this->seen(at, *node, seen)) return;
  const SurfaceNode copy = *node;
  if (refines(copy, seen)) {
    bool all = true;
    for_children(at, copy, [&](const Place& below) { all = can_show(below, seen.nearest, lacking) && all; });
    if (all || !copy.resolved()) {
      for_children(at, copy, [&](const Place& below) { visit_resident(below, lacking); });
      return;
    }
  }
  CutBrick here = brick(at, copy, seen);
  std::vector<LackingElement> ignored;
  if (ready(here, ignored)) bricks_.push_back(here);
}

void SurfaceCut::descend_resident(std::vector<LackingElement>& lacking) {
  bricks_.clear();
  const std::vector<Place> roots = std::exchange(waiting_, {});
  for (const Place& root : roots) {
    if (can_show(root, 0, lacking)) visit_resident(root, lacking);
  }
}

}  // namespace gvx::surface
