/// \file
/// TransferFunction: physical value to colour and opacity, piecewise linear; and the table that kernels look
/// up.
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
  Vec3d color;  ///< display (sRGB) red, green, blue, 0 to 1

  constexpr bool operator==(const ColorPoint&) const = default;
};

struct OpacityPoint {
  double value;
  double opacity;  ///< 0 to 1, of matter of the unit distance's thickness

  constexpr bool operator==(const OpacityPoint&) const = default;
};

struct GradientPoint {
  double gradient;  ///< physical values per world unit, from 0
  double factor;    ///< 0 to 1, of the extinction

  constexpr bool operator==(const GradientPoint&) const = default;
};

/// Values are physical (Hounsfield units for a CT). Beyond its first and last points a curve stays as it is
/// there.
struct TransferFunction {
  std::vector<ColorPoint> colors;       ///< ascending, at least one
  std::vector<OpacityPoint> opacities;  ///< ascending, at least one; two points of one value make a step
  /// The thickness that the opacities are of, in world units; 0 takes the smallest voxel spacing.
  double unit_distance = 0;
  /// Ascending; if not empty the extinction is multiplied by the factor at the gradient's length, so that
  /// only boundaries remain.
  std::vector<GradientPoint> gradients = {};

  Vec3d color(double value) const;
  double opacity(double value) const;
  double gradient_factor(double gradient) const;
  /// Is the opacity zero at every value from `minimum` to `maximum`?
  bool transparent(double minimum, double maximum) const;

  bool operator==(const TransferFunction&) const = default;
};

/// An error that names the first point out of order or out of bounds.
Status check(const TransferFunction& function);

/// Colour and extinction of matter, per unit distance; the colour is multiplied by the extinction. What a
/// stretch of length d adds: opacity 1 - exp(-extinction * d), of the colour color / extinction.
struct Matter {
  Vec3f color;
  float extinction = 0;

  GVX_HD friend Matter operator+(const Matter& a, const Matter& b) {
    return {a.color + b.color, a.extinction + b.extinction};
  }
};

/// What kernels look up: a stored value v falls on entry v * to_entry_scale + to_entry_offset. Beyond its
/// ends a table goes on as it is there.
///
/// A stretch of a ray is given the mean matter of all values along it, from the running integral of the table
/// (pre-integration by integral functions: Engel, Kraus, Ertl 2001, section 4.4), so that a function's thin
/// layer between two samples is not missed. The integrals are fixed-point and wrap around: their differences
/// stay exact where floats would cancel.
struct TransferView {
  /// From an entry to the next: the running integral up to it in multiples of integral_unit, and the mean
  /// matter; r, g, b, extinction.
  struct alignas(32) Integral {
    std::uint32_t sum[4];
    float density[4];
  };

  /// So narrow, in entries, the integrals' differences would be of few of their units: these are even.
  static constexpr float kNarrow = 0.125f;

  /// A piece of the table in which matter goes along a parabola: the mean of an interval in it that is no
  /// wider than `width` is what is half way, plus `bend` times the square of the interval's width.
  struct Parabola {
    float first = 0, last = 0;  ///< entries
    float width = 0;
    Matter bend;
  };

  /// Where means are known from one lookup.
  struct Even {
    float width = kNarrow;  ///< intervals of no more entries than this have the mean of what is half way
    float above = 0;        ///< and all that begin no lower than this entry
    Parabola piece;
  };

  const Matter* matter = nullptr;      ///< `entries` of them
  const Integral* integral = nullptr;  ///< one an entry
  const std::uint32_t* visible_before =
      nullptr;  ///< entries + 1: how many entries before this one can be seen
  const float* gradient_factor =
      nullptr;  ///< kGradientEntries, or null: factor of the extinction by gradient
  int entries = 0;
  float integral_unit = 0, integrals_per_unit = 0;  ///< one is the other's inverse
  float first_visible = 0, last_visible = 0;        ///< up to the one and from the other on nothing is seen
  Even even;
  float to_entry_scale = 0, to_entry_offset = 0;
  float length_per_entry = 1;   ///< see length()
  float to_gradient_entry = 0;  ///< from a gradient in stored values per world unit

  static constexpr int kEntries = 4096;       ///< of most tables of scalars; labels have one each
  static constexpr int kMostEntries = 65536;  ///< of a table of scalars whose function is steep somewhere
  static constexpr int kGradientEntries = 256;

  GVX_HD float entry_of(float stored) const { return stored * to_entry_scale + to_entry_offset; }

  /// How far it is from one entry to another, in 4096ths of the table: how often a way through the function
  /// is cut does not depend on how fine the table is.
  GVX_HD float length(float from, float to) const { return std::fabs(to - from) * length_per_entry; }

  /// Matter at one entry, linear between two.
  GVX_HD Matter at(float entry) const {
    const EntryPosition p = place(entry);
    return mix(matter[p.low], matter[p.low + 1], p.weight);
  }

  /// What the running integrals are at an entry: two of these give the mean matter between them.
  struct Reading {
    float entry = 0;
    std::uint32_t sum[4] = {};
  };

  GVX_HD Reading read(float entry) const {
    const EntryPosition p = place(entry);
    const Integral& at = integral[p.low];
    const float units = p.weight * integrals_per_unit;
    Reading reading;
    reading.entry = entry;
    for (int i = 0; i < 4; ++i) {
      reading.sum[i] =
          at.sum[i] + static_cast<std::uint32_t>(static_cast<std::int32_t>(units * at.density[i]));
    }
    return reading;
  }

