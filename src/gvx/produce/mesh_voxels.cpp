#include "gvx/produce/mesh_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "gvx/exec/parallel.h"
#include "gvx/produce/mesh_query.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/store_writer.h"

namespace gvx::produce {
namespace {

constexpr VoxelFormat kFormat{VoxelType::u8, VoxelContent::color_normal, 7};
/// Voxels around the mesh that are empty: a border and what a surface's thickness takes.
constexpr std::int64_t kMargin = 3;
/// Edge of the blocks that are passed over where no surface is near.
constexpr std::int64_t kBlock = 8;
/// Of the mesh, Embree's hierarchy, and finding the corners' normals, about.
constexpr std::uint64_t kBytesPerTriangle = 320;
constexpr std::uint64_t kBytesPerVertex = 48;
/// Between triangles that turn by more than this the surface has an edge: the cosine of 45 degrees.
constexpr float kEdge = 0.7071f;

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

/// For each vertex the first that stands where it does: files often repeat one for each of its triangles.
std::vector<std::uint32_t> first_at_place(const io::TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), first(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    const Vec3f v = mesh.vertices[i];
    return std::array{v.x, v.y, v.z};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
  }
  return first;
}

/// Of each triangle's corners: the mean of those triangles there that go on smoothly, by their angles
/// (Thuermer and Wuethrich 1998).
std::vector<std::array<Vec3f, 3>> corner_normals(const io::TriangleMesh& mesh) {
  struct Corner {
    std::uint32_t place, triangle, index;
    Vec3f flat;
    float angle;
  };
  const std::vector<std::uint32_t> place = first_at_place(mesh);
  std::vector<Corner> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Vec3f here = mesh.vertices[triangle[k]];
      const Vec3f a = mesh.vertices[triangle[(k + 1) % 3]] - here,
                  b = mesh.vertices[triangle[(k + 2) % 3]] - here;
      const Vec3f across = cross(a, b);
      const float sine = length(across);
      const Vec3f flat = sine > 0 ? across / sine : Vec3f();
      corners.push_back({place[triangle[k]], t, k, flat, std::atan2(sine, dot(a, b))});
    }
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return std::tie(a.place, a.triangle, a.index) < std::tie(b.place, b.triangle, b.index);
  });
  std::vector<std::array<Vec3f, 3>> normals(mesh.triangles.size());
  for (std::size_t begin = 0, end = 0; begin < corners.size(); begin = end) {
    while (end < corners.size() && corners[end].place == corners[begin].place) ++end;
    // A hub of very many triangles would take the square of their number.
    constexpr std::size_t kMostAround = 256;
    for (std::size_t i = begin; i < end; ++i) {
      Vec3f sum = corners[i].flat;
      if (end - begin <= kMostAround) {
        sum = {};
        for (std::size_t j = begin; j < end; ++j) {
          if (dot(corners[i].flat, corners[j].flat) >= kEdge) sum = sum + corners[j].angle * corners[j].flat;
        }
      }
      normals[corners[i].triangle][corners[i].index] = length(sum) > 0 ? normalize(sum) : corners[i].flat;
    }
  }
  return normals;
}

/// Makes slices of voxels. Space is that of the voxels: voxel i covers i to i + 1.
class MeshVoxels {
 public:
  MeshVoxels(const MeshQuery& query, Vec3i dimensions, bool solid)
      : query_(query),
        mesh_(query.mesh()),
        normals_(corner_normals(mesh_)),
        dimensions_(dimensions),
        solid_(solid) {
    Vec3d sum;
    for (const Vec3f& color : mesh_.colors) sum = sum + Vec3d(color);
    if (!mesh_.colors.empty()) inner_color_ = Vec3f(sum / static_cast<double>(mesh_.colors.size()));
  }

