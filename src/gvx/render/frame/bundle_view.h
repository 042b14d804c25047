/// \file
/// BundleView: rays that begin around one point and are alike in width, as they meet the levels of an
/// object's tree: those of a picture's pixels from the eye, or of a light, a lens or a mirror from elsewhere.
///
/// A ray is a cone. Where it is as wide as several voxels of level l (View::detail says how many), that level
/// alone is sampled; from there on the next coarser one is blended in, until the cone is as wide as so many
/// of its voxels:
///
///     t        0 ........ lod_distance[2] ........ lod_distance[1] .............. lod_distance[0] ......
///     level        2 = max       |   2, more and more of 1   |   1, more and more of 0   |   0
#pragma once

#include "gvx/core/node_key.h"
#include "gvx/core/ray.h"
#include "gvx/render/frame/level_view.h"

namespace gvx::render {

/// A ray, told from its bundle's origin.
struct BundleRay {
  Ray ray;                            ///< its direction is a unit vector of the world
  const RayInterval* seen = nullptr;  ///< between which distances it sees anything; null: wherever it goes
};

struct BundleView {
  Vec3d origin_world;                    ///< rays and levels are told from there: a camera's from its eye
  Vec3d origin;                          ///< in tree space
  Box3d box;                             ///< of the visible volume in tree space, from the origin
  const LevelView* levels = nullptr;     ///< of the tree, up to its finest, around the origin
  Vec3d root;                            ///< counted from the node of its size that the origin is in
  double apex = 0;                       ///< the distance, 0 or less, at which the cones are of no width
  double lod_distance[kMaxLevels] = {};  ///< from there on level l alone is fine enough
  float fixed_blend =
      -1;               ///< share of the coarser level everywhere, if not negative: of cones that do not grow
  int fixed_level = 0;  ///< the level that is then sampled everywhere
};

}  // namespace gvx::render
