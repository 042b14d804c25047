#include "gvx/render/vectors/instruction_set.h"

#include <string>

#include <hwy/targets.h>

namespace gvx::render {

Status check_processor() {
  if ((hwy::SupportedTargets() & kInstructionSets) != 0) return {};
  return Error{std::string("this gvx was built for processors with ") +
               hwy::TargetName(kLeastInstructionSet) +
               " (AVX3 means AVX-512), which this one lacks; build it here, or with -DGVX_VECTORS=all"};
}

}  // namespace gvx::render
