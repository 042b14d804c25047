/// \file
/// AddedNoise: a volume's values with noise added: detail that it does not have (amplification, section 6.3
/// of the 2008 report) or, where the values are distances, hypertexture (Perlin and Hoffert, SIGGRAPH 1989).
#pragma once

#include "gvx/core/noise.h"
#include "gvx/core/voxel.h"

namespace gvx {

struct AddedNoise {
  FractalNoise noise;   ///< in tree space
  double strength = 0;  ///< of the first octave, in stored values
  /// Less towards the ends of these values, and nothing there: what is empty or full stays so. Of one value:
  /// the same everywhere.
  ValueRange fades;

  /// What the strength is multiplied by at a value.
  GVX_HD static double share_at(double value, ValueRange fades) {
    const double width = double(fades.maximum) - fades.minimum;
    if (!(width > 0)) return 1;
    const double part = (value - fades.minimum) / width;
    return part > 0 && part < 1 ? 4 * part * (1 - part) : 0;
  }

  /// The most that share_at() is of these values.
  GVX_HD static double most_share(ValueRange values, ValueRange fades) {
    const double middle = 0.5 * (double(fades.minimum) + fades.maximum);
    return values.maximum < middle ? share_at(values.maximum, fades)
                                   : share_at(values.minimum > middle ? values.minimum : middle, fades);
  }

  /// What is added to a value at a place, for voxels of this width.
  GVX_HD float at(double value, Vec3d place, double footprint) const {
    const double share = share_at(value, fades);
    return share > 0 ? static_cast<float>(share * strength * noise(place, footprint)) : 0.0f;
  }
  /// It is never more.
  GVX_HD double most() const { return strength * noise.most(); }

  bool operator==(const AddedNoise&) const = default;
};

}  // namespace gvx
