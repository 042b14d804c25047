#include "gvx/mesh/mesh_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gvx/exec/parallel.h"
#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_query.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/shape_check.h"
#include "gvx/store/store_writer.h"

namespace gvx::mesh {
namespace {

constexpr VoxelFormat kFormat{VoxelType::u8, VoxelContent::color_normal, 7};
/// Voxels around the mesh that are empty: a border and what a surface's thickness takes.
constexpr std::int64_t kMargin = 3;
/// Edge of the blocks that are passed over where no surface is near.
constexpr std::int64_t kBlock = MeshSlabs::kBlock;
/// Of a slab's: what is said of it, and Embree's hierarchy while it is made.
constexpr std::uint64_t kBytesPerTriangle = 256;
/// Embree takes vertices of 16 GiB at most.
constexpr std::uint64_t kMostTriangles = 400'000'000;
/// A slab that held fewer would be hardly worth its while.
constexpr std::uint64_t kLeastTriangles = 1 << 12;

using Voxel = std::array<std::uint8_t, kFormat.planes>;
constexpr Voxel kEmpty = {0, 0, 0, 0, 127, 127, 127};

Voxel voxel_of(Vec3f color, float opacity, Vec3f normal) {
  const auto byte = [](float v) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0f, 255.0f)));
  };
  Voxel voxel{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    voxel[axis] = byte(255 * opacity * color[static_cast<int>(axis)]);
    voxel[4 + axis] = byte(127 + 127 * opacity * normal[static_cast<int>(axis)]);
  }
  voxel[3] = byte(255 * opacity);
  return voxel;
}

/// What stands at a triangle's corners.
struct Corners {
  std::array<Normal16, 3> normals;
  std::array<Rgb8, 3> colors;
};

template <typename Number>
Vec3f mixed(const std::array<float, 3>& weights, const std::array<std::array<Number, 3>, 3>& corners) {
  Vec3f sum;
  for (std::size_t k = 0; k < 3; ++k) {
    sum = sum + weights[k] * Vec3f(Vec3<Number>(corners[k][0], corners[k][1], corners[k][2]));
  }
  return sum / static_cast<float>(std::numeric_limits<Number>::max());
}