  /// The mean matter of the entries between two readings, which are equally likely and more than kNarrow
  /// apart.
  GVX_HD Matter mean(const Reading& a, const Reading& b) const {
    const float last = static_cast<float>(entries - 1);
    const float width = b.entry - a.entry;
    const float scale = integral_unit / width;
    float sum[4];
    for (int i = 0; i < 4; ++i) {
      sum[i] = scale * static_cast<float>(static_cast<std::int32_t>(b.sum[i] - a.sum[i]));
    }
    Matter m{{sum[0], sum[1], sum[2]}, sum[3]};
    const float before = std::fmin(b.entry, 0.0f) - std::fmin(a.entry, 0.0f);
    const float behind = std::fmax(b.entry, last) - std::fmax(a.entry, last);
    if (before != 0.0f) m = mix(m, m + matter[0], before / width);
    if (behind != 0.0f) m = mix(m, m + matter[entries - 1], behind / width);
    return m;
  }

  /// The mean matter of the entries from one to another.
  GVX_HD Matter mean(float from, float to) const {
    if (invisible(from, to)) return {};
    if (!is_in_parabola(from, to)) {
      return is_even(from, to) ? density_at(0.5f * (from + to)) : mean(read(from), read(to));
    }
    const Matter half_way = density_at(0.5f * (from + to));
    const float square = (to - from) * (to - from);
    return {half_way.color + square * even.piece.bend.color,
            half_way.extinction + square * even.piece.bend.extinction};
  }

  /// Is the function so even between two entries that its mean there is what it is half way?
  GVX_HD bool is_even(float from, float to) const {
    return !(std::fabs(to - from) > even.width) || std::fmin(from, to) >= even.above;
  }
  GVX_HD bool is_in_parabola(float from, float to) const {
    const Parabola& p = even.piece;
    return std::fmin(from, to) >= p.first && std::fmax(from, to) <= p.last && std::fabs(to - from) <= p.width;
  }

  /// The mean matter of as little around an entry as the table tells apart; below the first, that behind it.
  GVX_HD Matter density_at(float entry) const {
    const float* density =
        integral[static_cast<int>(clamped(entry, static_cast<float>(entries - 1)))].density;
    return {{density[0], density[1], density[2]}, density[3]};
  }

  /// The whole entry that is nearest to one.
  GVX_HD int nearest(float entry) const {
    const float half_above = clamped(entry + 0.5f, static_cast<float>(entries - 1));
    return static_cast<int>(half_above);
  }

  /// Can no value between two entries be seen? Conservative: true is certain.
  GVX_HD bool invisible(float a, float b) const {
    return std::fmax(a, b) <= first_visible || std::fmin(a, b) >= last_visible;
  }

  /// Is every stored value of the range below all that can be seen, even if values deviate by as much as this
  /// (EntryPath::mean)? So is then what lies between two such.
  GVX_HD bool below_visible(ValueRange stored, float deviation = 0) const {
    constexpr float kSqrt3 = 1.7320509f;
    return std::fmax(entry_of(stored.minimum), entry_of(stored.maximum)) +
               kSqrt3 * std::fabs(deviation * to_entry_scale) <=
           first_visible;
  }
  /// Are those entries that cannot be seen all below those that can?
  GVX_HD bool hides_lowest_only() const {
    const int hidden = first_visible < 0 ? 0 : static_cast<int>(first_visible) + 1;
    return static_cast<int>(visible_before[entries]) == entries - hidden;
  }

  /// Matter of a label.
  GVX_HD Matter of_label(std::uint32_t label) const {
    return matter[label < static_cast<std::uint32_t>(entries) ? label
                                                              : static_cast<std::uint32_t>(entries - 1)];
  }

  /// What a gradient of this length, in stored values per world unit, multiplies the extinction by.
  GVX_HD float factor_of_gradient(float steepness) const {
    float entry = steepness * to_gradient_entry;
    entry = entry < float(kGradientEntries - 1) ? entry : float(kGradientEntries - 1);
    int low = static_cast<int>(entry);
    low = low < kGradientEntries - 2 ? low : kGradientEntries - 2;
    return gradient_factor[low] +
           (entry - static_cast<float>(low)) * (gradient_factor[low + 1] - gradient_factor[low]);
  }

  /// Is every stored value of the range looked up as fully transparent? Conservative: true is certain.
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

/// The table's host side.
struct TransferTable {
  std::vector<Matter> matter;
  std::vector<TransferView::Integral> integral;
  std::vector<std::uint32_t> visible_before;
  std::vector<float> gradient_factor;  ///< empty where the gradient does not matter
  float integral_unit = 0;
  float first_visible = 0, last_visible = 0;
  TransferView::Even even;
  float to_entry_scale = 0, to_entry_offset = 0;
  float to_gradient_entry = 0;
  double span = 0;  ///< stored values that the function tells apart, of those that there are

  TransferView view() const;
};

/// The values that a function may be asked for, physical.
struct ValueSpan {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();

  bool operator==(const ValueSpan&) const = default;
};

/// Samples a function over the values between its outermost points, as far as there are such values, for
/// stored values with physical = scale * stored + offset. Extinctions are held at `most_extinction`.
///
/// A table has TransferView::kEntries; where the function is so steep that from one entry to the next it
/// would change by more than a 32nd of its greatest, up to kMostEntries. Where that is too few, too, it is
/// laid over what is between the first and the last bend alone.
TransferTable bake(const TransferFunction& function, double scale, double offset, double most_extinction,
                   ValueSpan values = {});

/// One entry for each of the stored labels 0 to `labels` - 1.
TransferTable bake_labels(const TransferFunction& function, double scale, double offset,
                          std::uint32_t labels);

/// For colour voxels, whose ranges are of their opacity: only what is 0 cannot be seen.
TransferTable bake_opacities();

}  // namespace gvx::scene
