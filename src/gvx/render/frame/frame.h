/// \file
/// FrameView: an object as the rays of a bundle see it, which is what kernels take. Frame: owns that of a
/// camera's rays, computed once a picture.
///
/// Along a ray, t is the distance from the bundle's origin in the world. Steps are counted in *ticks*, steps
/// of the finest level, from where the ray enters the volume. A step of level l is stride[l] = N^(max_level -
/// l) ticks long and starts at a multiple of it, so that where a ray takes its samples depends on the ray
/// alone: not on nodes, not on what is resident. Ticks are whole numbers in doubles: beyond 2^53, which takes
/// trees of more than 30 levels, they are rounded, by far less than the steps that are taken out there.
///
/// Where levels are blended, and steps are pre-integrated, a step may be as long as one of the coarser level:
/// what is seen is as wide as its voxels, or nearly. Which levels they are, bundle_view.h says.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "gvx/core/node_key.h"
#include "gvx/core/result.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/render/frame/bundle.h"
#include "gvx/render/frame/bundle_view.h"
#include "gvx/render/frame/film_view.h"
#include "gvx/render/frame/view.h"
#include "gvx/tree/tree_description.h"

namespace gvx::render {

/// What a step through matter of one value adds: its colour, not multiplied by its opacity.
struct alignas(16) StepColor {
  Vec3f color;
  float opacity = 0;
};

struct FrameView {
  BundleView bundle;
  Affine3 world_to_tree;
  double tick_world = 0;
  int max_level = 0;
  AddedNoise noise;  ///< where adds_noise
  bool adds_noise = false;
  double finest_voxel = 0;            ///< its width in tree space
  double stride[kMaxLevels] = {};     ///< of a step of level l, in ticks
  bool blends_in_long_steps = false;  ///< those of blended levels are of the coarser one
  VoxelFormat format;
  scene::Visibility visibility;
  scene::LightingView lighting;
  scene::Classification classification = scene::Classification::preintegrated;
  /// On a CPU, post-classified, one channel: what a step of level l adds for each entry of the function is
  /// step_colors[l * its number of entries + entry].
  const StepColor* step_colors = nullptr;
  float units_per_tick = 1;   ///< unit distances of the extinctions
  float voxels_per_step = 1;  ///< of the level that is sampled
  Vec3f iso_color;
  /// Of a channel whose greatest values are sought, what those of coarse voxels are told from: the least of
  /// all, and how far it is from there to the greatest; of least values the greatest and the way down.
  struct Extreme {
    float from = 0, span = 0;
    float per_span = 0;  ///< inverse, of its size
  };
  Extreme extreme[kMaxChannels];
  /// From a gradient a voxel of a level to one that surfaces are told from noise by. An edge's gradient a
  /// voxel is the same at every level, a slope's grows with the voxels: this is half way between, for the
  /// first levels: far up only edges are left.
  float gradient_scale[kMaxLevels] = {};
  /// The square of a gradient's length in the world, from its parts in tree space: what x x, y y, z z count,
  /// and y z, z x, x y, which is nothing where the axes are at right angles.
  Vec3f gradient_square, gradient_product;
  float soft_gradient[kMaxChannels] =
      {};  ///< stored units a voxel at which a gradient counts half as a surface

  /// Of a step where `level` is sampled, and the next coarser one blended in or not.
  GVX_HD double stride_of(int level, bool blended) const {
    return stride[blended && blends_in_long_steps ? level - 1 : level];
  }

  /// Steps of one level, blended or not.
  struct Zone {
    int level = 0;
    bool blended = false;  ///< some of the next coarser level is seen
    double end = kNever;   ///< the tick at which the next zone begins
  };
  static constexpr double kNever = 1e300;

  /// The zone of the step that starts at `tick` of a ray that enters the volume at distance `enter`. All is
  /// compared in whole ticks: a ray that goes on from anywhere in a zone finds the same.
  GVX_HD Zone zone_at(double enter, double tick) const {
    Zone zone;
    const bool blends = format.content != VoxelContent::labels;
    if (bundle.fixed_blend >= 0) {
      zone.level = bundle.fixed_level;
      zone.blended = blends && bundle.fixed_blend > 0 && bundle.fixed_level > 0;
      return zone;
    }
    zone.level = max_level;
    while (zone.level > 0 && tick >= handover(zone.level - 1, enter)) --zone.level;
    zone.blended = blends && zone.level > 0 && tick >= handover(zone.level, enter);
    // A zone begins with a whole step: before that, the one before goes on.
    const auto goes_on = [&] { return !is_multiple(tick, stride_of(zone.level, zone.blended)); };
    while (zone.level < max_level && goes_on()) {
      ++zone.level;
      zone.blended = blends;
    }
    if (zone.blended && goes_on()) zone.blended = false;
    if (zone.level == 0) return zone;
    const int next = zone.blended || !blends ? zone.level - 1 : zone.level;
    const double at = handover(next, enter), next_stride = stride_of(next, blends && next > 0);
    if (at == kNever) return zone;
    const double steps = std::ceil(at / next_stride), after = std::floor(tick / next_stride + kRounding) + 1;
    zone.end = (steps > after ? steps : after) * next_stride;
    return zone;
  }

