/// \file
/// TileRays: the rays of a tile of the film side by side, and what of them is in a node, in vectors of
/// doubles.
///
/// A node's faces and a ray give the distances between which the ray is in the node; the steps whose centres
/// lie between them are the node's. They are counted from where the ray enters the volume, so nodes that
/// share a face (LevelView::face) share out steps without gaps, whatever else is visited or resident. A ray's
/// bits depend neither on the other rays nor on the instruction set.
#pragma once

#include <bit>
#include <cstdint>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/tile/stretch_batch.h"

namespace gvx::render {

struct TileRays {
  static constexpr std::uint32_t kEdge = exec::TileGrid::kTile;
  static constexpr std::uint32_t kMost = kEdge * kEdge;  ///< ray (x, y) of the tile is number y * kEdge + x

  /// Arrays of 4096 doubles one after the other would have all numbers of a ray in the same few lines of a
  /// processor's cache.
  static constexpr std::uint32_t kRoom = kMost + 8;

  /// In tree space, from the eye; t is the distance in the world.
  alignas(64) double origin[3][kRoom];  ///< number 0 is that of all where one_origin
  alignas(64) double direction[3][kRoom];
  alignas(64) double inverse[3][kRoom];       ///< of the direction; finite
  alignas(64) double enter[kRoom];            ///< the visible volume
  alignas(64) double exit[kRoom];             ///< no more than `enter`: has nothing to go through
  alignas(64) double world_origin[3][kRoom];  ///< as `origin`, in the world
  bool one_origin = false;
  alignas(64) float to_eye[kMost][4];  ///< unit, in the world; x, y, z and 0

  /// Where the next step starts, and the zone that it is in (FrameView::Zone).
  alignas(64) double tick[kRoom];
  alignas(64) double stride[kRoom];
  alignas(64) double steps_per_t[kRoom];
  alignas(64) double zone_end[kRoom];
  alignas(64) std::int32_t zone[kRoom];  ///< zone_number() of it
  alignas(64) double start[kRoom];       ///< of the stretch that was gathered last
  alignas(64) double centre[kRoom];      ///< t of its first step's

  /// RayState: red, green, blue, opacity.
  alignas(64) float gathered[kMost][4];
  std::int32_t samples[kMost];

  Vec3d origin_of(std::uint32_t ray) const { return of(origin, one_origin ? 0 : ray); }
  Vec3d world_origin_of(std::uint32_t ray) const { return of(world_origin, one_origin ? 0 : ray); }
  Vec3d direction_of(std::uint32_t ray) const { return of(direction, ray); }

  /// A zone's level and whether levels are blended in it.
  static std::int32_t zone_number(int level, bool blended) { return 2 * level + (blended ? 1 : 0); }
  /// Finds the zone of the step at a ray's tick.
  void find_zone(const FrameView& frame, std::uint32_t ray);
  /// Puts the first `count` rays into one zone, in which they stay.
  void fill_zone(const FrameView& frame, std::uint32_t count);
  /// From now on each may be in another.
  void begin_zones() { filled_ = 0; }

 private:
  static Vec3d of(const double (&numbers)[3][kRoom], std::uint32_t ray) {
    return {numbers[0][ray], numbers[1][ray], numbers[2][ray]};
  }

  std::uint32_t filled_ = 0;  // rays that are in the zone of the first
};

/// Rays (x, y) of a tile with x0 <= x <= x1 and y0 <= y <= y1.
struct TileRect {
  int x0 = 0, x1 = TileRays::kEdge - 1, y0 = 0, y1 = TileRays::kEdge - 1;

  bool empty() const { return x0 > x1 || y0 > y1; }
};

/// The rays of a tile, or of the part of one: through the pixels (x0 + i * apart, y0 + j * apart), i below
/// `width` and j below `height`.
struct RaysOfTile {
  double x0 = 0, y0 = 0, apart = 1;
  std::uint32_t width = 0, height = 0;
  std::uint32_t edge = exec::TileGrid::kTile;  ///< of the tile
  bool preview = false;                        ///< they make do with what is resident
};

/// Which rays of a tile there are to march.
struct ActiveRays {
  std::uint64_t row[TileRays::kEdge] = {};  ///< a bit for each x

