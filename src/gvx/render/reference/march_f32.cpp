// The march over bricks of f32 voxels.

#include "gvx/render/reference/march_kernels.h"

namespace gvx::render::kernels {

GVX_INSTANTIATE_MARCH(, float)

}  // namespace gvx::render::kernels
