/// \file
/// One pass of all rays over what is resident: the launch of the march's kernels for the voxel type, N and M
/// of a tree, or of the march through a scene of several objects.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gvx/brick/cell_masks.h"
#include "gvx/cache/request_marks.h"
#include "gvx/cache/usage_list.h"
#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/render/frame/film_view.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/frame/ray_projection.h"
#include "gvx/render/frame/ray_state.h"
#include "gvx/surface/draw/surface_film_view.h"
#include "gvx/tree/hidden_nodes.h"
#include "gvx/tree/node_pool.h"

namespace gvx::render {

class ObjectTiles;

/// An object of a scene as a viewer sees it; the frame's voxel format, n and m say what the bricks are.
/// Objects may share a tree.
struct ObjectView {
  std::uint32_t n = 2, m = 16;
  FrameView frame;
  tree::NodePoolView nodes;
  tree::HiddenNodesView hidden;       ///< from the viewer
  const std::byte* bricks = nullptr;  ///< all slots of the brick pool
  cache::UsageView tile_usage, brick_usage;
  cache::RequestView requests;
  brick::CellMaskView cells;  ///< of bricks that the viewer can see something in
};

/// What a pass works on.
struct Pass {
  FilmView film;
  std::span<const ObjectView> objects;  ///< volumes: one or more, or any where there are surfaces
  /// What each ray of the film sees of opaque surfaces, if there are any: there it ends.
  surface::SurfaceFilmView surfaces = {};
  /// Where on the film they are; null: that is found anew. For several objects.
  const ObjectTiles* object_tiles = nullptr;
  std::uint32_t number = 0;                     ///< the stamp of this pass
  std::uint32_t epoch = 0;                      ///< of the film
  exec::BufferView<std::uint32_t> blank_tiles;  ///< Film::blank_tiles; for previews, or nothing
  ProjectionsView projections;                  ///< Film::projections; for exact rays of several objects
  /// If not kAllRays, the one ray that marches, y * width + x: where memory does not hold what two need.
  std::uint64_t lone_ray = kAllRays;

  static constexpr std::uint64_t kAllRays = UINT64_MAX;

  /// On a CPU: never many rays in vectors, where there is a choice.
  bool one_ray_at_a_time = false;

  /// Is it a volume by itself?
  bool of_one_object() const { return objects.size() == 1 && surfaces.empty(); }
  /// The only object of a scene.
  const ObjectView& object() const {
    GVX_CHECK(objects.size() == 1);
    return objects[0];
  }
};

/// Are there kernels for a GPU for trees of this n and m?
constexpr bool has_kernels([[maybe_unused]] std::uint32_t n, [[maybe_unused]] std::uint32_t m) {
#if defined(GVX_CUDA_ONE_SHAPE)
  return n == 2 && m == 16;
#else
  return true;
#endif
}

/// An error where this build has no kernels for such voxels, n and m on the device.
Status check_kernels(const exec::Device& device, VoxelType type, std::uint32_t n, std::uint32_t m);
/// An error where the device renders no scenes of so many objects, of which so many project.
Status check_objects(const exec::Device& device, std::size_t objects, std::size_t projecting);

/// The march of a pass through the listed tiles of a grid, as far as it comes before the deadline.
struct TilesMarch {
  const Pass& pass;
  exec::TileGrid grid;
  exec::BufferView<const std::uint32_t> tiles;
  exec::Deadline deadline;
};

/// That of exact rays.
struct ExactMarch : TilesMarch {
  exec::BufferView<RayState> rays;
  exec::BufferView<std::uint32_t> unfinished;  ///< an entry for each tile of the grid
};

/// That of previews, one ray for `block` x `block` pixels. The grid is that of the blocks:
/// ceil(width / block) by ceil(height / block).
struct PreviewMarch : TilesMarch {
  std::uint32_t block, generation;
  exec::BufferView<const RayState> rays;
  exec::BufferView<PreviewPixel> pixels;
};

/// Marches exact rays; sets unfinished[tile] = 1 where a ray of the tile is not finished. Returns whether
/// no tile was left out for the deadline; one that was begun has come further, though not always to its
/// end. Where a CPU marches tiles (tile_march.h) one that has something left to do is begun however late it
/// is, of a preview too, so that short frames on slow machines come to an end.
bool march_exact(const exec::Device& device, const ExactMarch& march);

/// Draws the preview pixels at multiples of `block` that this generation has not drawn yet and whose exact
/// ray is not finished.
bool march_preview(const exec::Device& device, const PreviewMarch& march);

/// A ray marches by itself through an object of the pass, as march.h says; on a CPU. It need not be of the
/// film: any of the bundle that the object's frame is of.
void march_ray(const Pass& pass, const ObjectView& object, const BundleRay& ray, RayState& state);
/// Ray (x, y) of the film marches so through the only object.
void march_ray(const Pass& pass, double x, double y, RayState& state);
/// Ray (x, y) draws its preview by itself; on a CPU.
PreviewPixel preview_ray(const Pass& pass, double x, double y);

/// Where a ray comes to an opacity.
struct RayReach {
  float opacity = 0;
  double distance = INFINITY;  ///< from the eye, in the world; infinite where it does not come to it
  /// Of the pass, most of whose matter is there; kNone, or kSurface.
  std::int32_t object = kNone;

  static constexpr std::int32_t kNone = -1, kSurface = INT32_MAX;
};

/// Where a preview of ray (x, y) comes to this opacity (march.h); on a CPU. A projection's opacity is one
/// sample where its value is.
RayReach reach(const Pass& pass, double x, double y, float opacity);

}  // namespace gvx::render
