// composite_simd-inl.h for voxels of u16. Compiled once for each instruction set.

#include "gvx/render/vectors/simd_targets.h"
#include "gvx/render/vectors/stretch_batch_types.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/composite_u16_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/composite_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {

void composite_u16(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint16_t>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(composite_u16);

void composite_batch_u16(const FrameView& frame, StretchBatch& batch) {
  HWY_DYNAMIC_DISPATCH(composite_u16)(frame, batch);
}

}  // namespace gvx::render
#endif
