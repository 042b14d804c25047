/// \file
/// What hand-written ray casters over other libraries have in common: the volume's file, the function in a
/// table, gvx's light, and tiles of pixels by oneTBB. Steps are of one voxel, sampled at their centres, from
/// where a ray enters the box of the voxels' centres; a ray ends as gvx's do.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <tbb/blocked_range2d.h>
#include <tbb/task_arena.h>

#include "frames.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::bench {

/// The voxels as they are in the file.
struct Voxels {
  int size = 0;
  std::vector<std::uint8_t> value;

  std::uint8_t at(int x, int y, int z) const {
    return value[(static_cast<std::size_t>(z) * size + y) * size + x];
  }
};

class RayCaster : public PeerSystem {
 public:
  RayCaster(int size, int threads) : size_(size), arena_(threads) {}

  Status look(const PeerView& view) override;
  Result<double> frame(const scene::Camera& camera) override;
  std::vector<std::uint8_t> rgb() const override;

 protected:
  static constexpr float kOpaque = 1 - 1.0f / 1024;  // gvx's

  using Tile = tbb::blocked_range2d<int>;

  /// The function at one value: opacity of a step and colour.
  struct Matter {
    Vec3f color;
    float opacity = 0;
  };
  struct Pixel {
    Vec3f color;
    float opacity = 0;
  };
  /// A ray's way through the volume, in voxels.
  struct Way {
    Vec3f from, along;
    float length = 0;  ///< 0 for one that misses it
  };

  /// Once for a view.
  virtual void prepare() = 0;
  virtual void draw(const scene::CameraView& rays, const Tile& tile) = 0;

  const PeerView& view() const { return view_; }
  Pixel& pixel(int x, int y) {
    return pixels_[static_cast<std::size_t>(y) * view_.width + static_cast<std::size_t>(x)];
  }
  Way way(const scene::CameraView& rays, int x, int y) const;
  /// A coordinate in the box of the voxels' centres, where rounding may have put it outside.
  float held(float coordinate) const { return std::clamp(coordinate, 0.0f, static_cast<float>(size_ - 1)); }

  const Matter& matter_of(float value) const {
    return table_[static_cast<std::size_t>(value * (kEntries / 255.0f) + 0.5f)];
  }
  /// As scene::LightingView::shade does.
  Vec3f lit(const Vec3f& color, const Vec3f& gradient, const Vec3f& ahead, const Vec3f& to_light) const {
    const float square = dot(gradient, gradient);
    float facing = 1, glint = 0;
    if (square > 0) {
      const float certainty = square / (square + soft_ * soft_);
      const Vec3f normal = (1 / std::sqrt(square)) * gradient;
      Vec3f half = to_light - ahead;
      half = (1 / std::sqrt(dot(half, half))) * half;
      const float mirrored = std::min(std::fabs(dot(normal, half)), 1.0f);
      facing = 1 + certainty * (std::fabs(dot(normal, to_light)) - 1);
      glint = certainty * glint_[static_cast<std::size_t>(mirrored * kEntries + 0.5f)];
    }
    const scene::Lighting& light = view_.lighting;
    return (light.ambient + light.diffuse * facing) * color + Vec3f(glint);
  }
  /// Puts matter behind what was gathered.
  static void add(const Vec3f& color, float opacity, Pixel& pixel) {
    const float weight = (1 - pixel.opacity) * opacity;
    pixel.color = pixel.color + weight * color;
    pixel.opacity += weight;
  }

 private:
  static constexpr int kEntries = 4096;  // of the tables

  int size_;
  tbb::task_arena arena_;
  PeerView view_;
  std::vector<Matter> table_;
  std::vector<float> glint_;  // by the cosine between normal and half vector
  float soft_ = 0;            // gradient of matter that is half a surface, as gvx takes it
  std::vector<Pixel> pixels_;
};

/// SIZE^3 bytes.
Result<Voxels> read_voxels(const std::string& path, int size);

/// Serves frames of `Caster(voxels, threads)`; the program's exit status. Its arguments: FILE.raw SIZE
/// THREADS, of SIZE^3 u8 voxels.
template <typename Caster>
int serve_caster(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s FILE.raw SIZE THREADS\n", argv[0]);
    return 2;
  }
  const auto voxels = read_voxels(argv[1], std::atoi(argv[2]));
  if (!voxels.ok()) {
    std::fprintf(stderr, "%s\n", voxels.error().message.c_str());
    return 1;
  }
  Caster caster(voxels.value(), std::atoi(argv[3]));
  return serve(caster);
}

}  // namespace gvx::bench
