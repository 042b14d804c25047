// post_classified_simd-inl.h for voxels of u8. Compiled once for each instruction set.

#include "gvx/render/vectors/simd_targets.h"
#include "gvx/render/vectors/stretch_batch_types.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/post_classified_u8_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/post_classified_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {

void post_u8(const FrameView& frame, StretchBatch& batch) {
  post_all<std::uint8_t>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(post_u8);

void post_batch_u8(const FrameView& frame, StretchBatch& batch) {
  HWY_DYNAMIC_DISPATCH(post_u8)(frame, batch);
}

}  // namespace gvx::render
#endif
