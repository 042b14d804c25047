/// \file
/// The techniques once more, over vectors of rays: they find what techniques.h finds, but for rounding.
#pragma once

#include "gvx/surface/draw/techniques.h"

namespace gvx::surface {

/// As cast_samples().
void cast_samples_in_vectors(const DrawnSamples& drawn, TileHits& hits);

/// As rasterise(); corners are rounded to 1/256 of a pixel.
void rasterise_in_vectors(const DrawnTriangles& drawn, TileHits& hits);

}  // namespace gvx::surface
