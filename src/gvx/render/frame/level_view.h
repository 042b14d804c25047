/// \file
/// LevelView: the nodes of one level as they lie around the eye. Places in tree space are told from the eye,
/// and nodes are counted from the one that the eye is in: what is near has small numbers, so that no digits
/// are lost however deep in the tree the eye is.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"

namespace gvx::render {

struct LevelView {
  double across = 1;  ///< nodes along an axis of tree space
  /// Of a node: their sum. A whole number below 2^27 times the former is exact.
  double edge_high = 1, edge_low = 0;
  Vec3d corner_high, corner_low;  ///< the low corner of the eye's node: their sum
  Vec3d first, last;              ///< nodes that hold some of the visible volume, counted from the eye's
  Vec3d digit;                    ///< the eye's node's place among the children of the eye's node above
  Vec3<std::uint64_t> eye;        ///< the eye's node, counted from the corner of tree space, modulo 2^64

  /// Where the low face of node `cell` lies. As if rounded once: where faces of nodes of two levels meet,
  /// both give the same.
  GVX_HD double face(int axis, double cell) const {
    const double offset = cell * edge_high, corner = corner_high[axis];
    const double sum = offset + corner, corner_in = sum - offset;
    const double error = (offset - (sum - corner_in)) + (corner - corner_in);
    return sum + (error + (cell * edge_low + corner_low[axis]));
  }
  GVX_HD Vec3d corner(Vec3d cell) const { return {face(0, cell.x), face(1, cell.y), face(2, cell.z)}; }

  /// The node that holds a place, which is in the visible volume.
  GVX_HD double cell_at(int axis, double p) const {
    const double cell = std::floor((p - corner_high[axis]) * across);
    // Rounding, or a ray in the plane of a face, can put a sample a hair outside the volume's box.
    return cell < first[axis] ? first[axis] : cell < last[axis] ? cell : last[axis];
  }
  /// The node of the level above that holds a node.
  GVX_HD Vec3d parent(Vec3d cell, int n) const {
    return {std::floor((cell.x + digit.x) / n), std::floor((cell.y + digit.y) / n),
            std::floor((cell.z + digit.z) / n)};
  }
  /// A node's place among the children of that.
  GVX_HD Vec3d child(Vec3d cell, int n) const { return cell + digit - double(n) * parent(cell, n); }
};

}  // namespace gvx::render
