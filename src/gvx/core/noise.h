/// \file
/// Gradient noise and sums of its octaves, with what an oracle needs: bounds over a box. Octaves that a voxel
/// cannot resolve are left out, so that noise is filtered by being made coarsely.
///
/// Sources: Perlin, "Improving Noise", SIGGRAPH 2002 (the fade curve and the twelve gradients); Norton,
/// Rockwood, Skolmoski, "Clamping", SIGGRAPH 1982 (octaves that fade out below the footprint). Lattice points
/// are hashed, not permuted: the noise does not repeat.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/ray.h"
#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"

namespace gvx {

namespace noise {

/// 0 to 1 with slopes and curvatures of 0 at both.
GVX_HD inline double fade(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

/// Which of the gradients a lattice point has, 0 to 15.
GVX_HD inline std::uint32_t gradient_at(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ull +
                    static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4full +
                    static_cast<std::uint64_t>(z) * 0x165667b19e3779f9ull + seed * 0x27d4eb2f165667c5ull;
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93ull;
  return static_cast<std::uint32_t>(h >> 60);
}

/// The product of gradient `g`, a middle of one of the cube's edges, and a vector. T: a number or an
/// interval.
template <typename T>
GVX_HD T gradient_product(std::uint32_t g, T x, T y, T z) {
  const T u = g < 8 ? x : y;
  const T v = g < 4 ? y : g == 12 || g == 14 ? x : z;
  return ((g & 1) == 0 ? u : -u) + ((g & 2) == 0 ? v : -v);
}

/// All numbers from low to high.
struct Interval {
  double low = 0, high = 0;
};
GVX_HD inline Interval operator+(Interval a, Interval b) {
  return {a.low + b.low, a.high + b.high};
}
GVX_HD inline Interval operator-(Interval a) {
  return {-a.high, -a.low};
}
GVX_HD inline double mix(double a, double b, double share) {
  return a + share * (b - a);
}
/// For shares from 0 to 1: what is mixed grows with a and with b, and is linear in the share.
GVX_HD inline Interval mix(Interval a, Interval b, Interval share) {
  return {std::fmin(mix(a.low, b.low, share.low), mix(a.low, b.low, share.high)),
          std::fmax(mix(a.high, b.high, share.low), mix(a.high, b.high, share.high))};
}
GVX_HD inline Interval fade(Interval t) {
  return {fade(t.low), fade(t.high)};
}
GVX_HD inline Interval from(Interval t, double origin) {
  return {t.low - origin, t.high - origin};
}
GVX_HD inline double from(double t, double origin) {
  return t - origin;
}

/// The noise at a place (x, y, z) of 0 to 1 in a lattice cell. T: numbers, or intervals of them.
template <typename T>
GVX_HD T in_cell(std::int64_t ix, std::int64_t iy, std::int64_t iz, T x, T y, T z, std::uint32_t seed) {
  const auto corner = [&](int cx, int cy, int cz) {
    return gradient_product(gradient_at(ix + cx, iy + cy, iz + cz, seed), from(x, cx), from(y, cy),
                            from(z, cz));
  };
  const T u = fade(x), v = fade(y), w = fade(z);
  const T front = mix(mix(corner(0, 0, 0), corner(1, 0, 0), u), mix(corner(0, 1, 0), corner(1, 1, 0), u), v);
  const T back = mix(mix(corner(0, 0, 1), corner(1, 0, 1), u), mix(corner(0, 1, 1), corner(1, 1, 1), u), v);
  return mix(front, back, w);
}

}  // namespace noise

/// Perlin's noise at p: 0 at lattice points, which are 1 apart; within kPerlinMost of 0.
GVX_HD inline double perlin(Vec3d p, std::uint32_t seed) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  return noise::in_cell(static_cast<std::int64_t>(fx), static_cast<std::int64_t>(fy),
                        static_cast<std::int64_t>(fz), p.x - fx, p.y - fy, p.z - fz, seed);
}

/// Adds scale * perlin(first + i * step along x) to sums[i], for `count` places. What a cell's places share
/// is found once for all of them.
GVX_HD inline void add_perlin_row(Vec3d first, double step, std::uint32_t count, std::uint32_t seed,
                                  double scale, double* sums) {
  const double fy = std::floor(first.y), fz = std::floor(first.z);
  const double y = first.y - fy, z = first.z - fz, v = noise::fade(y), w = noise::fade(z);
  const auto iy = static_cast<std::int64_t>(fy), iz = static_cast<std::int64_t>(fz);
  // At x in its cell a face's noise is at + slope * x, once y and z are mixed.
  struct Face {
    double at = 0, slope = 0;
  };
  const auto face_of = [&](std::int64_t ix) {
    Face face;
    for (int corner = 0; corner < 4; ++corner) {
      const int cy = corner & 1, cz = corner >> 1;
      const double weight = (cy ? v : 1 - v) * (cz ? w : 1 - w);
      const std::uint32_t g = noise::gradient_at(ix, iy + cy, iz + cz, seed);
      face.at += weight * noise::gradient_product(g, 0.0, y - cy, z - cz);
      face.slope += weight * noise::gradient_product(g, 1.0, 0.0, 0.0);
    }
    return face;
  };
  double cell = std::floor(first.x);
  auto ix = static_cast<std::int64_t>(cell);
  Face left = face_of(ix), right = face_of(ix + 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double p = first.x + i * step;
    double x = p - cell;
    if (!(x < 1)) {
      const bool next = x < 2;
      cell = std::floor(p);
      ix = static_cast<std::int64_t>(cell);
      left = next ? right : face_of(ix);
      right = face_of(ix + 1);
      x = p - cell;
    }
    sums[i] += scale * noise::mix(left.at + left.slope * x, right.at + right.slope * (x - 1), noise::fade(x));
  }
}

/// No value is greater: each is a mean of products that add two of three distances, and the mean distance
/// along an axis is a half at most.
inline constexpr double kPerlinMost = 1.5;

/// Bounds of the noise in a box, conservative; the tighter the smaller the box.
GVX_HD inline noise::Interval perlin_bounds(const Box3d& box, std::uint32_t seed) {
  constexpr double kMargin = 1e-9;  // of rounding
  constexpr std::int64_t kMostCells = 3;
  std::int64_t first[3], last[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::floor(box.minimum[axis]), high = std::floor(box.maximum[axis]);
    if (!(high - low < kMostCells) || std::fabs(low) > 1e15) return {-kPerlinMost, kPerlinMost};
    first[axis] = static_cast<std::int64_t>(low);
    last[axis] = static_cast<std::int64_t>(high);
  }
  noise::Interval bounds{kPerlinMost, -kPerlinMost};
  const auto part = [&](int axis, std::int64_t cell) {
    const auto origin = static_cast<double>(cell);
    return noise::Interval{std::fmax(box.minimum[axis] - origin, 0.0),
                           std::fmin(box.maximum[axis] - origin, 1.0)};
  };
  for (std::int64_t z = first[2]; z <= last[2]; ++z) {
    for (std::int64_t y = first[1]; y <= last[1]; ++y) {
      for (std::int64_t x = first[0]; x <= last[0]; ++x) {
        const noise::Interval here = noise::in_cell(x, y, z, part(0, x), part(1, y), part(2, z), seed);
        bounds.low = std::fmin(bounds.low, here.low - kMargin);
        bounds.high = std::fmax(bounds.high, here.high + kMargin);
      }
    }
  }
  return {std::fmax(bounds.low, -kPerlinMost), std::fmin(bounds.high, kPerlinMost)};
}

/// Octaves of noise, each `lacunarity` times as fine and `gain` times as strong as the one before.
struct FractalNoise {
  std::uint32_t octaves = 8;
  double wavelength = 0.25;  ///< of the first octave
  double lacunarity = 2;
  double gain = 0.5;
  std::uint32_t seed = 1;