  /// Slices z to z + count, each of dimensions.x * dimensions.y voxels.
  void fill(const exec::Device& cpu, std::int64_t z, std::int64_t count, std::span<Voxel> slices) const {
    const std::int64_t rows = (dimensions_.y + kBlock - 1) / kBlock;
    exec::parallel_for(cpu, static_cast<std::size_t>(rows), [&](std::size_t row) {
      fill_row(static_cast<std::int64_t>(row) * kBlock, z, count, slices);
    });
  }

 private:
  /// Blocks side by side along x, from (y, z) on.
  void fill_row(std::int64_t y, std::int64_t z, std::int64_t count, std::span<Voxel> slices) const {
    const std::int64_t y_end = std::min(y + kBlock, dimensions_.y);
    // Of each line along x, where it crosses the surface.
    std::vector<std::vector<float>> crossings;
    if (solid_) crossings = lines(y, y_end, z, count);
    const Vec3f half(kBlock / 2.0f);
    const float radius = length(half) + reach();
    for (std::int64_t x = 0; x < dimensions_.x; x += kBlock) {
      const std::int64_t x_end = std::min(x + kBlock, dimensions_.x);
      const bool near = query_.nearest(Vec3f(Vec3d(Vec3i(x, y, z))) + half, radius).has_value();
      for (std::int64_t k = 0; k < count; ++k) {
        for (std::int64_t j = y; j < y_end; ++j) {
          Voxel* out = &slices[static_cast<std::size_t>((k * dimensions_.y + j) * dimensions_.x)];
          const std::vector<float>* line =
              solid_ ? &crossings[static_cast<std::size_t>(k * (y_end - y) + j - y)] : nullptr;
          for (std::int64_t i = x; i < x_end; ++i) {
            const Vec3f centre(Vec3d(Vec3i(i, j, z + k)) + Vec3d(0.5));
            const bool inside = line != nullptr && is_inside(*line, centre);
            out[i] = near ? voxel_at(centre, inside) : far_voxel(inside);
          }
        }
      }
    }
  }

  std::vector<std::vector<float>> lines(std::int64_t y, std::int64_t y_end, std::int64_t z,
                                        std::int64_t count) const {
    std::vector<std::vector<float>> crossings(static_cast<std::size_t>(count * (y_end - y)));
    std::size_t i = 0;
    for (std::int64_t k = 0; k < count; ++k) {
      for (std::int64_t j = y; j < y_end; ++j, ++i) {
        // A little aside of the middle, where modelled edges are; again where a line met one all the same:
        // out of a closed mesh it comes after an even number.
        for (const float aside : {0.0137f, 0.0313f, -0.0271f}) {
          query_.crossings(
              Vec3f(0, static_cast<float>(j) + 0.5f + aside, static_cast<float>(z + k) + 0.5f + 0.7f * aside),
              0, crossings[i]);
          if (crossings[i].size() % 2 == 0) break;
        }
      }
    }
    return crossings;
  }

  static bool is_inside(const std::vector<float>& crossings, Vec3f p) {
    return (std::upper_bound(crossings.begin(), crossings.end(), p.x) - crossings.begin()) % 2 != 0;
  }

  /// Farther from the surface than this a voxel needs to know no more of it.
  float reach() const { return solid_ ? kInnerReach : kShellReach; }

  Voxel far_voxel(bool inside) const { return inside ? voxel_of(inner_color_, 1, {}) : kEmpty; }

  Voxel voxel_at(Vec3f p, bool inside) const {
    const float radius = !solid_ ? kShellReach : inside ? kInnerReach : 0.5f;
    const auto nearest = query_.nearest(p, radius);
    if (!nearest) return far_voxel(inside);
    const float d = nearest->distance;
    // A plane through the middle of a voxel's neighbours covers this much of it.
    const float opacity = !solid_  ? std::clamp(kShellReach - d, 0.0f, 1.0f)
                          : inside ? std::min(0.5f + d, 1.0f)
                                   : 0.5f - d;
    return voxel_of(color_of(*nearest), opacity, normal_of(*nearest));
  }

