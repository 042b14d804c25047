/// \file
/// The instruction sets that vectors are compiled for, and what the formulas are compiled as there. To be
/// included before any of Highway, by sources that are compiled once for each. Private to this room.
///
/// CMake's GVX_VECTORS chooses them: the compiler's flags give the least, and where only that is wanted
/// HWY_COMPILE_ONLY_STATIC is defined.
#pragma once

// First, since it says what formulas are compiled as for one lane, and forgets that at its end.
#include "gvx/render/formula/one_lane.h"

// What the formulas are compiled as here.
#define GVX_FORMULA HWY_INLINE
#define GVX_FORMULA_LAMBDA HWY_ATTR
#define GVX_APART HWY_NOINLINE

// What lies between these or has vectors without a fixed size gains nothing here.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// A compiler that instruments takes far longer for all in one piece.
#define GVX_PIECE HWY_NOINLINE
#define GVX_VECTORS_SIDE_BY_SIDE 1
#else
#define GVX_PIECE HWY_INLINE
// What one vector waits for, the others fill.
#define GVX_VECTORS_SIDE_BY_SIDE 4
#endif
