/// \file
/// The instruction sets that a surface's vectors are compiled for: the same as those of the march
/// (render/vectors/simd_targets.h). To be included before any of Highway, by sources that are compiled once
/// for each.
#pragma once

// What lies between these or has vectors without a fixed size gains nothing here.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
