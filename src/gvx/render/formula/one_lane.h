/// \file
/// one_lane: the formulas of this folder for one ray, in floats, as the reference takes them.
///
/// A formula is written once, over lanes: Float, Int and Mask, and Highway's names for what is done with
/// them. It is compiled here for lanes of one float, which kernels can call, and once for each instruction
/// set for Highway's vectors (vectors/lanes_simd-inl.h). Both say what Vec3v is and how memory is read. Where
/// Highway may round a product and a sum once, a float is rounded twice, on every device.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"
#include "gvx/scene/lighting.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/visibility.h"

namespace gvx::render {

/// A ray stops when no more than this is left to see: a quarter of a step of 8 bits.
inline constexpr float kOpaque = 1.0f - 1.0f / 1024;

}  // namespace gvx::render

namespace gvx::render::one_lane {

using Float = float;
using Int = std::int32_t;
using Mask = bool;
using Vec3v = Vec3f;
using Shade = scene::Shade<float>;
constexpr bool kOneLane = true;  // and false for vectors: formulas may then branch by what a lane holds

/// Highway's tags: which kind of lanes is meant.
enum Floats { kFloats };
enum Ints { kInts };

/// Highway's operations, of one lane. Comparisons with what is no number are false, but for Ne; Min and Max
/// then are the second.
struct hn {
  GVX_HD static constexpr float Zero(Floats) { return 0; }
  GVX_HD static constexpr Int Zero(Ints) { return 0; }
  GVX_HD static constexpr float Add(float a, float b) { return a + b; }
  GVX_HD static constexpr float Sub(float a, float b) { return a - b; }
  GVX_HD static constexpr float Mul(float a, float b) { return a * b; }
  GVX_HD static constexpr float Div(float a, float b) { return a / b; }
  GVX_HD static constexpr float Neg(float a) { return -a; }
  GVX_HD static constexpr float MulAdd(float a, float b, float sum) { return a * b + sum; }
  GVX_HD static constexpr float NegMulAdd(float a, float b, float sum) { return sum - a * b; }
  GVX_HD static constexpr float MulSub(float a, float b, float less) { return a * b - less; }
  GVX_HD static constexpr float Min(float a, float b) { return a < b ? a : b; }
  GVX_HD static constexpr float Max(float a, float b) { return a > b ? a : b; }
  GVX_HD static float Abs(float a) { return std::fabs(a); }
  GVX_HD static float Sqrt(float a) { return std::sqrt(a); }
  GVX_HD static float Floor(float a) { return std::floor(a); }
  GVX_HD static float Exp(Floats, float a) { return std::exp(a); }
  GVX_HD static float Log(Floats, float a) { return std::log(a); }
  /// Integers wrap around.
  GVX_HD static constexpr Int Add(Int a, Int b) {
    return static_cast<Int>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
  }
  GVX_HD static constexpr Int Sub(Int a, Int b) {
    return static_cast<Int>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
  }
  GVX_HD static constexpr float ConvertTo(Floats, Int a) { return static_cast<float>(a); }

  GVX_HD static constexpr Mask Lt(float a, float b) { return a < b; }
  GVX_HD static constexpr Mask Le(float a, float b) { return a <= b; }
  GVX_HD static constexpr Mask Gt(float a, float b) { return a > b; }
  GVX_HD static constexpr Mask Ge(float a, float b) { return a >= b; }
  GVX_HD static constexpr Mask Eq(float a, float b) { return a == b; }
  GVX_HD static constexpr Mask Ne(float a, float b) { return a != b; }
  GVX_HD static constexpr Mask And(Mask a, Mask b) { return a && b; }
  GVX_HD static constexpr Mask Or(Mask a, Mask b) { return a || b; }
  GVX_HD static constexpr Mask Xor(Mask a, Mask b) { return a != b; }
  GVX_HD static constexpr Mask AndNot(Mask not_a, Mask b) { return !not_a && b; }
  GVX_HD static constexpr float IfThenElse(Mask mask, float yes, float no) { return mask ? yes : no; }
  GVX_HD static constexpr float IfThenElseZero(Mask mask, float yes) { return mask ? yes : 0.0f; }
  GVX_HD static constexpr float IfThenZeroElse(Mask mask, float no) { return mask ? 0.0f : no; }
  GVX_HD static float GatherIndex(Floats, const float* table, Int index) { return table[index]; }
  GVX_HD static constexpr float MaxOfLanes(Floats, float a) { return a; }
  GVX_HD static constexpr float GetLane(float a) { return a; }
};

GVX_HD constexpr Float all(float value) {
  return value;
}
GVX_HD constexpr bool none(Mask mask) {
  return !mask;
}
GVX_HD constexpr Mask is_no_data(Float value) {
  return value != value;
}
/// Floats that are whole numbers, as integers.
GVX_HD constexpr Int whole(Float value) {
  return static_cast<Int>(value);
}
/// Floats that integers hold, without their fractions.
GVX_HD constexpr Int truncated(Float value) {
  return static_cast<Int>(value);
}
/// The same as floats, of 0 or more.
GVX_HD constexpr Float whole_part(Float value) {
  return static_cast<Float>(static_cast<Int>(value));
}
/// Calls function(i) for i from 0 to 3.
template <typename Function>
GVX_HD inline void for_four(const Function& function) {
  for (int i = 0; i < 4; ++i) function(i);
}

GVX_HD inline void read_integral(const scene::TransferView::Integral* table, Int entry, Int (&sum)[4],
                                 float (&density)[4]) {
  const scene::TransferView::Integral row = table[entry];
  for (int i = 0; i < 4; ++i) {
    sum[i] = static_cast<Int>(row.sum[i]);
    density[i] = row.density[i];
  }
}
GVX_HD inline void read_density(const scene::TransferView::Integral* table, Int entry, float (&density)[4]) {
  for (int i = 0; i < 4; ++i) density[i] = table[entry].density[i];
}
GVX_HD inline void read_matter(const scene::Matter* table, Int entry, float (&matter)[4]) {
  const scene::Matter m = table[entry];
  matter[0] = m.color.x, matter[1] = m.color.y, matter[2] = m.color.z, matter[3] = m.extinction;
}

// What is in pieces or apart for a compiler of vectors.
#define GVX_FORMULA GVX_HD inline
#define GVX_FORMULA_LAMBDA
#define GVX_PIECE GVX_FORMULA
#define GVX_APART GVX_FORMULA
// In this order: each may need those before it.
// clang-format off
#include "gvx/render/formula/sample.inc"
#include "gvx/render/formula/gradient.inc"
#include "gvx/render/formula/transfer.inc"
#include "gvx/render/formula/colors.inc"
#include "gvx/render/formula/preintegrated.inc"
#include "gvx/render/formula/composite.inc"
#include "gvx/render/formula/projection.inc"
#include "gvx/render/formula/isosurface.inc"
#include "gvx/render/formula/each_step.inc"
// clang-format on
#undef GVX_FORMULA
#undef GVX_FORMULA_LAMBDA
#undef GVX_PIECE
#undef GVX_APART

}  // namespace gvx::render::one_lane
