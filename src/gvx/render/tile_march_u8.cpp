// The march of tiles of volumes of std::uint8_t.

#include "gvx/render/tile_passes.h"

namespace gvx::render {

GVX_INSTANTIATE_TILE_MARCH(, std::uint8_t)

}  // namespace gvx::render
