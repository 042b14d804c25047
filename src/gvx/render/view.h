/// \file
/// View: what one wants to see of a volume, and TreePlacement: what is known of the tree that holds it.
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

namespace gvx::render {

struct View {
  std::uint32_t width = 1024, height = 1024;
  /// Rays along an axis of a pixel, 1 to 8: each a cone of its own share, so that levels are finer too.
  std::uint32_t antialias = 1;
  static constexpr std::uint32_t kMostAntialias = 8;
  /// Of `antialias`, those that stand for one ray that was asked for: subrays_of() of frame.h says how many.
  std::uint32_t subrays = 1;
  scene::Camera camera;
  scene::Mode mode = scene::Mode::composite;
  double isovalue = 0;  ///< physical; of isosurfaces
  /// Of scalars that are composited.
  scene::Classification classification = scene::Classification::preintegrated;
  /// One a channel; fewer repeat the last. None for colour voxels.
  std::vector<scene::TransferFunction> functions;
  scene::Lighting lighting;
  Box3d clip{{0, 0, 0}, {1, 1, 1}};  ///< in fractions of the volume's box along its axes
  Vec3f background{0, 0, 0};         ///< display (sRGB)
  bool opaque_background = true;     ///< otherwise pixels keep their alpha
  /// Along a ray, of the level that is sampled; of two that are blended, pre-integrated, of the coarser one,
  /// unless that were less than one a voxel of the finer.
  double samples_per_voxel = 2;
  bool level_of_detail = true;  ///< otherwise the finest level everywhere
  /// Voxels across a ray's cone where levels of detail are chosen: at 2 the filter between voxels is as wide
  /// as the cone, 1 is blurred and loads a quarter.
  double detail = 2;
  static constexpr double kLeastDetail = 0.25, kMostDetail = 16;

  /// Added to the values of a volume of one channel as rays go through it.
  std::optional<AddedNoise> noise = {};

  bool operator==(const View&) const = default;
};

struct TreePlacement {
  int n = 2, m = 16;
  int max_level = 0;
  VoxelFormat format;
  Affine3 tree_to_world;
  Box3d extent{{0, 0, 0}, {1, 1, 1}};  ///< of the volume in tree space
  double scale = 1, offset = 0;        ///< physical value = scale * stored value + offset
  ChannelRanges ranges;                ///< of all stored values
};

}  // namespace gvx::render