  /// The share of the next coarser level at distance t, where `level` is sampled.
  GVX_HD float blend_at(int level, double t) const {
    const double share = share_at(level, t);
    return share > 0 ? (share < 1 ? static_cast<float>(share) : 1.0f) : 0.0f;
  }

  /// The same before it is held from 0 to 1: even in t.
  GVX_HD double share_at(int level, double t) const {
    if (bundle.fixed_blend >= 0) return bundle.fixed_blend;
    const double from = bundle.lod_distance[level], to = bundle.lod_distance[level - 1];
    return (t - from) / (to - from);
  }

  /// The width of the voxels that are seen at distance t, in tree space: even in t, whatever levels are
  /// there.
  GVX_HD double footprint(double t) const {
    if (bundle.fixed_blend >= 0) {
      const int level = bundle.fixed_level;
      const double coarser = level > 0 ? stride[level - 1] : stride[level];
      return finest_voxel * (stride[level] + bundle.fixed_blend * (coarser - stride[level]));
    }
    const double voxels = (t - bundle.apex) / (bundle.lod_distance[max_level] - bundle.apex);
    return voxels > 1 ? voxels * finest_voxel : finest_voxel;
  }

  /// The stride of the steps around distance t, of a ray that enters at `enter`, or a multiple of it.
  GVX_HD double stride_at(double enter, double t) const {
    if (bundle.fixed_blend >= 0) {
      return stride_of(bundle.fixed_level, bundle.fixed_blend > 0 && bundle.fixed_level > 0);
    }
    int level = max_level;
    while (level > 0 && (t - enter) / tick_world >= handover(level - 1, enter)) --level;
    return stride_of(level, level > 0);
  }
  /// What a proxy leaves of a ray within the volume, two voxels more at either end; the tick to begin at.
  GVX_HD double cut(const RayInterval& span, RayInterval& inside) const {
    if (span.empty()) {
      inside.exit = inside.enter;
      return 0;
    }
    const double margin = 2 / double(voxels_per_step);
    const double exit = span.exit + margin * stride_at(inside.enter, span.exit) * tick_world;
    inside.exit = exit < inside.exit ? exit : inside.exit;
    const double at_begin = stride_at(inside.enter, span.enter);
    const double steps = std::floor((span.enter - inside.enter) / (at_begin * tick_world) - margin);
    return steps > 0 ? steps * at_begin : 0;
  }

  /// The first tick from which on the cone is View::detail voxels of `level` wide, or kNever.
  GVX_HD double handover(int level, double enter) const {
    const double tick = (bundle.lod_distance[level] - enter) / tick_world;
    if (!(tick < kNever)) return kNever;
    return tick > 0 ? std::ceil(tick) : 0;
  }

  /// Ticks are told apart by no less than this share of a stride.
  static constexpr double kRounding = 1e-9;
  GVX_HD static bool is_multiple(double tick, double stride) {
    const double steps = tick / stride;
    return std::fabs(steps - std::rint(steps)) <= kRounding;
  }
};

/// By how many each ray of a view is to be replaced, along an axis of a pixel (View::subrays). Where the
/// greatest or the least values are sought and pixels are so wide, somewhere in the volume, that levels would
/// be blended, what is thin and bright would lie between single rays: there it is kMostSubrays, or fewer
/// where View::kMostAntialias or the size of the picture allows no more. Else 1.
std::uint32_t subrays_of(const View& view, const tree::TreeDescription& tree);
inline constexpr std::uint32_t kMostSubrays = 4;

/// Rays of the film of a view. An error where the view has none, or no camera.
Result<FilmView> film_of(const View& view);

/// Owns the tables behind a FrameView; frames of the same transfer functions share them.
class Frame {
 public:
  /// An error where the view cannot be made: a bad camera, function, clip box or size. `previous`, if not
  /// null, is a frame on the same device and tree whose tables are taken where they are the same. The rays
  /// are those of film_of(view).
  static Result<Frame> make(const exec::Device& device, const View& view, const tree::TreeDescription& tree,
                            const Frame* previous = nullptr);

  FrameView view() const { return view_; }

  /// The same object, for cones from around `origin`, in the world, through what the picture shows of the
  /// tree. The bundle must outlive what is marched with it.
  Bundle bundle_at(const exec::Device& device, const tree::TreeDescription& tree, Vec3dd origin,
                   ConeShape cones) const;
  FrameView view_from(const Bundle& bundle) const;

 private:
  /// A transfer function's tables on the device.
  struct Tables {
    scene::TransferFunction function;
    scene::ValueSpan values;
    double most_extinction = 0;
    double span = 0;
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
    std::vector<double> strides;
    std::vector<StepColor> colors;
  };
  static std::shared_ptr<const StepTable> make_steps(const FrameView& view,
                                                     std::shared_ptr<const Tables> tables);
  static std::shared_ptr<const Tables> make_tables(const exec::Device& device,
                                                   const scene::TransferFunction& function,
                                                   const tree::TreeDescription& tree, scene::ValueSpan values,
                                                   double most_extinction);

  FrameView view_;
  Box3d visible_;              // of the tree
  double finest_width_ = 0;    // of a cone for the finest level
  bool finest_alone_ = false;  // LevelWidths
  Bundle bundle_;
  std::vector<std::shared_ptr<const Tables>> tables_;
  std::shared_ptr<const StepTable> steps_;
};

}  // namespace gvx::render
