/// \file
/// Over which intervals of a transfer table one lookup half way gives the mean.
#pragma once

#include <vector>

#include "gvx/scene/transfer_function.h"

namespace gvx::scene {

/// Fills in TransferTable::even. `stops` are where the function's slopes may change, in entries, sorted.
/// Means over more than kNarrow are then right to 1/1024 of the greatest colour and extinction, but for what
/// those are where next to nothing is let through.
void find_even_means(const std::vector<double>& stops, TransferTable& table);

}  // namespace gvx::scene
