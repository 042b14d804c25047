/// \file
/// View: what to show of a volume, and how.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gvx/core/added_noise.h"
#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/voxel.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/lighting.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/visibility.h"
#include "gvx/surface/draw/surface_overlay.h"

namespace gvx::render {

/// How a volume is shown.
struct ObjectLook {
  scene::Mode mode = scene::Mode::composite;
  double isovalue = 0;  ///< physical; only for isosurfaces
  /// How values become colours; only for scalars in mode composite.
  scene::Classification classification = scene::Classification::preintegrated;
  /// One for each channel; if there are fewer, the last one is repeated. None for colour voxels.
  std::vector<scene::TransferFunction> functions;
  Box3d clip{{0, 0, 0}, {1, 1, 1}};  ///< what is shown, in fractions of the volume's box
  /// Noise that is added to the values of a volume of one channel, at each sample of a ray.
  std::optional<AddedNoise> noise = {};

  bool operator==(const ObjectLook&) const = default;
  /// Is the same hidden of a volume, apart from what the clip boxes cut off?
  bool sees_like(const ObjectLook& other) const {
    return functions == other.functions && mode == other.mode && isovalue == other.isovalue &&
           classification == other.classification && noise == other.noise;
  }
};

/// A picture: its size, the camera, and how values are shown. The ObjectLook is that of a picture's only
/// object; where there are several, each has its own.
struct View : ObjectLook {
  std::uint32_t width = 1024, height = 1024;
  /// Rays along each axis of a pixel, 1 to 8. More rays are thinner cones, so they also use finer levels.
  std::uint32_t antialias = 1;
  static constexpr std::uint32_t kMostAntialias = 8;
  /// How many of the `antialias` rays along an axis replace a single ray that was asked for: see subrays_of()
  /// in frame.h.
  std::uint32_t subrays = 1;
  scene::Camera camera;
  scene::Lighting lighting;
  Vec3f background{0, 0, 0};      ///< as displayed (sRGB), 0 to 1
  bool opaque_background = true;  ///< if not, pixels keep their alpha
  /// Samples along a ray for each voxel of the level that is sampled. Where two levels are blended and the
  /// classification is pre-integrated: for each voxel of the coarser one, but at least one for each voxel of
  /// the finer one.
  double samples_per_voxel = 2;
  bool level_of_detail = true;  ///< if not, the finest level is used everywhere
  /// Voxels across a ray's cone at the level of detail that is chosen. At 2 the interpolation filter is as
  /// wide as the cone. At 1 pictures are blurred, and load a quarter of the data.
  double detail = 2;
  /// What colours of surfaces say instead of their own.
  surface::Overlay overlay = surface::Overlay::none;
  static constexpr double kLeastDetail = 0.25, kMostDetail = 16;

  bool operator==(const View&) const = default;
};

}  // namespace gvx::render
