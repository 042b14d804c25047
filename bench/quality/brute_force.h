/// \file
/// BruteForce: what the right picture is. Many rays a pixel through the finest level of all of the volume, in
/// steps of an eighth of a voxel, until 1/5000 is left to see. It shares camera, transfer function and
/// lighting formula with the engine, and nothing of its traversal, sampling, levels or tables.
///
/// A step of length d at value v has opacity 1 - exp(-extinction(v) * d / unit) and the function's colour at
/// v; function values come from a table of 65536 entries between the function's outermost points.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dense_volume.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/frame/view.h"

namespace gvx::bench {

struct Reference {
  render::Picture picture;
  /// Of the half of the rays on the black fields of a chess board, and of the other half.
  render::Picture half[2];
};

class BruteForce {
 public:
  static constexpr double kStepsPerVoxel = 8;

  /// `volume` must outlive it.
  BruteForce(const DenseVolume& volume, const scene::TransferFunction& function);

  /// `rays_per_axis`^2 rays a pixel, whatever view.antialias says.
  Reference render(const render::View& view, std::uint32_t rays_per_axis) const;

  /// The distance along a ray of the world at which it has gathered this opacity.
  std::optional<double> depth(const Ray& world, double opacity) const;

 private:
  struct Entry {
    Vec3f color;
    float opacity = 0;  ///< of a step
  };
  const Entry& entry(float value) const;
  /// Calls visit(t, place, entry) for each sample that can be seen, front to back, until it returns false.
  template <typename Visit>
  void walk(const Ray& world, const Visit& visit) const;
  Vec3f ray_color(const Ray& world, const scene::LightingView& lighting, Vec3f background) const;

  const DenseVolume& volume_;
  Affine3 world_to_voxel_;
  double step_;
  float soft_gradient_;
  float first_, to_entry_;
  std::vector<Entry> table_;
  std::vector<char> visible_;  // by block
};

}  // namespace gvx::bench
