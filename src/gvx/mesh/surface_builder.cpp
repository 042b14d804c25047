#include "gvx/mesh/surface_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gvx/io/external_sort.h"
#include "gvx/mesh/corner_normals.h"
#include "gvx/mesh/surface_sampler.h"

namespace gvx::mesh {
namespace {

using surface::kCells;
using Parts = Vec3<std::int64_t>;

constexpr std::int64_t kBrickParts = kCells * kCellParts;
/// Triangles that are read at once.
constexpr std::size_t kBuffer = 4096;

/// How often a number came, by its logarithm.
class LogHistogram {
 public:
  void add(double value) {
    if (!(value > 0)) return;
    const double place = (std::log2(value) + kOctaves) * kSteps;
    ++count_[static_cast<std::size_t>(std::clamp(place, 0.0, double(count_.size() - 1)))];
    ++all_;
  }
  /// The number below which so many of all are.
  double quantile(double share) const {
    double left = share * static_cast<double>(all_);
    std::size_t place = 0;
    while (place + 1 < count_.size() && left >= static_cast<double>(count_[place]))
      left -= static_cast<double>(count_[place++]);
    return std::exp2((static_cast<double>(place) + 0.5) / kSteps - kOctaves);
  }

 private:
  static constexpr double kOctaves = 512, kSteps = 24;

  std::vector<std::uint64_t> count_ = std::vector<std::uint64_t>(std::size_t(2 * kOctaves * kSteps));
  std::uint64_t all_ = 0;
};

/// Calls function(triangle) for all of a mesh, in its order.
template <typename Function>
Status for_each_triangle(const MeshSpool& mesh, Function function) {
  const std::uint64_t all = mesh.summary().triangles;
  io::ScratchReader<SpooledTriangle> reader(mesh.triangles(), 0, all, kBuffer);
  for (std::uint64_t i = 0; i < all; ++i) {
    GVX_ASSIGN(const SpooledTriangle* triangle, reader.next());
    GVX_TRY(function(*triangle));
  }
  return {};
}

/// Where a brick of the finest level is.
struct BrickPlace {
  std::uint32_t x = 0, y = 0, z = 0;

  NodeKey key(std::uint32_t level) const { return {level, x, y, z}; }
  bool operator==(const BrickPlace&) const = default;
};

/// A triangle in one of the bricks that it meets.
struct BrickTriangle {
  BrickPlace brick;
  // Among all triangles, so that sums of attributes are the same however it is sorted.
  std::uint32_t order = 0;
  SurfaceTriangle triangle;
};
struct ByBrick {
  bool operator()(const BrickTriangle& a, const BrickTriangle& b) const {
    if (a.brick == b.brick) return a.order < b.order;
    return surface::before_in_tree(a.brick.key(0), b.brick.key(0));
  }
};

/// May a triangle meet a cube of this edge at `low`? By separating axes (Akenine-Moeller 2001); certain where
/// not.
bool may_meet(const std::array<Vec3d, 3>& corners, Vec3d low, double edge) {
  // The lines that are cut with triangles lie within the cube; rounding is less than this.
  constexpr double kMargin = 1;
  const double half = 0.5 * edge + kMargin;
  std::array<Vec3d, 3> from;  // the cube's middle
  for (std::size_t i = 0; i < 3; ++i) from[i] = corners[i] - (low + Vec3d(0.5 * edge));
  const auto apart = [&](Vec3d axis) {
    const double a = dot(axis, from[0]), b = dot(axis, from[1]), c = dot(axis, from[2]);
    const double reach = half * (std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z));
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  const Vec3d edges[3] = {from[1] - from[0], from[2] - from[1], from[0] - from[2]};
  if (apart(cross(edges[0], edges[1]))) return false;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d unit;
    unit[axis] = 1;
    if (apart(unit)) return false;
    for (const Vec3d& way : edges) {
      if (apart(cross(unit, way))) return false;
    }
  }
  return true;
}

/// Puts a triangle into all the bricks that it meets.
class Partition {
 public:
  using Sorter = io::ExternalSorter<BrickTriangle, ByBrick>;

  Partition(const SurfaceSpace& space, Sorter& sorter)
      : space_(space), last_((std::int64_t{1} << space.finest_level) - 1), sorter_(sorter) {}

  Status push(const SpooledTriangle& triangle, const std::array<Normal16, 3>& normals) {
    BrickTriangle record{{}, order_++, {}};
    Parts corner[3];
    std::array<Vec3d, 3> places;
    for (std::size_t i = 0; i < 3; ++i) {
      record.triangle.normal[i] = normals[i];
      record.triangle.color[i] = triangle.colors[i];
      const Vec3d cells = (triangle.corners[i] - space_.origin) / space_.cell;
      for (int axis = 0; axis < 3; ++axis) corner[i][axis] = std::llround(cells[axis] * double(kCellParts));
      places[i] = Vec3d(corner[i]);
    }
    const Parts first = bricks(corner, [](auto... v) { return std::min({v...}); });
    const Parts last = bricks(corner, [](auto... v) { return std::max({v...}); });
    const bool several = !(first == last);
    for (std::int64_t z = first.z; z <= last.z; ++z) {
      for (std::int64_t y = first.y; y <= last.y; ++y) {
        for (std::int64_t x = first.x; x <= last.x; ++x) {
          const Parts low = kBrickParts * Parts(x, y, z);
          if (several && !may_meet(places, Vec3d(low), double(kBrickParts))) continue;
          record.brick = {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                          static_cast<std::uint32_t>(z)};
          for (int i = 0; i < 3; ++i) record.triangle.corner[i] = Vec3<std::int32_t>(corner[i] - low);
          GVX_TRY(sorter_.push(record));
        }
      }
    }
    return {};
  }

