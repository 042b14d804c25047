/// \file
/// What becomes of a distance and noise in a hypertexture: functions that kernels call, too.
#pragma once

#include <algorithm>
#include <array>

#include "gvx/core/noise.h"
#include "gvx/produce/coverage.h"

namespace gvx::produce {

/// The forms of figure 7 of the report.
enum class HypertextureKind {
  hypertexture,  ///< a soft step of d + thickness * strength * noise
  pseudo_mesh,   ///< the surface itself, a voxel or two thick
  ramp,          ///< an even slope across the shell
  blurred,       ///< thin towards the outside: a soft silhouette
  solid_noise    ///< the surface, and noise as what is inside
};
inline constexpr std::array<const char*, 5> kHypertextureNames = {"hypertexture", "pseudo-mesh", "ramp",
                                                                  "blurred", "solid-noise"};

struct HypertextureOptions {
  HypertextureKind kind = HypertextureKind::hypertexture;
  double thickness = 0.06;  ///< of the shell, in tree space
  double strength = 0.9;    ///< of the noise, in thicknesses
  FractalNoise noise{.octaves = 8, .wavelength = 0.08};

  /// A surface has no shell.
  GVX_HD double shell() const {
    const bool surface = kind == HypertextureKind::pseudo_mesh || kind == HypertextureKind::solid_noise;
    return surface ? 0 : thickness;
  }
  /// By how much noise moves the surface.
  GVX_HD double shift() const { return kind == HypertextureKind::hypertexture ? strength * thickness : 0; }
};

/// What a coverage of 0 to 1 shows as; grows with it.
GVX_HD inline double shaped(HypertextureKind kind, double c) {
  switch (kind) {
    case HypertextureKind::hypertexture:
      return c * c * (3 - 2 * c);
    case HypertextureKind::blurred:
      return c * c * c;
    default:
      return c;
  }
}

/// The share of what is inside that noise leaves.
GVX_HD inline double solid_share(double noise) {
  return std::clamp(0.55 + 0.9 * noise, 0.15, 1.0);
}

/// The density, 0 (outside) to 1, at a distance from the surface, in voxels of this spacing.
GVX_HD inline double density_at(const HypertextureOptions& options, double distance, double noise,
                                double spacing) {
  const double width = coverage_width(options.shell(), spacing);
  const double density = shaped(options.kind, coverage(distance + options.shift() * noise, width));
  return options.kind == HypertextureKind::solid_noise ? density * solid_share(noise) : density;
}

/// Holds the densities of a box's places, whose distances are in a range.
GVX_HD inline ValueRange density_bounds(const HypertextureOptions& options, ValueRange d, const Box3d& box,
                                        double coarsest_spacing) {
  const double strength = options.shift(), shift = strength * options.noise.most();
  const double most_width = coverage_width(options.shell(), coarsest_spacing);
  const bool far = d.minimum > 0.5 * most_width + shift || d.maximum < -0.5 * most_width - shift;
  noise::Interval t{d.minimum, d.maximum};
  if (strength > 0 && !far) {
    const noise::Interval n = options.noise.bounds(box, coarsest_spacing);
    // Where noise makes no difference it may have been left out.
    t = {t.low + std::min(strength * n.low, 0.0), t.high + std::max(strength * n.high, 0.0)};
  }
  const noise::Interval c = coverage_bounds(t, options.shell(), most_width);
  double low = shaped(options.kind, c.low), high = shaped(options.kind, c.high);
  if (options.kind == HypertextureKind::solid_noise && high > 0) {
    const noise::Interval n = options.noise.bounds(box, coarsest_spacing);
    low *= solid_share(n.low), high *= solid_share(n.high);
  }
  return {static_cast<float>(low), static_cast<float>(high)};
}

}  // namespace gvx::produce
