// composite_classified_batch: what classified.h does, with a ray in each lane of a vector. Compiled once for
// each instruction set.

#include "gvx/render/reference/classified.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/classified_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/each_step_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// composite_labels: what a step shows.
template <typename Voxel>
class LabelSteps {
 public:
  static constexpr bool kWhole = true;

  HWY_INLINE LabelSteps(const FrameView& frame, const StretchBatch& batch)
      : labels_{{batch.fine.brick, static_cast<int>(batch.m)},
                static_cast<int>(batch.m),
                Function(frame.visibility.functions[0]),
                batch.units} {}

  GVX_PIECE void show(Float i, const StepRays<kWhole>& rays, Mask active, Shown& shown) const {
    labels_.show(rays, i, active, shown);
  }

 private:
  const Labels<PlainTexels<Voxel>> labels_;
};

/// The planes of a brick of bytes.
struct PlanesOf {
  const PlainTexels<std::uint8_t> first;
  const std::size_t plane_texels;

  HWY_INLINE PlainTexels<std::uint8_t> operator()(std::uint32_t index) const {
    PlainTexels<std::uint8_t> plane = first;
    plane.texels += index * plane_texels;
    return plane;
  }
};

/// composite_colors: what a step shows.
template <bool kNormals>
class ColorSteps {
 public:
  static constexpr bool kWhole = true;

  HWY_INLINE ColorSteps(const FrameView& frame, const StretchBatch& batch)
      : colors_{planes(batch, batch.fine.brick),
                planes(batch, batch.blended ? batch.coarse.brick : nullptr),
                static_cast<int>(batch.m),
                batch.blended,
                batch.coarse.voxels_across / batch.fine.voxels_across,
                frame.voxels_per_step} {}

  GVX_PIECE void show(Float i, const StepRays<kWhole>& rays, Mask active, Shown& shown) const {
    colors_.show(rays, i, active, shown);
  }

 private:
  HWY_INLINE static PlanesOf planes(const StretchBatch& batch, const std::byte* brick) {
    return {{brick, static_cast<int>(batch.m)}, plane_texels(batch.m)};
  }

  const Colors<kNormals, PlanesOf> colors_;
};

}  // namespace

void labels_u8(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<LabelSteps<std::uint8_t>>(frame, batch);
}
void labels_u16(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<LabelSteps<std::uint16_t>>(frame, batch);
}
void colors(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<ColorSteps<false>>(frame, batch);
}
void colors_with_normals(const FrameView& frame, StretchBatch& batch) {
  composite_each_step<ColorSteps<true>>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(labels_u8);
HWY_EXPORT(labels_u16);
HWY_EXPORT(colors);
HWY_EXPORT(colors_with_normals);

void composite_classified_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.content) {
    case VoxelContent::color:
      return HWY_DYNAMIC_DISPATCH(colors)(frame, batch);
    case VoxelContent::color_normal:
      return HWY_DYNAMIC_DISPATCH(colors_with_normals)(frame, batch);
    default:
      return frame.format.type == VoxelType::u8 ? HWY_DYNAMIC_DISPATCH(labels_u8)(frame, batch)
                                                : HWY_DYNAMIC_DISPATCH(labels_u16)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
