/// \file
/// Transfer functions that fit themselves to a volume's values.
#pragma once

#include "gvx/scene/transfer_function.h"
#include "gvx/scene/value_statistics.h"

namespace gvx::scene {

/// A head from outside: what is brighter than air and its noise.
TransferFunction mr_function(const ValueStatistics& statistics);

/// The same of anything that stands out from its background. Thin walls let through what is behind them.
TransferFunction surface_function(const ValueStatistics& statistics);

/// Translucent layers, coloured by shares of the voxels, of a field without borders. A ray through the volume
/// sees into its middle, however many voxels there are.
TransferFunction layers_function(const ValueStatistics& statistics);

/// Blue below zero, red above it, transparent around it.
TransferFunction diverging_function(const ValueStatistics& statistics);

/// Light from the brightest few per cent, one hue a channel; nothing hides much of what is behind it.
TransferFunction microscopy_function(const ValueStatistics& statistics);

/// Do the values lie to either side of zero, and most of them near it?
bool is_around_zero(const ValueStatistics& statistics);

/// Does the histogram fall into background and object?
bool has_surface(const ValueStatistics& statistics);

}  // namespace gvx::scene
