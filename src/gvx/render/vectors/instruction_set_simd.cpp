// Which instruction sets the vectors were compiled for, and which of them runs.

#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/instruction_set_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "gvx/render/vectors/instruction_set.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {

const char* name_of_set() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(name_of_set);

const std::int64_t kInstructionSets = HWY_TARGETS;
const std::int64_t kLeastInstructionSet = HWY_STATIC_TARGET;

const char* instruction_set() {
  return HWY_DYNAMIC_DISPATCH(name_of_set)();
}

}  // namespace gvx::render
#endif
