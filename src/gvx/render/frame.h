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

/// What a step through matter of one value adds: its colour, not multiplied by its opacity.
struct alignas(16) StepColor {
  Vec3f color;
  float opacity = 0;
};

struct FrameView {
  scene::CameraView camera;
  std::uint32_t width = 0, height = 0;  ///< in rays
  Affine3 world_to_tree;
  Box3d box;          ///< of the visible volume in tree space
  Vec3d last_inside;  ///< a hair below box.maximum: points there are in nodes that are in the box
  double tick_world = 0;
  int max_level = 0;
  double lod_distance[kMaxLevels] = {};  ///< the cone is View::detail voxels of level l wide there
  std::int64_t stride[kMaxLevels] = {};  ///< of a step of level l, in ticks
  float fixed_blend = -1;  ///< share of the coarser level everywhere, if not negative (orthographic)
  int fixed_level = 0;     ///< and the level then
  VoxelFormat format;
  scene::Visibility visibility;
  scene::LightingView lighting;
  scene::Classification classification = scene::Classification::preintegrated;
  /// On a CPU, post-classified, one channel: what a step of level l adds for each entry of the function is
  /// step_colors[l * TransferView::kEntries + entry].
  const StepColor* step_colors = nullptr;
  float units_per_tick = 1;   ///< unit distances of the extinctions
  float voxels_per_step = 1;  ///< of the level that is sampled
  Vec3f iso_color;
  /// From a gradient a voxel of a level to one that surfaces are told from noise by. An edge's gradient a
  /// voxel is the same at every level, a slope's grows with the voxels: this is half way between, for the
  /// first levels: far up only edges are left.
  float gradient_scale[kMaxLevels] = {};
  /// The square of a gradient's length in the world, from its parts in tree space: what x x, y y, z z count,
  /// and y z, z x, x y, which is nothing where the axes are at right angles.
  Vec3f gradient_square, gradient_product;
  float soft_gradient[kMaxChannels] =
      {};  ///< stored units a voxel at which a gradient counts half as a surface

  /// Steps of one level, blended or not.
  struct Zone {
    int level = 0;
    bool blended = false;          ///< some of the next coarser level is seen
    std::int64_t end = INT64_MAX;  ///< the tick at which the next zone begins
  };

  /// The zone of the step that starts at `tick` of a ray that enters the volume at distance `enter`. All is
  /// compared in whole ticks: a ray that goes on from anywhere in a zone finds the same.
  GVX_HD Zone zone_at(double enter, std::int64_t tick) const {
    Zone zone;
    const bool blends = format.content != VoxelContent::labels;
    if (fixed_blend >= 0) {
      zone.level = fixed_level;
      zone.blended = blends && fixed_blend > 0 && fixed_level > 0;
      return zone;
    }
    int level = max_level;
    while (level > 0 && tick >= handover(level - 1, enter)) --level;
    while (stride[level] != 1 && tick % stride[level] != 0) ++level;
    zone.level = level;
    if (level == 0) return zone;
    const std::int64_t begins = blends ? handover(level, enter) : INT64_MAX;
    zone.blended = tick >= begins;
    const int next = zone.blended || !blends ? level - 1 : level;
    const std::int64_t at = handover(next, enter);
    if (at == INT64_MAX) return zone;
    const std::int64_t least = at > tick ? at : tick + 1;
    zone.end = (least + stride[next] - 1) / stride[next] * stride[next];
    return zone;
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

  /// The first tick from which on the cone is View::detail voxels of `level` wide; INT64_MAX: never.
  GVX_HD std::int64_t handover(int level, double enter) const {
    const double tick = (lod_distance[level] - enter) / tick_world;
    if (!(tick < 9e15)) return INT64_MAX;
    return tick > 0 ? whole_above(tick) : 0;
  }

  /// The least whole number that is no less than x, from 0 to 2^62.
  GVX_HD static std::int64_t whole_above(double x) {
    const auto below = static_cast<std::int64_t>(x);
    return below + (x > static_cast<double>(below) ? 1 : 0);
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
  /// step_colors of a function, for steps of this many units at the finest level.
  struct StepTable {
    std::shared_ptr<const Tables> tables;
    float units_per_tick = 0;
    std::vector<std::int64_t> strides;
    std::vector<StepColor> colors;
  };
  static std::shared_ptr<const StepTable> make_steps(const FrameView& view,
                                                     std::shared_ptr<const Tables> tables);
  static std::shared_ptr<const Tables> make_tables(const exec::Device& device,
                                                   const scene::TransferFunction& function,
                                                   const TreePlacement& placement, double most_extinction);

  FrameView view_;
  std::vector<std::shared_ptr<const Tables>> tables_;
  std::shared_ptr<const StepTable> steps_;
};

}  // namespace gvx::render
