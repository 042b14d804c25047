/// \file
/// cast: where a ray first meets the cells of a surface brick: the plain way, one ray at a time, which says
/// what faster ones must find.
///
/// The ray is projected into the primary grid and goes from column to column (a DDA: Amanatides and Woo
/// 1987); in each, the cells between its depths where it enters and leaves are one mask. Blocks of columns
/// that lie wholly above or below the ray are passed at once.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/ray.h"
#include "gvx/surface/surface_brick.h"

namespace gvx::surface {

struct CastHit {
  bool hit = false;
  Cell cell;         ///< of the brick
  double enter = 0;  ///< the ray's distance where it comes to the cell
  double exit = 0;   ///< and where it leaves it
  std::uint32_t rank = 0;
};

/// A ray through a grid of columns.
class GridRay {
 public:
  /// `ray` in cells, in the grid's axes: u, v, w.
  GVX_HD explicit GridRay(const Ray& ray) : ray_(ray) {
    for (int axis = 0; axis < 3; ++axis) inverse_[axis] = 1 / ray.direction[axis];
  }

  /// The distance at which it comes to a plane across an axis; infinite where it never does.
  GVX_HD double at_plane(int axis, double place) const {
    return ray_.direction[axis] != 0 ? (place - ray_.origin[axis]) * inverse_[axis] : INFINITY;
  }
  /// The distance at which it leaves `count` cells that begin with `first` along an axis.
  GVX_HD double leaves(int axis, int first, int count) const {
    return at_plane(axis, ray_.direction[axis] > 0 ? first + count : first);
  }
  GVX_HD double enters(int axis, int first) const {
    return ray_.direction[axis] != 0 ? at_plane(axis, ray_.direction[axis] > 0 ? first : first + 1)
                                     : -INFINITY;
  }
  /// The cell along an axis at a distance.
  GVX_HD int cell_at(int axis, double t) const {
    const double place = std::floor(ray_.origin[axis] + t * ray_.direction[axis]);
    return place > 0 ? (place < kCells ? static_cast<int>(place) : kCells - 1) : 0;
  }
  GVX_HD bool rises(int axis) const { return ray_.direction[axis] >= 0; }

 private:
  Ray ray_;
  Vec3d inverse_;
};

/// The way of a ray through some columns, from distance `t` on.
struct ColumnStep {
  double end;     ///< the distance at which it leaves them, or ends
  double leaves;  ///< the distance at which it leaves them
  bool along_u;   ///< for others beside them along u, else along v
  bool last;      ///< the ray ends within them
  int low, high;  ///< depths that it comes through

  /// `count` x `count` columns, the first of them (u, v), of a ray that ends at `exit`.
  GVX_HD ColumnStep(const GridRay& ray, int u, int v, int count, double t, double exit) {
    const double leaves_u = ray.leaves(0, u, count), leaves_v = ray.leaves(1, v, count);
    along_u = leaves_u < leaves_v;
    end = leaves = along_u ? leaves_u : leaves_v;
    last = !(end < exit);
    if (last) end = exit;
    const int first = ray.cell_at(2, t), behind = ray.cell_at(2, end);
    low = first < behind ? first : behind;
    high = first < behind ? behind : first;
  }
};

/// Between the distances of `within`, of a ray in cells of the brick, 0 to kCells along each axis; its
/// direction may be of any length.
GVX_HD inline CastHit cast(const SurfaceBrickView& brick, const Ray& ray, const RayInterval& within) {
  constexpr int kBlock = SurfaceBrickView::kBlock;
  const GridAxes axes(brick.axis);
  const Ray turned{axes.to_grid(ray.origin), axes.to_grid(ray.direction)};
  const RayInterval inside = intersect(turned, {{0, 0, 0}, Vec3d(double(kCells))}, within.enter, within.exit);
  CastHit found;
  if (!(inside.enter <= inside.exit)) return found;
  const GridRay through(turned);
  int u = through.cell_at(0, inside.enter), v = through.cell_at(1, inside.enter);
  double t = inside.enter;
  while (u >= 0 && u < kCells && v >= 0 && v < kCells) {
    const int block_u = u / kBlock * kBlock, block_v = v / kBlock * kBlock;
    const ColumnStep over_block(through, block_u, block_v, kBlock, t, inside.exit);
    const bool passes_block = !brick.block(u, v).meets(over_block.low, over_block.high);
    const ColumnStep step = passes_block ? over_block : ColumnStep(through, u, v, 1, t, inside.exit);
    const std::uint32_t cells =
        passes_block ? 0 : brick.grid.column(u, v) & bits_between(step.low, step.high);
    if (cells != 0) {
      const int w = through.rises(2) ? lowest_bit(cells) : highest_bit(cells);
      const double enters = through.enters(2, w), leaves = through.leaves(2, w, 1);
      found.hit = true;
      found.cell = axes.from_grid(Cell(u, v, w));
      found.enter = enters > t ? enters : t;
      // Where the cell ends, whatever ends the ray: so what is found does not depend on that.
      found.exit = leaves < step.leaves ? leaves : step.leaves;
      if (found.exit < found.enter) found.exit = found.enter;
      found.rank = brick.grid.rank(u, v, w);
      return found;
    }
    if (step.last) return found;
    t = step.end;
    // Of the other axis the ray is still among the columns that were passed, whatever rounding says.
    const int count = passes_block ? kBlock : 1, first_u = passes_block ? block_u : u,
              first_v = passes_block ? block_v : v;
    const auto within_step = [&](int axis, int first) {
      const int cell = through.cell_at(axis, t);
      return cell < first ? first : cell < first + count ? cell : first + count - 1;
    };
    if (step.along_u) {
      u = through.rises(0) ? first_u + count : first_u - 1;
      v = within_step(1, first_v);
    } else {
      u = within_step(0, first_u);
      v = through.rises(1) ? first_v + count : first_v - 1;
    }
  }
  return found;
}

}  // namespace gvx::surface
