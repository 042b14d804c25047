/// \file
/// SampledCells: the surface in a brick while it is made. A cell may be found several times, along each of
/// three axes and of several triangles; its attributes are then the mean.
#pragma once

#include <cstdint>
#include <vector>

#include "gvx/core/vec.h"
#include "gvx/surface/cell_set.h"
#include "gvx/surface/sample_attributes.h"

namespace gvx::surface {

class SampledCells {
 public:
  SampledCells() : slot_(kCells * kCells * kCells, 0) {}

  /// The surface is in a cell, with a unit normal and a colour of 0 to 1.
  void add(Cell cell, Vec3f normal, Vec3f color);
  /// All of the cells of a brick that is twice as fine, which is this one's child: x + 2 * (y + 2 * z) of
  /// eight.
  void add_finer(const SampledCells& child, int octant);

  const CellSet& cells() const { return cells_; }
  /// Of a cell that is there. A sheet that is thinner than a cell has two sides, whose normals would cancel
  /// out: the one that was found more often is kept, with its colour.
  SampleAttributes attributes(Cell cell) const;
  /// The axis along which the surface's normals mostly point.
  int primary_axis() const;

 private:
  struct Side {
    Vec3f normal, color;
    float count = 0;
  };
  struct Sums {
    Cell cell;
    Side front, back;  // that point as the first one that was found, and against it
    const Side& kept() const { return front.count >= back.count ? front : back; }
  };
  static std::size_t at(Cell c) {
    const int cell = c.x + kCells * (c.y + kCells * c.z);
    return static_cast<std::size_t>(cell);
  }
  Sums& sums_of(Cell cell);

  CellSet cells_;
  std::vector<std::uint16_t> slot_;  // of each cell, its place in sums_ and 1 more; 0: none
  std::vector<Sums> sums_;
};

}  // namespace gvx::surface