  Vec3f color_of(const MeshQuery::Nearest& nearest) const {
    if (mesh_.colors.empty()) return inner_color_;
    const auto& t = mesh_.triangles[nearest.triangle];
    const auto& w = nearest.weights;
    return w[0] * mesh_.colors[t[0]] + w[1] * mesh_.colors[t[1]] + w[2] * mesh_.colors[t[2]];
  }

  Vec3f normal_of(const MeshQuery::Nearest& nearest) const {
    const auto& corners = normals_[nearest.triangle];
    const auto& w = nearest.weights;
    const Vec3f mixed = w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2];
    return length(mixed) > 0 ? normalize(mixed) : mixed;
  }

  /// So deep below the surface voxels have its colour and normal: as far as those on it are blended with.
  static constexpr float kInnerReach = 1.6f;
  /// From the middle of a shell to where it ends: thinner ones let light through between two voxels.
  static constexpr float kShellReach = 1.25f;

  const MeshQuery& query_;
  const io::TriangleMesh& mesh_;
  std::vector<std::array<Vec3f, 3>> normals_;
  Vec3i dimensions_;
  bool solid_;
  Vec3f inner_color_{0.8f, 0.8f, 0.8f};
};

}  // namespace

bool is_closed(const io::TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = first_at_place(mesh);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax(place[t[k]], place[t[(k + 1) % 3]]));
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    const auto end = std::upper_bound(edges.begin() + static_cast<std::ptrdiff_t>(i), edges.end(), edges[i]);
    const auto count = static_cast<std::size_t>(end - edges.begin()) - i;
    if (count % 2 != 0) return false;
    i += count;
  }
  return true;
}

Result<MeshStoreReport> build_mesh_store(const exec::Device& cpu, io::TriangleMesh mesh,
                                         const std::string& path, const MeshStoreOptions& options,
                                         const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  const Box3d box = mesh.bounds();
  const double size = max_component(box.maximum - box.minimum);
  if (!(size > 1e-30 && size < 1e30)) return Error{options.source + ": the mesh has no size"};
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

  const std::uint64_t slice =
      store::saturating_product(static_cast<std::uint64_t>(dimensions.x * dimensions.y), sizeof(Voxel));
  const std::uint64_t needed = store::PyramidBuilder::window_bytes(info.shape, info.format) + kBlock * slice +
                               mesh.triangles.size() * kBytesPerTriangle +
                               mesh.vertices.size() * kBytesPerVertex;
  if (needed > options.memory_bytes) {
    return Error{options.source + ": " + std::to_string(options.resolution) + " voxels across need " +
                 store::mebibytes(needed) + " of memory; " + store::mebibytes(options.memory_bytes) +
                 " are allowed (--memory)"};
  }
  for (Vec3f& v : mesh.vertices) v = Vec3f((Vec3d(v) - info.voxel_to_world.origin) / voxel);
  GVX_ASSIGN(const auto query, MeshQuery::create(std::move(mesh)));
  const MeshVoxels voxels(*query, dimensions, options.solid);
  GVX_ASSIGN(const auto writer, store::StoreWriter::create(path, info.shape));
  store::PyramidBuilder pyramid(cpu, *writer, info);
  std::vector<Voxel> slices(static_cast<std::size_t>(kBlock * dimensions.x * dimensions.y));
  for (std::int64_t z = 0; z < dimensions.z; z += kBlock) {
    const std::int64_t count = std::min(kBlock, dimensions.z - z);
    const std::span<Voxel> used(slices.data(), static_cast<std::size_t>(count * dimensions.x * dimensions.y));
    voxels.fill(cpu, z, count, used);
    GVX_TRY(pyramid.push_slices(count, std::as_bytes(used)));
    if (progress) progress(static_cast<std::uint64_t>(z + count), static_cast<std::uint64_t>(dimensions.z));
  }
  GVX_TRY(pyramid.finish());
  return MeshStoreReport{dimensions, writer->bytes_written()};
}

}  // namespace gvx::produce
