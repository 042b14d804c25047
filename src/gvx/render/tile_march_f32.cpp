// The march of tiles of volumes of float.

#include "gvx/render/tile_marcher.h"

namespace gvx::render {

GVX_INSTANTIATE_TILE_MARCH(, float)

}  // namespace gvx::render