/// Makes the voxels of a slab. Space is that of the voxels: voxel i covers i to i + 1.
class MeshVoxels {
 public:
  /// Reads the triangles that are near to the slab.
  static Result<MeshVoxels> load(const MeshSlabs& slabs, const MeshSlabs::Slab& slab, Vec3i dimensions,
                                 InsideRule rule, Vec3f inner_color) {
    MeshVoxels voxels(slab, dimensions, rule != InsideRule::none, inner_color);
    if (slab.count == 0) return voxels;
    io::TriangleMesh mesh;
    mesh.vertices.reserve(static_cast<std::size_t>(3 * slab.count + 1));
    mesh.triangles.reserve(static_cast<std::size_t>(slab.count));
    voxels.corners_.reserve(static_cast<std::size_t>(slab.count));
    std::vector<SlabTriangle> some;
    for (std::uint64_t i = 0; i < slab.count; i += some.size()) {
      some.resize(static_cast<std::size_t>(std::min<std::uint64_t>(slab.count - i, 4096)));
      GVX_TRY(slabs.read(slab, i, some));
      for (const SlabTriangle& triangle : some) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), triangle.corners.begin(), triangle.corners.end());
        mesh.triangles.push_back({first, first + 1, first + 2});
        voxels.corners_.push_back({triangle.normals, triangle.colors});
      }
    }
    GVX_ASSIGN(voxels.query_, MeshQuery::create(std::move(mesh), rule));
    return voxels;
  }

  /// The slab's rows of slices z to z + count, which are in it; `slices` are dimensions.x * dimensions.y
  /// voxels each.
  void fill(const exec::Device& cpu, std::int64_t z, std::int64_t count, std::span<Voxel> slices) const {
    const std::int64_t rows = (slab_.y_end - slab_.y_begin + kBlock - 1) / kBlock;
    exec::parallel_for(cpu, static_cast<std::size_t>(rows), [&](std::size_t row) {
      fill_row(slab_.y_begin + static_cast<std::int64_t>(row) * kBlock, z, count, slices);
    });
  }

 private:
  MeshVoxels(const MeshSlabs::Slab& slab, Vec3i dimensions, bool solid, Vec3f inner_color)
      : slab_(slab), dimensions_(dimensions), solid_(solid), inner_color_(inner_color) {}

  /// Blocks side by side along x, from (y, z) on.
  void fill_row(std::int64_t y, std::int64_t z, std::int64_t count, std::span<Voxel> slices) const {
    const std::int64_t y_end = std::min(y + kBlock, slab_.y_end);
    // Of each line along x, where it goes in or out.
    std::vector<std::vector<float>> changes;
    if (solid_ && query_) changes = lines(y, y_end, z, count);
    const Vec3f half(kBlock / 2.0f);
    const float radius = length(half) + reach();
    for (std::int64_t x = 0; x < dimensions_.x; x += kBlock) {
      const std::int64_t x_end = std::min(x + kBlock, dimensions_.x);
      const bool near = query_ && query_->nearest(Vec3f(Vec3d(Vec3i(x, y, z))) + half, radius).has_value();
      for (std::int64_t k = 0; k < count; ++k) {
        for (std::int64_t j = y; j < y_end; ++j) {
          Voxel* out = &slices[static_cast<std::size_t>((k * dimensions_.y + j) * dimensions_.x)];
          const std::vector<float>* line =
              !changes.empty() ? &changes[static_cast<std::size_t>(k * (y_end - y) + j - y)] : nullptr;
          for (std::int64_t i = x; i < x_end; ++i) {
            const Vec3f centre(Vec3d(Vec3i(i, j, z + k)) + Vec3d(0.5));
            const bool inside = line != nullptr && is_inside(*line, centre.x);
            out[i] = near ? voxel_at(centre, inside) : far_voxel(inside);
          }
        }
      }
    }
  }

  std::vector<std::vector<float>> lines(std::int64_t y, std::int64_t y_end, std::int64_t z,
                                        std::int64_t count) const {
    std::vector<std::vector<float>> changes(static_cast<std::size_t>(count * (y_end - y)));
    std::size_t i = 0;
    for (std::int64_t k = 0; k < count; ++k) {
      for (std::int64_t j = y; j < y_end; ++j, ++i) {
        // A little aside of the middle, where modelled edges are.
        (void)line(static_cast<float>(j) + 0.5f, static_cast<float>(z + k) + 0.5f,
                   {0.0137f, 0.0313f, -0.0271f, 0.0517f, -0.0411f}, changes[i]);
      }
    }
    return changes;
  }

  /// Where the line along x through y and z goes in or out. It is drawn so far aside; again, at the next
  /// distance, where it met an edge and so does not end outside. False where none does.
  bool line(float y, float z, std::initializer_list<float> asides, std::vector<float>& changes) const {
    thread_local std::vector<MeshQuery::Crossing> crossings;
    bool outside = false;
    for (const float aside : asides) {
      query_->crossings(Vec3f(0, y + aside, z + 0.7f * aside), 0, crossings);
      outside = query_->ends_outside(crossings);
      if (outside) break;
    }
    query_->changes(crossings, changes);
    return outside;
  }

  static bool is_inside(const std::vector<float>& changes, float x) {
    return (std::upper_bound(changes.begin(), changes.end(), x) - changes.begin()) % 2 != 0;
  }

  /// Does the solid end at a point of the surface that is the nearest to p, which is inside? Not where
  /// another part goes on behind it.
  bool ends_solid(Vec3f p, const MeshQuery::Nearest& found) const {
    const Vec3f at = query_->place(found);
    const bool apart = found.distance > kBehind;
    const io::Triangle& t = query_->mesh().triangles[found.triangle];
    const std::vector<Vec3f>& v = query_->mesh().vertices;
    const Vec3f way = apart ? at - p : cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
    if (!(length(way) > 0)) return true;
    const Vec3f step = kBehind / length(way) * way;
    thread_local std::vector<float> changes;
    const auto outside = [&](Vec3f q) {
      return !line(q.y, q.z, {0, 0.0023f, -0.0019f}, changes) || !is_inside(changes, q.x);
    };
    return outside(at + step) || (!apart && outside(at - step));
  }

  /// Farther from the surface than this a voxel needs to know no more of it.
  float reach() const { return solid_ ? kInnerReach : kShellReach; }

  Voxel far_voxel(bool inside) const { return inside ? voxel_of(inner_color_, 1, {}) : kEmpty; }

  Voxel voxel_at(Vec3f p, bool inside) const {
    const float radius = !solid_ ? kShellReach : inside ? kInnerReach : 0.5f;
    const auto nearest =
        inside ? query_->nearest_that(p, radius, [&](const auto& one) { return ends_solid(p, one); })
               : query_->nearest(p, radius);
    if (!nearest) return far_voxel(inside);
    const float d = nearest->distance;
    // A plane through the middle of a voxel's neighbours covers this much of it.
    const float opacity = !solid_  ? std::clamp(kShellReach - d, 0.0f, 1.0f)
                          : inside ? std::min(0.5f + d, 1.0f)
                                   : 0.5f - d;
    return voxel_of(color_of(*nearest), opacity, normal_of(*nearest));
  }

  Vec3f color_of(const MeshQuery::Nearest& nearest) const {
    return mixed(nearest.weights, corners_[nearest.triangle].colors);
  }

  Vec3f normal_of(const MeshQuery::Nearest& nearest) const {
    const Vec3f normal = mixed(nearest.weights, corners_[nearest.triangle].normals);
    return length(normal) > 0 ? normalize(normal) : normal;
  }

  /// So deep below the surface voxels have its colour and normal: as far as those on it are blended with.
  static constexpr float kInnerReach = 1.6f;
  /// What is behind a surface is looked up at this distance: of thinner gaps nothing can be seen.
  static constexpr float kBehind = 0.02f;
  /// From the middle of a shell to where it ends: thinner ones let light through between two voxels.
  static constexpr float kShellReach = 1.25f;

  MeshSlabs::Slab slab_;
  Vec3i dimensions_;
  bool solid_;
  Vec3f inner_color_;
  std::unique_ptr<MeshQuery> query_;  // none where no triangle is near
  std::vector<Corners> corners_;
};

}  // namespace