  /// The rays (x, y) with x < width and y < height.
  static ActiveRays all_of(std::uint32_t width, std::uint32_t height) {
    ActiveRays rays;
    for (std::uint32_t y = 0; y < height; ++y) rays.row[y] = ~std::uint64_t{0} >> (TileRays::kEdge - width);
    return rays;
  }
  void set(std::uint32_t ray) { row[ray / TileRays::kEdge] |= bit(ray); }
  bool has(std::uint32_t ray) const { return (row[ray / TileRays::kEdge] & bit(ray)) != 0; }
  void clear(std::uint32_t ray) { row[ray / TileRays::kEdge] &= ~bit(ray); }
  std::uint32_t count() const {
    int count = 0;
    for (const std::uint64_t bits : row) count += std::popcount(bits);
    return static_cast<std::uint32_t>(count);
  }
  /// Calls function(ray) for each.
  template <typename Function>
  void for_each(Function function) const {
    for (std::uint32_t y = 0; y < TileRays::kEdge; ++y) {
      for (std::uint64_t bits = row[y]; bits != 0; bits &= bits - 1) {
        function(y * TileRays::kEdge + static_cast<std::uint32_t>(std::countr_zero(bits)));
      }
    }
  }
  bool any_in(const TileRect& rect) const {
    std::uint64_t any = 0;
    for (int y = rect.y0; y <= rect.y1; ++y) any |= row[y];
    return (any >> rect.x0 & ((std::uint64_t{2} << (rect.x1 - rect.x0)) - 1)) != 0;
  }

 private:
  static std::uint64_t bit(std::uint32_t ray) { return std::uint64_t{1} << ray % TileRays::kEdge; }
};

/// A node in tree space, from the eye.
struct NodeBox {
  Vec3d low, high;
};

/// From tree space to the rays of a tile: which of them may meet a node.
class TileProjection {
 public:
  /// Of tiles whose rays are `apart` pixels apart.
  TileProjection(const scene::CameraView& camera, const Affine3& world_to_tree, double apart);

  /// That of the tile whose first ray is that of the pixel (x, y).
  void begin_tile(double x, double y);

  /// How far a node is from the eye at least and at most; in the world.
  struct Distances {
    double nearest, farthest;
  };
  Distances distances(const NodeBox& node) const;

  /// All children of a node, x first; rays that meet one are in its rectangle.
  struct Rects {
    static constexpr int kMost = 32;
    alignas(64) std::int32_t x0[kMost], x1[kMost], y0[kMost], y1[kMost];

    TileRect operator[](std::uint32_t child) const { return {x0[child], x1[child], y0[child], y1[child]}; }
  };
  /// `n` children along an axis, each `edge` wide, from `low` on.
  void project_children(Vec3d low, double edge, int n, Rects& rects) const;

  // What follows is for project_children's vectors.
  Vec3d across, down, ahead;        ///< of the camera, in tree space: what one unit of x, y, z adds
  double first_x = 0, first_y = 0;  ///< the place of x = 0, y = 0 among the tile's rays
  bool orthographic = false;

 private:
  double apart_;
  double half_width_, half_height_;
  Affine3 tree_to_world_;
  double diagonal_world_ = 0;  // of all of tree space, the longest
};

/// The rays through the pixels (x0 + i * apart, y0 + j * apart) for i and j below `edge`, which is the tile's
/// or less; returns those that meet the visible volume.
ActiveRays set_up(const FrameView& frame, const scene::CameraView& camera, double x0, double y0, double apart,
                  std::uint32_t edge, TileRays& rays);

/// Has any active ray some of this node before it?
bool any_inside(const FrameView& frame, const TileRays& rays, const ActiveRays& active, const NodeBox& node,
                const TileRect& rect);

/// A brick's place in tree space: bricks like it along an axis, and its corner from the eye.
struct BrickPlace {
  double across = 1;
  Vec3d corner;
};

/// Which rays of a node are taken, and in which steps.
struct StretchesWanted {
  std::int32_t zone = 0;  ///< those that stand in this zone
  int step_level = 0;     ///< its level, or that of a coarser brick
  double stride = 1;      ///< of their steps, in ticks
  bool coarser = false;   ///< then steps do not end with the zone
  BrickPlace fine, coarse;
};

/// Puts the stretches of rays through a node into the batch: their steps, and where they go in the brick, and
/// in the coarser one where the batch is blended. The rays are put behind them. Those that come to the end of
/// their zone before the node are put into the next.
void gather_stretches(const FrameView& frame, const ActiveRays& active, const NodeBox& node,
                      const TileRect& rect, const StretchesWanted& wanted, TileRays& rays,
                      StretchBatch& batch);

}  // namespace gvx::render
