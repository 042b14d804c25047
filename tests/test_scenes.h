/// \file
/// Scenes for the tests of whole images: volumes in memory, their stores, and views of them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gvx/engine/engine.h"
#include "gvx/produce/producer.h"
#include "gvx/render/frame/frame.h"
#include "reference.h"

namespace gvx::tests {

/// A volume, known voxel by voxel and as a store.
struct TestScene {
  ReferenceVolume volume;
  std::string store_path;
  render::View view;

  std::shared_ptr<const produce::Producer> open() const;
};

/// A function on [0, 1]^3 sampled at the centres of dimensions.x * y * z voxels of this spacing, as f32.
TestScene analytic_scene(const std::string& name, const std::function<double(Vec3d)>& field, Vec3i dimensions,
                         Vec3d spacing, std::uint32_t n, std::uint32_t m);

/// A number for each place in [0, 1]^3.
using Field = std::function<double(Vec3d)>;

/// A volume of any format, one field a plane, at the centres of its voxels, which are of unit size. Fields
/// are of stored numbers; values are these times `scale`, plus `offset`.
TestScene planar_scene(const std::string& name, VoxelFormat format, const std::vector<Field>& planes,
                       Vec3i dimensions, std::uint32_t n, std::uint32_t m, double scale = 1,
                       double offset = 0);

/// A soft ball with a dent: smooth everywhere, values 0 to 1.
double ball(Vec3d p);
/// Waves of eight voxels' length and more in every direction, values 0 to 1.
double waves(Vec3d p);

/// A volume file of the test data, where GVX_TEST_DATA has it; its store is of bricks of m.
Result<TestScene> file_scene(const std::string& file, std::uint32_t m);

/// Renders the scene's view exactly; checks for success.
render::Picture render_exact(const TestScene& scene, const exec::Device& device = exec::Device::cpu(),
                             const engine::EngineOptions& options = {},
                             engine::Statistics* statistics = nullptr);

/// The path of a file of the test data, or empty where there is none.
std::string test_data(const std::string& file);

}  // namespace gvx::tests
