// Vectors of rays show what one ray at a time shows, whatever the instruction set.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "gvx/render/stretch_batch.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

/// The instruction sets of this machine that there are vectors for.
std::vector<std::int64_t> instruction_sets() {
  std::vector<std::int64_t> sets;
  hwy::SetSupportedTargetsForTest(0);
  const std::int64_t supported = hwy::SupportedTargets();
  for (const std::int64_t set : {HWY_SCALAR, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_NEON}) {
    if ((supported & set) != 0 || set == HWY_SCALAR) sets.push_back(set);
  }
  return sets;
}

void use(std::int64_t instruction_set) {
  hwy::SetSupportedTargetsForTest(instruction_set);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

float greatest_difference(const render::Picture& a, const render::Picture& b) {
  float greatest = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    const float difference = std::abs(a.rgba[i] - b.rgba[i]);
    if (std::isnan(difference)) return difference;
    greatest = std::max(greatest, difference);
  }
  return greatest;
}

void expect_alike(const TestScene& scene, const char* what) {
  constexpr float kStepOf8Bits = 1.0f / 255;
  engine::EngineOptions plain;
  plain.one_ray_at_a_time = true;
  engine::Statistics counted;
  const render::Picture expected = render_exact(scene, exec::Device::cpu(), plain, &counted);
  int tested = 0;
  for (const std::int64_t set : instruction_sets()) {
    use(set);
    // Builds with sanitizers have fewer sets.
    if (set != HWY_SCALAR && std::string(render::instruction_set()) != hwy::TargetName(set)) continue;
    ++tested;
    engine::Statistics statistics;
    const render::Picture picture = render_exact(scene, exec::Device::cpu(), {}, &statistics);
    const float difference = greatest_difference(picture, expected);
    const double decibels = psnr(picture, expected);
    EXPECT_LE(difference, kStepOf8Bits) << what << " with " << hwy::TargetName(set);
    EXPECT_GE(decibels, 80) << what << " with " << hwy::TargetName(set);
    EXPECT_NEAR(double(statistics.samples), double(counted.samples), 1e-3 * double(counted.samples));
    std::printf("%-36s %-8s %6.1f dB, at most %.6f\n", what, hwy::TargetName(set), decibels,
                double(difference));
    EXPECT_EQ(render_exact(scene, exec::Device::cpu(3), {0, engine::PoolSizes{150, 12}}).rgba, picture.rgba)
        << what << " with " << hwy::TargetName(set);
  }
  EXPECT_GE(tested, 2) << "with nothing but " << render::instruction_set();
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(Vectors, show_what_one_ray_at_a_time_shows) {
  const TestScene waved = analytic_scene("vectors", waves, {70, 62, 55}, {1, 1, 1.2}, 2, 8);
  const auto variant = [&](const char* what, auto change) {
    TestScene changed = waved;
    change(changed.view);
    expect_alike(changed, what);
  };
  variant("finest", [](auto& v) { v.level_of_detail = false; });
  variant("levels blended", [](auto&) {});
  variant("far", [](auto& v) { v.camera.eye = v.camera.target + 3.7 * (v.camera.eye - v.camera.target); });
  variant("orthographic", [](auto& v) { v.camera.height_world = 120; });
  variant("unlit", [](auto& v) { v.lighting.enabled = false; });
  variant("steep", [](auto& v) { v.functions[0].opacities = {{0.5, 0}, {0.53, 0.9}}; });
  variant("thin layer", [](auto& v) { v.functions[0].opacities = {{0.5, 0}, {0.52, 0.8}, {0.54, 0}}; });
  variant("visible at the ends", [](auto& v) {
    v.functions[0].opacities = {{0.3, 0.5}, {0.5, 0}, {0.7, 0.6}};
  });
  variant("lights", [](auto& v) {
    v.lighting.lights = 2;
    v.lighting.light[0] = {scene::LightKind::point, {20, 5, 90}, {1, 0.5f, 0.2f}};
    v.lighting.light[1] = {scene::LightKind::directional, {0, 1, 1}, {0.2f, 0.5f, 1}};
  });
  variant("flat highlights", [](auto& v) { v.lighting.shininess = 0; });
}

TEST(Vectors, of_every_voxel_type_and_arity) {
  const auto scaled = [](double most) { return [most](Vec3d p) { return std::round(most * waves(p)); }; };
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::f32}) {
    const double most = type == VoxelType::u8 ? 255 : type == VoxelType::u16 ? 65535 : 3e-4;
    const Field field =
        type == VoxelType::f32 ? Field([](Vec3d p) { return 3e-4 * waves(p); }) : scaled(most);
    for (const auto& [n, m] : {std::pair(2u, 8u), {2u, 16u}, {2u, 32u}, {3u, 8u}}) {
      TestScene scene =
          planar_scene("vector_types", {type, VoxelContent::scalar, 1}, {field}, {50, 44, 47}, n, m);
      for (auto& point : scene.view.functions[0].opacities) point.value *= most;
      for (auto& point : scene.view.functions[0].colors) point.value *= most;
      // So far away that levels are blended in all of it.
      scene.view.camera.eye =
          scene.view.camera.target + 4.0 * (scene.view.camera.eye - scene.view.camera.target);
      const std::string what =
          std::string(voxel_name(type)) + " N" + std::to_string(n) + " M" + std::to_string(m);
      expect_alike(scene, what.c_str());
    }
  }
}

TEST(Vectors, on_a_real_volume) {
  if (test_data("volumes/nifti/osv_engine.nii.gz").empty()) GTEST_SKIP() << "GVX_TEST_DATA is not set";
  expect_alike(file_scene("volumes/nifti/osv_engine.nii.gz", 16).value(), "engine");
}

}  // namespace
}  // namespace gvx::tests
