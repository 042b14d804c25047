/// \file
/// What turns a transfer function to other values, and makes it more or less opaque, without new points.
#pragma once

#include "gvx/scene/transfer_function.h"

namespace gvx::scene {

/// Level and width of a window, as radiologists say it: from level - width / 2 to level + width / 2.
struct ValueWindow {
  double level = 0;
  double width = 1;  ///< above 0

  ValueSpan span() const { return {level - 0.5 * width, level + 0.5 * width}; }
  bool operator==(const ValueWindow&) const = default;
};

/// Percentiles of a volume's voxels, 0 to 100; the first below the last.
struct PercentileRange {
  double first = 0, last = 100;

  bool operator==(const PercentileRange&) const = default;
};

/// The function with its values moved and stretched so that its first point lies at the span's minimum and
/// its last at the maximum. Gradients stay.
TransferFunction stretched(TransferFunction function, ValueSpan span);

/// The function with its opacities multiplied by `factor`, and held at 1.
TransferFunction with_opacity_factor(TransferFunction function, double factor);

}  // namespace gvx::scene