 private:
  /// The bricks of the least or greatest corners.
  template <typename Choose>
  Parts bricks(const Parts (&corner)[3], Choose choose) const {
    Parts chosen;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t part = choose(corner[0][axis], corner[1][axis], corner[2][axis]);
      chosen[axis] = std::clamp<std::int64_t>(part / kBrickParts, 0, last_);
    }
    return chosen;
  }

  const SurfaceSpace& space_;
  std::int64_t last_;  // brick along an axis
  Sorter& sorter_;
  std::uint32_t order_ = 0;
};

/// Samples bricks whose triangles come one after the other.
class BrickSampling {
 public:
  BrickSampling(std::uint32_t level, surface::SurfacePyramid& pyramid) : level_(level), pyramid_(pyramid) {}

  Status push(const BrickTriangle& record) {
    if (brick_ && !(*brick_ == record.brick)) GVX_TRY(end_brick());
    brick_ = record.brick;
    sampler_.add(record.triangle);
    if (triangles_.triangles() == std::numeric_limits<std::uint32_t>::max() / 3) {
      return Error{"surface: too many triangles in one cell of its grid"};
    }
    triangles_.add(record.triangle.vertices());
    if (sampler_.samples().cells().empty()) between_lines_.push_back(record.triangle);
    return {};
  }
  Status finish() {
    if (brick_) GVX_TRY(end_brick());
    return pyramid_.finish();
  }

 private:
  Status end_brick() {
    if (sampler_.samples().cells().empty()) {
      for (const SurfaceTriangle& triangle : between_lines_) sampler_.add_corners(triangle);
    }
    between_lines_.clear();
    return pyramid_.push(brick_->key(level_), sampler_.take(), std::exchange(triangles_, {}));
  }

  std::uint32_t level_;
  surface::SurfacePyramid& pyramid_;
  std::optional<BrickPlace> brick_;
  SurfaceSampler sampler_;
  surface::TriangleList triangles_;
  std::vector<SurfaceTriangle> between_lines_;  // as long as there is no sample
};

}  // namespace

Result<double> cell_of(const MeshSpool& mesh) {
  LogHistogram edges;
  GVX_TRY(for_each_triangle(mesh, [&](const SpooledTriangle& triangle) -> Status {
    const auto& [a, b, c] = triangle.corners;
    std::array<double, 3> sorted = {length(b - a), length(c - b), length(a - c)};
    std::sort(sorted.begin(), sorted.end());
    edges.add(sorted[1]);
    return {};
  }));
  constexpr double kMedian = 0.5, kShare = 0.7;
  return kShare * edges.quantile(kMedian);
}

SurfaceSpace surface_space(const MeshSummary& mesh, double cell) {
  const Vec3d size = mesh.bounds.maximum - mesh.bounds.minimum;
  // A cell beside the surface on every side: rounded corners stay within.
  const double largest = std::max({size.x, size.y, size.z});
  SurfaceSpace space;
  space.cell = std::max(cell, largest / (double(kCells) * double(1u << kFinestSurface) - 2));
  while (space.finest_level < kFinestSurface &&
         space.brick() * double(1u << space.finest_level) < largest + 2 * space.cell) {
    ++space.finest_level;
  }
  space.origin = mesh.bounds.minimum - Vec3d(space.cell);
  return space;
}

Status build_surface(const MeshSpool& mesh, const SurfaceSpace& space, std::uint64_t memory_bytes,
                     const surface::SurfacePyramid::Take& take, const SurfaceProgress& progress) {
  const std::uint64_t all = mesh.summary().triangles;
  if (all > std::numeric_limits<std::uint32_t>::max()) {
    return Error{"surface: " + std::to_string(all) + " triangles; at most 4294967295 can be built"};
  }
  const auto report = [&](const char* what, std::uint64_t done) {
    if (progress && (done % 1024 == 0 || done == all)) progress(what, done, all);
  };
  std::uint64_t done = 0;
  CornerNormals normals(mesh.folder(), memory_bytes / 2, all);
  GVX_TRY(for_each_triangle(mesh, [&](const SpooledTriangle& triangle) -> Status {
    report("reading", ++done);
    return normals.push(corners_in(triangle, space.origin, space.cell));
  }));

  // A triangle may be in any number of bricks.
  Partition::Sorter sorter(mesh.folder(), memory_bytes / 2, std::numeric_limits<std::uint64_t>::max() - 1,
                           {});
  Partition partition(space, sorter);
  io::ScratchReader<SpooledTriangle> again(mesh.triangles(), 0, all, kBuffer);
  done = 0;
  GVX_TRY(normals.for_each([&](const std::array<Normal16, 3>& of_corners) -> Status {
    GVX_ASSIGN(const SpooledTriangle* triangle, again.next());
    report("sorting", ++done);
    return partition.push(*triangle, of_corners);
  }));

  surface::SurfacePyramid pyramid(space.finest_level, take);
  BrickSampling sampling(space.finest_level, pyramid);
  done = 0;
  GVX_TRY(sorter.for_each([&](const BrickTriangle& record) {
    report("sampling", std::min(++done, all));
    return sampling.push(record);
  }));
  return sampling.finish();
}

}  // namespace gvx::mesh
