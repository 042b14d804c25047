/// \file
/// TransferFunction: physical value to colour and opacity, piecewise linear; and the table that kernels look
/// up.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"

namespace gvx::scene {

struct ColorPoint {
  double value;
  Vec3d color;  ///< display (sRGB) red, green, blue, 0 to 1

  constexpr bool operator==(const ColorPoint&) const = default;
};

struct OpacityPoint {
  double value;
  double opacity;  ///< 0 to 1, of matter of the unit distance's thickness

  constexpr bool operator==(const OpacityPoint&) const = default;
};

/// Values are physical (Hounsfield units for a CT). Beyond its first and last points a curve stays as it is
/// there.
struct TransferFunction {
  std::vector<ColorPoint> colors;       ///< ascending, at least one
  std::vector<OpacityPoint> opacities;  ///< ascending, at least one; two points of one value make a step
  /// The thickness that the opacities are of, in world units; 0 takes the smallest voxel spacing.
  double unit_distance = 0;

  Vec3d color(double value) const;
  double opacity(double value) const;
  /// Is the opacity zero at every value from `minimum` to `maximum`?
  bool transparent(double minimum, double maximum) const;

  bool operator==(const TransferFunction&) const = default;
};

/// An error that names the first point out of order or out of bounds.
Status check(const TransferFunction& function);

/// What kernels look up: a stored value v falls on entry v * to_entry_scale + to_entry_offset.
struct TransferView {
  const Vec3f* colors = nullptr;
  const float* opacities = nullptr;  ///< of one step at each level: kEntries per level
  const std::uint32_t* opaque_before = nullptr;
  float to_entry_scale = 0, to_entry_offset = 0;

  static constexpr int kEntries = 4096;

  /// The place of a stored value between two entries.
  struct Place {
    int low;
    float weight;
  };
  GVX_HD Place place(float stored) const {
    float entry = stored * to_entry_scale + to_entry_offset;
    entry = entry > 0.0f ? entry : 0.0f;
    entry = entry < float(kEntries - 1) ? entry : float(kEntries - 1);
    int low = static_cast<int>(entry);
    low = low < kEntries - 2 ? low : kEntries - 2;
    return {low, entry - static_cast<float>(low)};
  }
  GVX_HD float opacity(Place p, int level) const {
    const float* o = opacities + level * kEntries + p.low;
    return o[0] + p.weight * (o[1] - o[0]);
  }
  GVX_HD Vec3f color(Place p) const { return colors[p.low] + p.weight * (colors[p.low + 1] - colors[p.low]); }

  /// Is every stored value of the range looked up as fully transparent? Conservative: true is certain.
  GVX_HD bool transparent(ValueRange stored) const {
    const Place a = place(to_entry_scale >= 0 ? stored.minimum : stored.maximum);
    const Place b = place(to_entry_scale >= 0 ? stored.maximum : stored.minimum);
    // A value on an entry, as all beyond the table's ends are, takes nothing from the entry beside it.
    const int first = a.low + (a.weight >= 1.0f ? 1 : 0), last = b.low + (b.weight > 0.0f ? 1 : 0);
    return opaque_before[last + 1] == opaque_before[first];
  }
};

/// The table's host side: sampled from the function over the values between its outermost points.
struct TransferTable {
  std::vector<Vec3f> colors;     ///< kEntries
  std::vector<float> opacities;  ///< kEntries per step length
  std::vector<std::uint32_t>
      opaque_before;  ///< kEntries + 1: how many entries before this one are not transparent
  float to_entry_scale = 0, to_entry_offset = 0;

  TransferView view() const {
    return {colors.data(), opacities.data(), opaque_before.data(), to_entry_scale, to_entry_offset};
  }
};

/// Samples a function for stored values with physical = scale * stored + offset, and for each of
/// `step_units`, the length of a step in unit distances: the opacity of a step is 1 - (1 -
/// opacity)^step_units.
TransferTable bake(const TransferFunction& function, double scale, double offset,
                   std::span<const double> step_units);

/// The names that preset() knows.
std::span<const char* const> preset_names();

/// What is known of a volume when no transfer function is given.
struct ValueStatistics {
  double minimum = 0, maximum = 0;       ///< physical
  std::vector<std::uint64_t> histogram;  ///< equal bins from minimum to maximum; may be empty
};

/// A ready transfer function by name; "gray" fits itself to the statistics, the CT presets speak of
/// Hounsfield units.
Result<TransferFunction> preset(const std::string& name, const ValueStatistics& statistics);

/// The preset that suits values like these: a CT by its Hounsfield range, "gray" for the rest.
std::string suggest_preset(const ValueStatistics& statistics);

}  // namespace gvx::scene
