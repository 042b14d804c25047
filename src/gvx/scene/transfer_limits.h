/// \file
/// What the table of a transfer function cannot tell apart.
#pragma once

#include <optional>
#include <utility>

#include "gvx/scene/transfer_function.h"

namespace gvx::scene {

/// The values of the two neighbouring points that are closest to each other, where these are less than two
/// entries of the largest table apart, so that what is between is blurred; else nothing. It happens where
/// other points that bend the function are far away.
std::optional<std::pair<double, double>> points_too_close(const TransferFunction& function, ValueSpan values);

}  // namespace gvx::scene
