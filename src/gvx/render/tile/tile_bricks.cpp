#include "gvx/render/tile/tile_bricks.h"

#include "gvx/render/reference/gather.h"
#include "gvx/render/reference/march_view.h"
#include "gvx/render/tile/visible_cells.h"

namespace gvx::render {
namespace {

template <typename Voxel, int M>
BrickPath<Voxel, M> path_of(const BytesPath& path, std::uint32_t planes) {
  return {
      {reinterpret_cast<const Voxel*>(path.brick), planes}, path.first, path.per_step, path.voxels_across};
}

}  // namespace

TileBricks::TileBricks(const ObjectView& object)
    : bytes_(object.bricks),
      brick_bytes_(brick_bytes(object.frame.format, object.m)),
      plane_bytes_(plane_texels(object.m) * voxel_bytes(object.frame.format.type)),
      m_(object.m) {}

std::uint64_t TileBricks::visible_cells(const FrameView& frame, BrickIndex slot, int level) const {
  const scene::TransferView& function = frame.visibility.functions[0];
  // A pre-integrated step may go from one cell to another, and through all that is between their values.
  const bool post = frame.classification == scene::Classification::post;
  const auto hides = [&](ValueRange values, float deviation) {
    return post ? function.transparent(values) : function.below_visible(values, deviation);
  };
  return with_voxel_type(frame.format.type, [&](auto zero) {
    return with_edge(m_, [&](auto m) {
      constexpr int kM = decltype(m)::value;
      const brick::BrickView<decltype(zero), kM> brick{reinterpret_cast<const decltype(zero)*>(at(slot)),
                                                       frame.format.planes};
      const bool deviates = !post && level != frame.max_level;
      return render::visible_cells<kM>(brick.voxels, deviates ? brick.deviations(0) : nullptr, hides);
    });
  });
}

void TileBricks::gather_stretch(const RayView& ray, const BytesStretch& stretch, RayState& state) const {
  const VoxelFormat format = ray.frame.format;
  with_voxel_type(format.type, [&](auto zero) {
    with_edge(m_, [&](auto m) {
      using Voxel = decltype(zero);
      constexpr int kM = decltype(m)::value;
      Stretch<Voxel, kM> s;
      static_cast<StretchSteps&>(s) = stretch;
      s.fine = path_of<Voxel, kM>(stretch.fine, format.planes);
      if (s.blended) s.coarse = path_of<Voxel, kM>(stretch.coarse, format.planes);
      render::gather_stretch(ray, s, state);
    });
  });
}

}  // namespace gvx::render
