// The march over bricks of u16 voxels.

#include "gvx/render/reference/march_kernels.h"

namespace gvx::render::kernels {

GVX_INSTANTIATE_MARCH(, std::uint16_t)

}  // namespace gvx::render::kernels
