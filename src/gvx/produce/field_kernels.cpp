#include "gvx/produce/field_kernels.h"

#include <algorithm>

#include "gvx/produce/kernel_producer.h"

namespace gvx::produce {
namespace {

struct BallsKernel {
  exec::BufferView<const BallsField::Ball> balls;
  HypertextureOptions options;

  GVX_HD double distance(Vec3d p) const {
    double least = 1e300;
    for (std::size_t i = 0; i < balls.size; ++i) {
      least = std::fmin(least, length(p - balls[i].centre) - balls[i].radius);
    }
    return least;
  }
  GVX_HD float value(Vec3d p, double spacing) const {
    const double d = distance(p), shift = options.shift();
    const bool solid = options.kind == HypertextureKind::solid_noise;
    // Noise only where it makes a difference.
    const double reach = shift * options.noise.most() + 0.5 * coverage_width(options.shell(), spacing);
    const bool noisy = solid ? d < reach : shift > 0 && std::fabs(d) < reach;
    return static_cast<float>(density_at(options, d, noisy ? options.noise(p, spacing) : 0, spacing));
  }
  GVX_HD ValueRange bounds(const Box3d& box, double coarsest_spacing) const {
    const double at = distance(0.5 * (box.minimum + box.maximum));
    const double radius = 0.5 * length(box.maximum - box.minimum) + 1e-6;
    return density_bounds(options, {static_cast<float>(at - radius), static_cast<float>(at + radius)}, box,
                          coarsest_spacing);
  }
};

struct TerrainKernel {
  TerrainOptions options;

  GVX_HD float value(Vec3d p, double spacing) const {
    return static_cast<float>(options.ground(p, options.noise(options.in_noise(p), spacing), spacing));
  }
  GVX_HD ValueRange bounds(const Box3d& box, double coarsest_spacing) const {
    return options.bounds(box, coarsest_spacing);
  }
};

}  // namespace

std::shared_ptr<const Producer> make_balls_producer(const exec::Device& device, const TreeDescription& tree,
                                                    const std::vector<BallsField::Ball>& balls,
                                                    const HypertextureOptions& options) {
  auto there = std::make_shared<exec::Buffer<BallsField::Ball>>(device, balls.size());
  std::copy(balls.begin(), balls.end(), there->view().begin());
  const BallsKernel kernel{{there->view().data, balls.size()}, options};
  return std::make_shared<KernelProducer<BallsKernel>>(device, tree, kernel, there);
}

std::shared_ptr<const Producer> make_terrain_producer(const exec::Device& device, const TreeDescription& tree,
                                                      const TerrainOptions& options) {
  return std::make_shared<KernelProducer<TerrainKernel>>(device, tree, TerrainKernel{options}, nullptr);
}

}  // namespace gvx::produce
