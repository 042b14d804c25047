/// \file
/// TransferFunction: gives each physical value a colour and an opacity, piecewise linear. TransferTable and
/// TransferView: the table in which kernels look it up.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"

namespace gvx::scene {

struct ColorPoint {
  double value;
  Vec3d color;  ///< red, green, blue as displayed (sRGB), 0 to 1

  constexpr bool operator==(const ColorPoint&) const = default;
};

struct OpacityPoint {
  double value;
  double opacity;  ///< 0 to 1, of matter as thick as the unit distance

  constexpr bool operator==(const OpacityPoint&) const = default;
};

struct GradientPoint {
  double gradient;  ///< physical values per world unit, from 0
  double factor;    ///< 0 to 1; multiplies the extinction

  constexpr bool operator==(const GradientPoint&) const = default;
};

/// Values are physical, such as Hounsfield units for a CT. Beyond its first and last points a curve is
/// constant.
struct TransferFunction {
  std::vector<ColorPoint> colors;       ///< ascending, at least one
  std::vector<OpacityPoint> opacities;  ///< ascending, at least one; two points of the same value are a step
  /// The thickness of matter that has these opacities, in world units. 0: the smallest voxel spacing.
  double unit_distance = 0;
  /// Ascending; may be empty. Otherwise the extinction is multiplied by the factor for the gradient's length.
  /// So boundaries can be shown alone.
  std::vector<GradientPoint> gradients = {};

  // To build one up. Points may come in any order; two of one value are a step, in the order in which they
  // were added.
  TransferFunction& add_color(double value, Vec3d color);
  TransferFunction& add_opacity(double value, double opacity);
  TransferFunction& add_gradient(double gradient, double factor);
  TransferFunction& set_unit_distance(double distance) {
    unit_distance = distance;
    return *this;
  }

  Vec3d color(double value) const;
  double opacity(double value) const;
  double gradient_factor(double gradient) const;
  /// Is the opacity zero at every value from `minimum` to `maximum`?
  bool transparent(double minimum, double maximum) const;

  bool operator==(const TransferFunction&) const = default;
};

/// An error that names the first point that is out of order or out of bounds.
Status check(const TransferFunction& function);

/// Colour and extinction of matter, per unit distance. The colour is multiplied by the extinction. A piece of
/// a ray of length d adds the opacity 1 - exp(-extinction * d), in the colour color / extinction.
struct Matter {
  Vec3f color;
  float extinction = 0;

  GVX_HD friend Matter operator+(const Matter& a, const Matter& b) {
    return {a.color + b.color, a.extinction + b.extinction};
  }
};

/// The table for kernels. A stored value v is found at entry v * to_entry_scale + to_entry_offset. Beyond its
/// first and last entries the table is constant.
///
/// A piece of a ray shows the mean matter of all values between its ends, so a thin layer between two samples
/// is not missed. The mean comes from the running integral of the table (pre-integration by integral
/// functions: Engel, Kraus, Ertl 2001, section 4.4). The integrals are fixed-point numbers that wrap around.
/// Their differences are exact; those of floats would lose small values.
struct TransferView {
  /// Of an entry: the running integral up to it, in multiples of integral_unit, and the mean matter from it
  /// to the next entry. Each is red, green, blue and extinction.
  struct alignas(32) Integral {
    std::uint32_t sum[4];
    float density[4];
  };

  /// Intervals of fewer entries than this are taken as even: the difference of their integrals would be only
  /// a few units.
  static constexpr float kNarrow = 0.125f;

  /// A piece of the table in which matter follows a parabola. The mean over an interval of at most `width` is
  /// the matter at its middle, plus `bend` times the square of the interval's width.
  struct Parabola {
    float first = 0, last = 0;  ///< entries
    float width = 0;
    Matter bend;
  };

  /// Intervals whose mean is found by a single lookup.
  struct Even {
    float width = kNarrow;  ///< those of at most this many entries: the mean is the matter at the middle
    float above = 0;        ///< all that begin at this entry or above: likewise
    Parabola piece;
  };

  const Matter* matter = nullptr;      ///< one for each entry
  const Integral* integral = nullptr;  ///< one for each entry
  const std::uint32_t* visible_before =
      nullptr;  ///< entries + 1 of them: how many of the entries before this one are visible
  const float* gradient_factor =
      nullptr;  ///< kGradientEntries factors of the extinction, by gradient; or null
  int entries = 0;
  float integral_unit = 0, integrals_per_unit = 0;  ///< each is the inverse of the other
  float first_visible = 0, last_visible = 0;  ///< up to the first, and from the last on, nothing is visible
  Even even;
  float to_entry_scale = 0, to_entry_offset = 0;
  float length_per_entry = 1;   ///< 4096ths of the table: how far two entries are apart
  float to_gradient_entry = 0;  ///< from a gradient in stored values per world unit

