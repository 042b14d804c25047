/// \file
/// Frame: everything that is the same for all rays of a picture, computed once; FrameView is what kernels
/// take.
///
/// Along a ray, t is the distance from the camera in the world. Steps are counted in *ticks*, steps of the
/// finest level, from where the ray enters the volume. A step of level l is stride[l] = N^(max_level - l)
/// ticks long and starts at a multiple of it, so that where a ray takes its samples depends on the ray alone:
/// not on nodes, not on what is resident.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/node_key.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/lighting.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::render {

/// Levels a tree can have: 2^32 nodes across.
inline constexpr int kMaxLevels = 33;

/// What one wants to see.
struct View {
  std::uint32_t width = 1024, height = 1024;
  scene::Camera camera;
  scene::TransferFunction function;
  scene::Lighting lighting;
  Box3d clip{{0, 0, 0}, {1, 1, 1}};  ///< in fractions of the volume's box along its axes
  Vec3f background{0, 0, 0};         ///< display (sRGB)
  bool opaque_background = true;     ///< otherwise pixels keep their alpha
  double samples_per_voxel = 2;      ///< along a ray, of the level that is sampled
  bool level_of_detail = true;       ///< otherwise the finest level everywhere

  bool operator==(const View&) const = default;
};

/// What is known of the tree that is looked at.
struct TreePlacement {
  int n = 2, m = 16;
  int max_level = 0;
  Affine3 tree_to_world;
  Box3d extent{{0, 0, 0}, {1, 1, 1}};  ///< of the volume in tree space
  double scale = 1, offset = 0;        ///< physical value = scale * stored value + offset
};

struct FrameView {
  scene::CameraView camera;
  std::uint32_t width = 0, height = 0;
  Affine3 world_to_tree;
  Box3d box;  ///< of the visible volume in tree space
  double tick_world = 0;
  int max_level = 0;
  double lod_distance[kMaxLevels] = {};  ///< level l serves from here on outwards
  std::int64_t stride[kMaxLevels] = {};  ///< of a step of level l, in ticks
  scene::TransferView function;
  scene::Lighting lighting;
  Vec3f to_light;
  float soft_gradient = 0;  ///< stored units a voxel at which a gradient counts half as a surface

  /// The coarsest level whose voxel is no wider than the pixel's cone at distance t.
  GVX_HD int level_at(double t) const {
    int level = max_level;
    while (level > 0 && t >= lod_distance[level - 1]) --level;
    return level;
  }
};

/// Owns the tables behind a FrameView; frames of one transfer function share them.
class Frame {
 public:
  /// An error where the view cannot be made: a bad camera, function, clip box or size. `previous`, if not
  /// null, is a frame on the same device and tree whose tables are taken where they are the same.
  static Result<Frame> make(const exec::Device& device, const View& view, const TreePlacement& placement,
                            const Frame* previous = nullptr);

  FrameView view() const { return view_; }

 private:
  struct Tables {
    scene::TransferFunction function;
    std::vector<double> step_units;
    exec::Buffer<Vec3f> colors;
    exec::Buffer<float> opacities;
    exec::Buffer<std::uint32_t> opaque_before;
    scene::TransferView view;
  };
  static std::shared_ptr<const Tables> make_tables(const exec::Device& device,
                                                   const scene::TransferFunction& function,
                                                   const TreePlacement& placement,
                                                   std::vector<double> step_units);

  FrameView view_;
  std::shared_ptr<const Tables> tables_;
};

}  // namespace gvx::render
