// The march of tiles of volumes of std::uint16_t.

#include "gvx/render/tile_passes.h"

namespace gvx::render {

GVX_INSTANTIATE_TILE_MARCH(, std::uint16_t)

}  // namespace gvx::render