  static constexpr int kEntries = 4096;       ///< of most tables of scalars; for labels, one for each label
  static constexpr int kMostEntries = 65536;  ///< of tables of scalars whose function is steep somewhere
  static constexpr int kGradientEntries = 256;

  GVX_HD float entry_of(float stored) const { return stored * to_entry_scale + to_entry_offset; }

  /// Matter at an entry; between two entries linear.
  GVX_HD Matter at(float entry) const {
    const EntryPosition p = place(entry);
    return mix(matter[p.low], matter[p.low + 1], p.weight);
  }

  /// Is every stored value of the range below all visible values, even with this deviation around them?
  /// If two values are, so are all values between them.
  GVX_HD bool below_visible(ValueRange stored, float deviation = 0) const {
    constexpr float kSqrt3 = 1.7320509f;
    return std::fmax(entry_of(stored.minimum), entry_of(stored.maximum)) +
               kSqrt3 * std::fabs(deviation * to_entry_scale) <=
           first_visible;
  }
  /// Are all invisible entries below all visible ones?
  GVX_HD bool hides_lowest_only() const {
    const int hidden = first_visible < 0 ? 0 : static_cast<int>(first_visible) + 1;
    return static_cast<int>(visible_before[entries]) == entries - hidden;
  }

  /// Matter of a label.
  GVX_HD Matter of_label(std::uint32_t label) const {
    return matter[label < static_cast<std::uint32_t>(entries) ? label
                                                              : static_cast<std::uint32_t>(entries - 1)];
  }

  /// Is every stored value of the range fully transparent? True is certain; false may be wrong.
  GVX_HD bool transparent(ValueRange stored) const {
    const float last_entry = static_cast<float>(entries - 1);
    const EntryPosition a =
        place(clamped(entry_of(to_entry_scale >= 0 ? stored.minimum : stored.maximum), last_entry));
    const EntryPosition b =
        place(clamped(entry_of(to_entry_scale >= 0 ? stored.maximum : stored.minimum), last_entry));
    // A value on an entry, as all beyond the table's ends are, takes nothing from the entry beside it.
    const int first = a.low + (a.weight >= 1.0f ? 1 : 0), last = b.low + (b.weight > 0.0f ? 1 : 0);
    return visible_before[last + 1] == visible_before[first];
  }

 private:
  /// Between two entries.
  struct EntryPosition {
    int low;
    float weight;
  };
  GVX_HD static float clamped(float entry, float last) {
    entry = entry > 0.0f ? entry : 0.0f;
    return entry < last ? entry : last;
  }
  GVX_HD EntryPosition place(float entry) const {
    const float e = clamped(entry, static_cast<float>(entries - 1));
    int low = static_cast<int>(e);
    low = low < entries - 2 ? low : entries - 2;
    return {low, e - static_cast<float>(low)};
  }
  GVX_HD static Matter mix(const Matter& a, const Matter& b, float weight) {
    return {a.color + weight * (b.color - a.color), a.extinction + weight * (b.extinction - a.extinction)};
  }
};

/// Owns the table, on the host.
struct TransferTable {
  std::vector<Matter> matter;
  std::vector<TransferView::Integral> integral;
  std::vector<std::uint32_t> visible_before;
  std::vector<float> gradient_factor;  ///< empty if the function does not depend on the gradient
  float integral_unit = 0;
  float first_visible = 0, last_visible = 0;
  TransferView::Even even;
  float to_entry_scale = 0, to_entry_offset = 0;
  float to_gradient_entry = 0;
  double span = 0;  ///< width of the range of stored values in which the function changes

  TransferView view() const;
};

/// The range of physical values for which a function is looked up.
struct ValueSpan {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();

  bool operator==(const ValueSpan&) const = default;
};

/// Makes the table of a function. It spans the function's points, but no more than `values`. Physical values
/// are scale * stored + offset. Extinctions are at most `most_extinction`.
///
/// A table has TransferView::kEntries. It has more, up to kMostEntries, if the function would change by more
/// than a 32nd of its greatest value from one entry to the next. If these are too few as well, the table
/// spans only the values between the first and the last bend.
TransferTable bake(const TransferFunction& function, double scale, double offset, double most_extinction,
                   ValueSpan values = {});

/// The table for labels: an entry for each stored label from 0 to `labels` - 1.
TransferTable bake_labels(const TransferFunction& function, double scale, double offset,
                          std::uint32_t labels);

/// The table for colour voxels. Their ranges are those of their opacity; only 0 is invisible.
TransferTable bake_opacities();

}  // namespace gvx::scene
