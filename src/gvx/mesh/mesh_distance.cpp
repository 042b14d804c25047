#include "gvx/mesh/mesh_distance.h"

#include <algorithm>
#include <cmath>

namespace gvx::mesh {
namespace {

/// Of distances in single precision near the unit cube.
constexpr double kRounding = 1e-5;

/// The distances of all that is in the box, no farther from 0 than `band`. Where the box is off the surface
/// all of it is on the side of its middle: of a mesh with holes that is a convention.
ValueRange distances_in(const MeshQuery& mesh, const Box3d& box, double band) {
  const Vec3f middle(0.5 * (box.minimum + box.maximum));
  const double radius = 0.5 * length(box.maximum - box.minimum) + kRounding;
  const auto nearest = mesh.nearest(middle, static_cast<float>(band + radius));
  const double away = nearest ? nearest->distance : band + radius;
  const auto least = static_cast<float>(std::min(away - radius, band)),
             most = static_cast<float>(std::min(away + radius, band));
  if (least <= 0) return {-most, most};
  return mesh.inside(middle) ? ValueRange{-most, -least} : ValueRange{least, most};
}

}  // namespace

PlacedMesh PlacedMesh::in_cube(io::TriangleMesh mesh, double margin) {
  const Box3d box = mesh.bounds();
  const double size = std::max(max_component(box.maximum - box.minimum), 1e-30) / (1 - 2 * margin);
  const Vec3d middle = 0.5 * (box.minimum + box.maximum), origin = middle - Vec3d(0.5 * size);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices[v] = Vec3f((mesh.place(v) - origin) / size);
  mesh.origin = {};
  PlacedMesh placed{std::move(mesh), scaling(Vec3d(size)), {}};
  placed.tree_to_world.origin = origin;
  const Vec3d half = 0.5 * (box.maximum - box.minimum) / size + Vec3d(margin);
  placed.extent = {Vec3d(0.5) - half, Vec3d(0.5) + half};
  return placed;
}

void MeshDistanceField::sample(const produce::VoxelBlock& block, std::span<float> values) const {
  const auto band = static_cast<float>(band_), spacing = static_cast<float>(block.spacing);
  const Vec3d low = block.first, high = block.centre(block.edge - 1, block.edge - 1, block.edge - 1);
  const ValueRange all = distances_in(*mesh_, {low, high}, band_);
  if (all.constant()) {
    std::fill(values.begin(), values.end(), all.minimum);
    return;
  }
  produce::for_each_row(block, values, [&](Vec3d first, std::span<float> row) {
    float before = band;
    bool inside = false, known = false;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const Vec3f p(first + Vec3d(static_cast<double>(i) * block.spacing, 0, 0));
      // No farther than a voxel more than the one before.
      const float radius = std::min(band, before + spacing * 1.01f + 1e-6f);
      const auto nearest = mesh_->nearest(p, i == 0 ? band : radius);
      const float away = nearest ? nearest->distance : band;
      // Between voxels that are farther from the surface than from each other it does not pass.
      if (!known || before <= spacing * 1.01f) inside = mesh_->inside(p);
      known = true;
      before = away;
      row[i] = inside ? -away : away;
    }
  });
}

ValueRange MeshDistanceField::bounds(const Box3d& box, double) const {
  return distances_in(*mesh_, box, band_);
}

void AxisDistanceField::sample(const produce::VoxelBlock& block, std::span<float> values) const {
  const std::size_t edge = block.edge;
  // Of each voxel the sum over the axes of the inverse squares of what its lines find, and how many of them
  // find it inside.
  thread_local std::vector<float> inverse_squares;
  thread_local std::vector<MeshQuery::Crossing> crossings;
  thread_local std::vector<std::uint8_t> inside;
  inverse_squares.assign(values.size(), 0);
  inside.assign(values.size(), 0);
  const auto band = static_cast<float>(band_);
  const std::size_t stride[3] = {1, edge, edge * edge};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (std::size_t j = 0; j < edge; ++j) {
      for (std::size_t k = 0; k < edge; ++k) {
        Vec3d start = block.first;
        // A little aside, since edges of what people model lie on a grid: a line through one crosses twice.
        start[u] += (static_cast<double>(j) + 0.0137) * block.spacing;
        start[v] += (static_cast<double>(k) + 0.0071) * block.spacing;
        start[axis] -= band_;
        mesh_->crossings(Vec3f(start), axis, crossings);
        std::size_t behind = 0;  // the first crossing behind the voxel
        for (std::size_t i = 0; i < edge; ++i) {
          const auto here = static_cast<float>(band_ + static_cast<double>(i) * block.spacing);
          while (behind < crossings.size() && crossings[behind].distance <= here) ++behind;
          float away = band;
          if (behind < crossings.size()) away = std::min(away, crossings[behind].distance - here);
          if (behind > 0) away = std::min(away, here - crossings[behind - 1].distance);
          const std::size_t at = i * stride[axis] + j * stride[u] + k * stride[v];
          if (away < band) inverse_squares[at] += 1 / (away * away + 1e-20f);
          if (mesh_->tells_inside(std::span(crossings).subspan(behind))) ++inside[at];
        }
      }
    }
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float away = inverse_squares[i] > 0 ? std::min(band, 1 / std::sqrt(inverse_squares[i])) : band;
    values[i] = inside[i] >= 2 ? -away : away;
  }
}

ValueRange AxisDistanceField::bounds(const Box3d& box, double) const {
  const ValueRange d = distances_in(*mesh_, box, band_);
  const auto band = static_cast<float>(band_);
  // A line finds nothing nearer than the nearest point; three that find as much make it a root of 3 less. The
  // other way there is no bound: lines may find nothing.
  const double least = (d.minimum > 0   ? d.minimum
                        : d.maximum < 0 ? -d.maximum
                                        : 0) /
                           std::sqrt(3.0) -
                       kRounding;
  // Near a hole, or an edge that a line meets, lines disagree with MeshQuery::inside.
  if (least <= 0) return {-band, band};
  const auto away = static_cast<float>(least);
  return d.minimum > 0 ? ValueRange{away, band} : ValueRange{-band, -away};
}

}  // namespace gvx::mesh
