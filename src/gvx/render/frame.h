/// \file
/// Frame: everything that is the same for all rays of a picture, computed once; FrameView is what kernels
/// take.
///
/// Along a ray, t is the distance from the camera in the world. Steps are counted in *ticks*, steps of the
/// finest level, from where the ray enters the volume. A step of level l is stride[l] = N^(max_level - l)
/// ticks long and starts at a multiple of it, so that where a ray takes its samples depends on the ray alone:
/// not on nodes, not on what is resident.
///
/// A ray is a cone. Where it is View::detail voxels of level l wide, that level alone is sampled; from there
/// on the next coarser one is blended in, until the cone is as many of its voxels wide:
///
///     t        0 ........ lod_distance[2] ........ lod_distance[1] .............. lod_distance[0] ......
///     level        2 = max       |   2, more and more of 1   |   1, more and more of 0   |   0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/render/view.h"

namespace gvx::render {

/// Levels a tree can have: 2^32 nodes across.
inline constexpr int kMaxLevels = 33;

struct FrameView {
  scene::CameraView camera;
  std::uint32_t width = 0, height = 0;  ///< in rays
  Affine3 world_to_tree;
  Box3d box;  ///< of the visible volume in tree space
  double tick_world = 0;
  int max_level = 0;
  double lod_distance[kMaxLevels] = {};  ///< the cone is View::detail voxels of level l wide there
  std::int64_t stride[kMaxLevels] = {};  ///< of a step of level l, in ticks
  float fixed_blend = -1;  ///< share of the coarser level everywhere, if not negative (orthographic)
  int fixed_level = 0;     ///< and the level then
  VoxelFormat format;
  scene::Visibility visibility;
  scene::LightingView lighting;
  float units_per_tick = 1;   ///< unit distances of the extinctions
  float voxels_per_step = 1;  ///< of the level that is sampled
  Vec3f iso_color;
  /// From a gradient a voxel of a level to one that surfaces are told from noise by. An edge's gradient a
  /// voxel is the same at every level, a slope's grows with the voxels: this is half way between, for the
  /// first levels: far up only edges are left.
  float gradient_scale[kMaxLevels] = {};
  float soft_gradient[kMaxChannels] =
      {};  ///< stored units a voxel at which a gradient counts half as a surface

  /// The level whose voxel is no wider than the cone at distance t, the coarsest such.
  GVX_HD int level_at(double t) const {
    if (fixed_blend >= 0) return fixed_level;
    int level = max_level;
    while (level > 0 && t >= lod_distance[level - 1]) --level;
    return level;
  }

  /// The share of the next coarser level at distance t, where `level` is sampled.
  GVX_HD float blend_at(int level, double t) const {
    const double share = share_at(level, t);
    return share > 0 ? (share < 1 ? static_cast<float>(share) : 1.0f) : 0.0f;
  }

  /// The same before it is held from 0 to 1: even in t.
  GVX_HD double share_at(int level, double t) const {
    if (fixed_blend >= 0) return fixed_blend;
    const double from = lod_distance[level], to = lod_distance[level - 1];
    return (t - from) / (to - from);
  }

  /// Is any of the coarser level seen at distance t, where `level` is sampled?
  GVX_HD bool blends(int level, double t) const {
    if (level == 0 || format.content == VoxelContent::labels) return false;
    return fixed_blend >= 0 ? fixed_blend > 0 : t > lod_distance[level];
  }
};

/// Owns the tables behind a FrameView; frames of the same transfer functions share them.
class Frame {
 public:
  /// An error where the view cannot be made: a bad camera, function, clip box or size. `previous`, if not
  /// null, is a frame on the same device and tree whose tables are taken where they are the same.
  static Result<Frame> make(const exec::Device& device, const View& view, const TreePlacement& placement,
                            const Frame* previous = nullptr);

  FrameView view() const { return view_; }

 private:
  /// A transfer function's tables on the device.
  struct Tables {
    scene::TransferFunction function;
    double most_extinction = 0;
    exec::Buffer<scene::Matter> matter;
    exec::Buffer<scene::TransferView::Integral> integral;
    exec::Buffer<std::uint32_t> visible_before;
    exec::Buffer<float> gradient_factor;
    scene::TransferView view;
  };
  static std::shared_ptr<const Tables> make_tables(const exec::Device& device,
                                                   const scene::TransferFunction& function,
                                                   const TreePlacement& placement, double most_extinction);

  FrameView view_;
  std::vector<std::shared_ptr<const Tables>> tables_;
};

}  // namespace gvx::render