  bool operator==(const FractalNoise&) const = default;

  /// The sum at p of what a voxel of width `footprint` resolves: octaves of four voxels and more, and less
  /// and less of those down to two.
  GVX_HD double operator()(Vec3d p, double footprint) const {
    double sum = 0, amplitude = 1, wave = wavelength;
    for (std::uint32_t i = 0; i < octaves; ++i) {
      const double share = resolved(wave, footprint);
      if (share <= 0) break;
      sum += share * amplitude * perlin(p / wave, seed + i);
      amplitude *= gain;
      wave /= lacunarity;
    }
    return sum;
  }

  /// The sums at first + i * step along x, for `count` places; settled(sums, rest) says that whatever the
  /// rest of the octaves adds, within `rest` of 0, makes no difference any more.
  template <typename Settled>
  void row(Vec3d first, double step, std::uint32_t count, double footprint, double* sums,
           Settled settled) const {
    for (std::uint32_t i = 0; i < count; ++i) sums[i] = 0;
    double amplitude = 1, wave = wavelength, rest = most();
    for (std::uint32_t i = 0; i < octaves; ++i) {
      const double share = resolved(wave, footprint);
      if (share <= 0 || settled(sums, rest)) break;
      add_perlin_row(first / wave, step / wave, count, seed + i, share * amplitude, sums);
      rest -= amplitude * kPerlinMost;
      amplitude *= gain;
      wave /= lacunarity;
    }
  }

  /// No sum is farther from 0.
  GVX_HD double most() const {
    double sum = 0, amplitude = kPerlinMost;
    for (std::uint32_t i = 0; i < octaves; ++i, amplitude *= gain) sum += amplitude;
    return sum;
  }

  /// Bounds of the sum in a box, for every footprint up to this one.
  GVX_HD noise::Interval bounds(const Box3d& box, double coarsest_footprint) const {
    noise::Interval sum;
    double amplitude = 1, wave = wavelength;
    for (std::uint32_t i = 0; i < octaves; ++i) {
      const Box3d scaled{box.minimum / wave, box.maximum / wave};
      noise::Interval octave = perlin_bounds(scaled, seed + i);
      const double least = resolved(wave, coarsest_footprint);  // the share goes from this to 1
      octave = {amplitude * octave.low, amplitude * octave.high};
      sum.low += octave.low < 0 ? octave.low : least * octave.low;
      sum.high += octave.high > 0 ? octave.high : least * octave.high;
      amplitude *= gain;
      wave /= lacunarity;
    }
    return sum;
  }

  /// How much of a wave a voxel of that width shows.
  GVX_HD static double resolved(double wave, double footprint) {
    const double octaves_above = std::log2(wave / footprint) - 1;
    return octaves_above > 1 ? 1 : octaves_above > 0 ? octaves_above : 0;
  }
};

}  // namespace gvx
