// The march of tiles of volumes of float.

#include "gvx/render/tile_passes.h"

namespace gvx::render {

GVX_INSTANTIATE_TILE_MARCH(, float)

}  // namespace gvx::render
