/// \file
/// What the table of a transfer function cannot tell apart.
#pragma once

#include <optional>
#include <utility>

#include "gvx/scene/transfer_function.h"

namespace gvx::scene {

/// The values of two neighbouring points that are less than two entries of the largest table apart, as others
/// that bend the function are too far away from them: what is between is blurred. Nothing where there are
/// none; of several the closest.
std::optional<std::pair<double, double>> points_too_close(const TransferFunction& function, ValueSpan values);

}  // namespace gvx::scene
