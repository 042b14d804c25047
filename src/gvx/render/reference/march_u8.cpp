// The march over bricks of u8 voxels.

#include "gvx/render/reference/march_kernels.h"

namespace gvx::render::kernels {

GVX_INSTANTIATE_MARCH(, std::uint8_t)

}  // namespace gvx::render::kernels
