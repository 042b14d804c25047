/// \file
/// Lanes of the vectors of this folder: their types and a few words for them. Compiled once for each
/// instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_SURFACE_LANES_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_SURFACE_LANES_SIMD_INL_H
#undef GVX_SURFACE_LANES_SIMD_INL_H
#else
#define GVX_SURFACE_LANES_SIMD_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace gvx::surface::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Float = hn::Vec<Floats>;
using Int = hn::Vec<Ints>;
using Mask = hn::Mask<Floats>;
constexpr Floats kFloats;
constexpr Ints kInts;

HWY_INLINE Float all(float value) {
  return hn::Set(kFloats, value);
}

}  // namespace
}  // namespace gvx::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