Result<MeshStoreReport> build_mesh_store(const exec::Device& cpu, const MeshSpool& mesh,
                                         const std::string& path, const MeshStoreOptions& options,
                                         const MeshBuildProgress& progress) {
  if (cpu.kind() != exec::DeviceKind::cpu) {
    return Error{"build_mesh_store: runs on the CPU only; expected Device::cpu()"};
  }
  GVX_TRY(store::check_tree(options.n, options.m));
  if (options.resolution < 1) {
    return Error{options.source + ": a resolution of " + std::to_string(options.resolution) +
                 " voxels; expected 1 or more"};
  }
  const Box3d& box = mesh.summary().bounds;
  const double size = max_component(box.maximum - box.minimum);
  if (!(size > 1e-30 && size < 1e30)) {
    return Error{options.source + ": the mesh has no size that voxels can have, 1e-30 to 1e30"};
  }
  const double voxel = size / static_cast<double>(options.resolution);
  store::VolumeInfo info;
  Vec3i dimensions;
  for (int axis = 0; axis < 3; ++axis) {
    const double voxels = std::ceil((box.maximum[axis] - box.minimum[axis]) / voxel);
    dimensions[axis] = std::max<std::int64_t>(static_cast<std::int64_t>(voxels), 1) + 2 * kMargin;
  }
  info.shape = store::TreeShape::covering(dimensions, options.n, options.m);
  info.format = kFormat;
  info.codec = options.codec;
  info.source = options.source;
  info.voxel_to_world = scaling(Vec3d(voxel));
  info.voxel_to_world.origin = box.minimum - Vec3d(static_cast<double>(kMargin) * voxel);
  info.up = options.up;
  const Vec3d margin(static_cast<double>(kMargin));
  info.bounds = Box3d{margin, margin + (box.maximum - box.minimum) / voxel};

  const std::uint64_t slice =
      store::saturating_product(static_cast<std::uint64_t>(dimensions.x * dimensions.y), sizeof(Voxel));
  const std::uint64_t slices_bytes = store::PyramidBuilder::window_bytes(info) + kBlock * slice;
  const std::uint64_t needed = slices_bytes + kLeastTriangles * kBytesPerTriangle;
  const auto too_much = [&](const std::string& what) {
    return Error{options.source + ": " + std::to_string(options.resolution) + " voxels across need " + what +
                 "; " + store::mebibytes(options.memory_bytes) + " are allowed (--memory)"};
  };
  if (needed > options.memory_bytes) return too_much(store::mebibytes(needed) + " of memory");
  const std::uint64_t most =
      std::min((options.memory_bytes - slices_bytes) / kBytesPerTriangle, kMostTriangles);
  GVX_ASSIGN(const std::optional<MeshSlabs> slabs,
             MeshSlabs::sort(mesh, {info.voxel_to_world.origin, voxel, dimensions}, options.memory_bytes,
                             most, progress));
  if (!slabs) return too_much("more memory, as too many triangles are in one place");

  GVX_ASSIGN(const auto writer, store::StoreWriter::create(path, info.shape, info.format));
  store::PyramidBuilder pyramid(cpu, *writer, info);
  std::vector<Voxel> slices(static_cast<std::size_t>(kBlock * dimensions.x * dimensions.y));
  const std::vector<MeshSlabs::Slab>& all = slabs->slabs();
  const InsideRule rule = !options.solid            ? InsideRule::none
                          : mesh.summary().closed() ? mesh.summary().inside
                                                    : InsideRule::parity;
  bool covered = false;  // any voxel
  for (std::size_t i = 0; i < all.size(); ++i) {
    GVX_ASSIGN(const MeshVoxels voxels,
               MeshVoxels::load(*slabs, all[i], dimensions, rule, mesh.summary().mean_color));
    for (std::int64_t z = all[i].z_begin; z < all[i].z_end; z += kBlock) {
      const std::int64_t count = std::min(kBlock, all[i].z_end - z);
      const std::span<Voxel> used(slices.data(),
                                  static_cast<std::size_t>(count * dimensions.x * dimensions.y));
      voxels.fill(cpu, z, count, used);
      // Of several slabs side by side the last fills the slices up.
      if (all[i].y_end < dimensions.y) continue;
      covered = covered || std::any_of(used.begin(), used.end(), [](const Voxel& v) { return v[3] > 0; });
      GVX_TRY(pyramid.push_slices(count, std::as_bytes(used)));
      if (progress) {
        const std::int64_t slice_voxels = dimensions.x * dimensions.y;
        progress("building", static_cast<std::uint64_t>(slice_voxels * (z + count)),
                 static_cast<std::uint64_t>(slice_voxels * dimensions.z));
      }
    }
  }
  if (!covered) {
    return Error{options.source + ": the mesh covers no voxel at " + std::to_string(options.resolution) +
                 " voxels across"};
  }
  GVX_TRY(pyramid.finish());
  return MeshStoreReport{dimensions, writer->bytes_written(), all.size()};
}

}  // namespace gvx::mesh
