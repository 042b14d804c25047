// Vectors of rays show what one ray at a time shows, whatever the instruction set.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "gvx/engine/residency.h"
#include "gvx/produce/examine_element.h"
#include "gvx/render/vectors/instruction_set.h"
#include "gvx/scene/label_table.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

/// The instruction sets of this machine that there are vectors for.
std::vector<std::int64_t> instruction_sets() {
  std::vector<std::int64_t> sets;
  hwy::SetSupportedTargetsForTest(0);
  const std::int64_t supported = hwy::SupportedTargets() & render::kInstructionSets;
  for (const std::int64_t set : {HWY_SCALAR, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_NEON}) {
    if ((supported & set) != 0) sets.push_back(set);
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

void expect_alike_as_classified(TestScene scene, const std::string& what) {
  constexpr float kStepOf8Bits = 1.0f / 255;
#if defined(__SANITIZE_ADDRESS__)
  // Takes ten times as long: a quarter of the pixels goes the same ways.
  scene.view.width /= 2, scene.view.height /= 2;
#endif
  engine::EngineOptions plain;
  plain.one_ray_at_a_time = true;
  engine::Statistics counted;
  const render::Picture expected = render_exact(scene, exec::Device::cpu(), plain, &counted);
  std::set<std::string> tested;
  for (const std::int64_t set : instruction_sets()) {
    use(set);
    const std::string running = render::instruction_set();
    ASSERT_TRUE(tested.insert(running).second) << running << " runs for two sets";
    engine::Statistics statistics;
    const render::Picture picture = render_exact(scene, exec::Device::cpu(), {}, &statistics);
    const float difference = greatest_difference(picture, expected);
    const double decibels = psnr(picture, expected);
    EXPECT_LE(difference, kStepOf8Bits) << what << " with " << running;
    EXPECT_GE(decibels, 80) << what << " with " << running;
    // Cells that cannot be seen are not sampled.
    EXPECT_LE(double(statistics.samples), 1.001 * double(counted.samples)) << what;
    EXPECT_GT(statistics.samples, 0u) << what;
    std::printf("%-36s %-8s %6.1f dB, at most %.6f\n", what.c_str(), running.c_str(), decibels,
                double(difference));
    EXPECT_EQ(render_exact(scene, exec::Device::cpu(3), {0, engine::PoolSizes{150, 12}}).rgba, picture.rgba)
        << what << " with " << running;
  }
  EXPECT_FALSE(tested.empty());
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

void expect_alike(TestScene scene, const std::string& what) {
  expect_alike_as_classified(scene, what);
  scene.view.classification = scene::Classification::post;
  expect_alike_as_classified(scene, what + ", post");
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
  // Steps whose ends may be far outside of a brick, and so many that they are looked for in several goes.
  for (const double samples : {1.0, 6.0}) {
    variant(samples < 2 ? "long steps" : "short steps", [&](auto& v) {
      v.samples_per_voxel = samples;
      v.functions[0].opacities = {{0.5, 0}, {0.52, 0.4}, {0.54, 0}};
      if (samples < 2) v.camera.eye = v.camera.target + Vec3d(0, -length(v.camera.eye - v.camera.target), 0);
    });
  }
  variant("visible at the ends", [](auto& v) {
    v.functions[0].opacities = {{0.3, 0.5}, {0.5, 0}, {0.7, 0.6}};
  });
  variant("lights", [](auto& v) {
    v.lighting.lights = 2;
    v.lighting.light[0] = {scene::LightKind::point, {20, 5, 90}, {1, 0.5f, 0.2f}};
    v.lighting.light[1] = {scene::LightKind::directional, {0, 1, 1}, {0.2f, 0.5f, 1}};
  });
  variant("by gradient", [](auto& v) { v.functions[0].gradients = {{0, 0}, {0.02, 0.2}, {0.1, 1}}; });
  variant("flat highlights", [](auto& v) { v.lighting.shininess = 0; });
}

TEST(Vectors, beside_an_object_leave_tiles_blank) {
  TestScene scene = analytic_scene("vectors_blank", ball, {40, 40, 40}, {1, 1, 1}, 2, 8);
  scene.view.width = 330;
  scene.view.height = 200;
  scene.view.opaque_background = false;
  const scene::Camera near = scene.view.camera;
  scene::Camera far = near;
  far.eye = near.target + 6.0 * (near.eye - near.target);
  scene.view.camera = far;
  expect_alike(scene, "a small ball");
  // Of one engine whose picture before was all ball.
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  for (const scene::Camera& camera : {near, far}) {
    scene.view.camera = camera;
    ASSERT_TRUE(engine->look(scene.view).ok());
    while (!engine->converged()) ASSERT_TRUE(engine->render_for(std::chrono::milliseconds(3)).ok());
    const render::Picture picture = engine->picture();
    EXPECT_EQ(picture.rgba, render_exact(scene).rgba);
    const auto seen = static_cast<double>(
        std::count_if(picture.rgba.begin(), picture.rgba.end(), [](float v) { return v > 0; }));
    EXPECT_GT(seen, 0);
    if (camera == far) {
      EXPECT_LT(seen, 0.1 * static_cast<double>(picture.rgba.size()));
    }
  }
}

TEST(Vectors, through_nodes_of_one_value_where_levels_change) {
  // Haze, and layers of waves whose faces are within nodes: of these some children are of one value.
  const auto blocks = [](Vec3d p) {
    const bool waved = int(192 * p.z / 20) % 2 == 0;
    return waved ? waves(p * Vec3d(1, 1, 4)) : 0.45;
  };
  TestScene scene = analytic_scene("vectors_blocks", blocks, {48, 48, 192}, {1, 1, 1}, 2, 8);
  scene.view.camera.eye = {60, 70, -90};
  scene.view.camera.target = {24, 24, 96};
  scene.view.detail = 0.25;
  expect_alike_as_classified(scene, "one value beside");
  scene.view.detail = 0.43;
  scene.view.classification = scene::Classification::post;
  expect_alike_as_classified(scene, "one value beside, post");
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
      expect_alike(scene, what);
      // Cells of either level are hidden.
      scene.view.functions[0].opacities = {{0.6 * most, 0}, {0.7 * most, 0.8}};
      expect_alike(scene, what + ", surfaces");
    }
  }
}

/// Previews of all stages, as data comes: those of vectors and those of the plain march from the same memory.
void expect_previews_alike(const TestScene& scene, const std::string& what) {
  constexpr double kLeast = 80;
  const exec::Device cpu = exec::Device::cpu();
  const auto producer = scene.open();
  const produce::TreeDescription& tree = producer->description();
  engine::Residency residency(cpu, *producer, produce::TreeId(1), {200, 60});
  ASSERT_TRUE(residency.plant_root().ok());
  const auto make = [&](const produce::ElementKey& key) {
    return produce::FinishedElement{key, produce::make_element(*producer, key.node, key.kind)};
  };
  residency.commit({make(residency.ask_for_root().value())}, engine::Eviction::any);
  const render::Frame frame = render::Frame::make(cpu, scene.view, tree).value();
  engine::Look look(cpu, 200, 60);
  residency.attach(look);
  residency.set_visibility(look, frame.view().visibility);
  const std::uint32_t width = scene.view.width, height = scene.view.height;
  exec::Buffer<render::RayState> rays(cpu, width * height);
  exec::Buffer<render::PreviewPixel> plain(cpu, width * height), vectors(cpu, width * height);
  std::uint64_t lacking = 0, drawn = 0;
  double squares = 0;
  for (std::uint32_t number = 1; number <= 8; ++number) {
    const std::uint32_t block = number % 2 == 0 ? 4 : 1;
    const exec::TileGrid grid{(width + block - 1) / block, (height + block - 1) / block, 8};
    exec::Buffer<std::uint32_t> tiles(cpu, grid.tiles());
    for (std::uint32_t t = 0; t < grid.tiles(); ++t) tiles.view()[t] = t;
    render::ObjectView object;
    object.n = tree.n;
    object.m = tree.m;
    object.frame = frame.view();
    object.nodes = residency.nodes().view();
    object.bricks = residency.bricks().bytes();
    object.tile_usage = residency.tile_usage();
    object.brick_usage = residency.brick_usage();
    object.requests = residency.requests();
    object.hidden = look.hidden();
    object.cells = look.cells();
    render::Pass pass;
    pass.film = render::film_of(scene.view).value();
    pass.objects = {&object, 1};
    pass.number = number;
    pass.epoch = 1;
    std::vector<produce::ElementKey> elements[2];
    for (const bool one_ray : {true, false}) {
      pass.one_ray_at_a_time = one_ray;
      const render::TilesMarch march{pass, grid, tiles.view(), exec::no_deadline()};
      exec::Buffer<render::PreviewPixel>& pixels = one_ray ? plain : vectors;
      EXPECT_TRUE(render::march_preview(cpu, {march, block, number, rays.view(), pixels.view()}));
      for (const engine::Lacking& l : residency.collect(number, number))
        elements[one_ray ? 0 : 1].push_back(l.element);
    }
    for (std::uint32_t y = 0; y < height; y += block) {
      for (std::uint32_t x = 0; x < width; x += block) {
        const render::PreviewPixel a = plain.view()[y * width + x], b = vectors.view()[y * width + x];
        ASSERT_EQ(a.wanted, b.wanted) << what << " pass " << number << " at " << x << " " << y;
        ASSERT_EQ(a.resident, b.resident) << what << " pass " << number << " at " << x << " " << y;
        ASSERT_EQ(a.worst_lack, b.worst_lack) << what << " pass " << number << " at " << x << " " << y;
        ASSERT_EQ(a.generation, b.generation);
        lacking += a.wanted - a.resident;
        ++drawn;
        for (int c = 0; c < 3; ++c)
          squares += double(a.color[c] - b.color[c]) * double(a.color[c] - b.color[c]);
        ASSERT_NEAR(a.opacity, b.opacity, 1.0f / 255) << what << " at " << x << " " << y;
      }
    }
    const auto key_less = [](const produce::ElementKey& a, const produce::ElementKey& b) {
      return std::tie(a.kind, a.node.level, a.node.x, a.node.y, a.node.z) <
             std::tie(b.kind, b.node.level, b.node.x, b.node.y, b.node.z);
    };
    for (auto& list : elements) std::sort(list.begin(), list.end(), key_less);
    EXPECT_EQ(elements[0], elements[1]) << what << " pass " << number;
    engine::Room room = residency.room(engine::Eviction::unused);
    std::vector<produce::FinishedElement> made;
    for (const produce::ElementKey& key : elements[1]) {
      if (room.take(key.kind)) made.push_back(make(key));
    }
    residency.commit(std::move(made), engine::Eviction::unused);
  }
  EXPECT_GT(lacking, 100u) << what;
  EXPECT_GE(10 * std::log10(3 * double(drawn) / squares), kLeast) << what;
}

TEST(Vectors, in_every_mode) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::f32}) {
    const double most = type == VoxelType::u8 ? 255 : type == VoxelType::u16 ? 65535 : 1;
    const Field field = [=](Vec3d p) {
      return type == VoxelType::f32 ? waves(p) : std::round(most * waves(p));
    };
    TestScene scene =
        planar_scene("vector_modes", {type, VoxelContent::scalar, 1}, {field}, {58, 50, 44}, 2, 8);
    scene.view.isovalue = 0.62 * most;
    scene.view.functions[0].opacities = {{0, 0.1}, {most, 0.9}};
    scene.view.lighting.lights = 1;
    scene.view.lighting.light[0] = {scene::LightKind::point, {20, 5, 90}, {1, 0.9f, 0.8f}};
    for (const auto& [mode, name] : {std::pair(scene::Mode::maximum, "maximum"),
                                     {scene::Mode::minimum, "minimum"},
                                     {scene::Mode::mean, "mean"},
                                     {scene::Mode::isosurface, "isosurface"}}) {
      const std::string what = std::string(voxel_name(type)) + " " + name;
      TestScene seen = scene;
      seen.view.mode = mode;
      expect_alike_as_classified(seen, what);
      seen.view.camera.eye = seen.view.camera.target + 3.0 * (seen.view.camera.eye - seen.view.camera.target);
      expect_alike_as_classified(seen, what + ", far");
      if (type == VoxelType::u8) expect_previews_alike(seen, what);
    }
  }
}

TEST(Vectors, of_every_content) {
  const auto scaled = [](auto field) { return [field](Vec3d p) { return std::round(255 * field(p)); }; };
  TestScene scene = planar_scene("vector_channels", {VoxelType::u8, VoxelContent::scalar, 2},
                                 {scaled(ball), scaled(waves)}, {50, 44, 40}, 2, 8);
  scene.view.functions = {{{{0, {1, 0.4, 0.2}}}, {{90, 0}, {230, 0.3}}, 0},
                          {{{0, {0.2, 0.6, 1}}}, {{90, 0}, {230, 0.3}}, 0}};
  expect_alike(scene, "two channels");
  scene.view.mode = scene::Mode::maximum;
  expect_alike_as_classified(scene, "two channels, maximum");
  scene = planar_scene("vector_many_channels", {VoxelType::u16, VoxelContent::scalar, 4},
                       {scaled(ball), scaled(waves), scaled(waves), scaled(ball)}, {50, 44, 40}, 3, 8);
  scene.view.functions = {{{{0, {1, 0.4, 0.2}}}, {{90, 0}, {230, 0.3}}, 0},
                          {{{0, {0.2, 0.6, 1}}}, {{120, 0}, {128, 0.6}, {136, 0}}, 0},
                          {{{0, {0.2, 1, 0.3}}}, {{190, 0}, {195, 0.9}}, 0},
                          {{{0, {1, 1, 1}}}, {{250, 0}, {251, 0.2}}, 0}};
  const auto variant = [&](const char* what, auto change) {
    TestScene changed = scene;
    change(changed.view);
    expect_alike(changed, std::string("four channels, ") + what);
  };
  variant("steep", [](auto&) {});
  variant("unlit", [](auto& v) { v.lighting.enabled = false; });
  variant("far", [](auto& v) { v.camera.eye = v.camera.target + 4.0 * (v.camera.eye - v.camera.target); });
  variant("by gradient", [](auto& v) { v.functions[1].gradients = {{0, 0}, {10, 0.1}, {60, 1}}; });
  scene = planar_scene("vector_float_channels", {VoxelType::f32, VoxelContent::scalar, 3},
                       {ball, waves, waves}, {50, 44, 40}, 2, 16);
  scene.view.functions = {{{{0, {1, 0.4, 0.2}}}, {{0.3, 0}, {0.9, 0.3}}, 0},
                          {{{0, {0.2, 0.6, 1}}}, {{0.45, 0}, {0.5, 0.6}, {0.55, 0}}, 0},
                          {{{0, {0.2, 1, 0.3}}}, {{0.7, 0}, {0.71, 0.9}}, 0}};
  scene.view.lighting.light[0] = {scene::LightKind::point, {20, 5, 90}, {1, 0.9f, 0.8f}};
  expect_alike(scene, "three channels of floats near a light");
  scene = planar_scene("vector_labels", {VoxelType::u8, VoxelContent::labels, 1},
                       {[](Vec3d p) { return std::floor(4 * waves(p)); }}, {50, 44, 40}, 2, 8);
  scene.view.functions = {scene::label_colors(4)};
  expect_alike_as_classified(scene, "labels");
  expect_previews_alike(scene, "labels");
  scene.view.lighting.enabled = false;
  expect_alike_as_classified(scene, "labels, unlit");
  scene = planar_scene("vector_wide_labels", {VoxelType::u16, VoxelContent::labels, 1},
                       {[](Vec3d p) { return 500 + std::floor(3 * waves(p)); }}, {50, 44, 40}, 2, 16);
  scene.view.functions = {scene::label_colors(503)};
  scene.view.lighting.light[0] = {scene::LightKind::point, {20, 5, 90}, {1, 0.9f, 0.8f}};
  expect_alike_as_classified(scene, "labels of two bytes, near a light");
  scene = planar_scene("vector_colors", {VoxelType::u8, VoxelContent::color, 4},
                       {scaled(waves), scaled(ball), scaled(waves), scaled(waves)}, {50, 44, 40}, 2, 8);
  expect_alike_as_classified(scene, "colours");
  scene.view.camera.eye = scene.view.camera.target + 4.0 * (scene.view.camera.eye - scene.view.camera.target);
  expect_alike_as_classified(scene, "colours, far");
  expect_previews_alike(scene, "colours, far");
  const auto normal = [](int axis) {
    return [axis](Vec3d p) { return 127 + std::round(100 * std::sin(p[axis] / 9 + axis) * waves(p)); };
  };
  scene = planar_scene(
      "vector_normals", {VoxelType::u8, VoxelContent::color_normal, 7},
      {scaled(waves), scaled(ball), scaled(waves), scaled(waves), normal(0), normal(1), normal(2)},
      {50, 44, 40}, 2, 8);
  expect_alike_as_classified(scene, "normals");
  scene.view.camera.eye = scene.view.camera.target + 4.0 * (scene.view.camera.eye - scene.view.camera.target);
  expect_alike_as_classified(scene, "normals, far");
  scene.view.lighting.enabled = false;
  expect_alike_as_classified(scene, "normals, far, unlit");
}

/// A field with no data in a block, in a thin sheet, and in one of so many voxels here and there.
Field with_gaps(const Field& field, Vec3d voxels, std::uint32_t one_of) {
  return [=](Vec3d p) {
    const bool in_block = p.x > 0.3 && p.x < 0.55 && p.y > 0.2 && p.y < 0.6 && p.z < 0.7;
    const bool in_sheet = std::floor(p.z * voxels.z) == std::floor(0.8 * voxels.z) && p.x > 0.5;
    const Vec3d voxel = p * voxels;
    const std::uint32_t mixed = (std::uint32_t(voxel.x) * 73856093u) ^ (std::uint32_t(voxel.y) * 19349663u) ^
                                (std::uint32_t(voxel.z) * 83492791u);
    const bool alone = (mixed * 2654435761u >> 8) % one_of == 0;
    return in_block || in_sheet || alone ? NAN : field(p);
  };
}

TEST(Vectors, see_nothing_in_what_is_no_data) {
  const Vec3d voxels(58, 50, 44);
  for (const std::uint32_t one_of : {12u, 900u}) {
    for (const auto& [n, m] : {std::pair(2u, 8u), {3u, 16u}}) {
      const TestScene scene = planar_scene("vector_gaps", {VoxelType::f32, VoxelContent::scalar, 1},
                                           {with_gaps(waves, voxels, one_of)}, {58, 50, 44}, n, m);
      const std::string name = "a gap of " + std::to_string(one_of) + " N" + std::to_string(n);
      const auto variant = [&](const char* what, auto change) {
        TestScene changed = scene;
        change(changed.view);
        expect_alike(changed, name + ", " + what);
      };
      const auto far = [](auto& v) {
        v.camera.eye = v.camera.target + 3.7 * (v.camera.eye - v.camera.target);
      };
      variant("lit", [](auto&) {});
      variant("finest", [](auto& v) { v.level_of_detail = false; });
      variant("unlit", [](auto& v) { v.lighting.enabled = false; });
      variant("far", far);
      variant("far, unlit", [&](auto& v) { far(v), v.lighting.enabled = false; });
      variant("steep", [](auto& v) { v.functions[0].opacities = {{0.5, 0}, {0.53, 0.9}}; });
      variant("thin layer", [](auto& v) { v.functions[0].opacities = {{0.5, 0}, {0.52, 0.8}, {0.54, 0}}; });
      variant("seen below", [](auto& v) { v.functions[0].opacities = {{0.3, 0.5}, {0.5, 0}, {0.7, 0.6}}; });
      variant("far and steep", [&](auto& v) { far(v), v.functions[0].opacities = {{0.5, 0}, {0.53, 0.9}}; });
      variant("by gradient", [](auto& v) { v.functions[0].gradients = {{0, 0}, {0.02, 0.2}, {0.1, 1}}; });
      variant("far, by gradient", [&](auto& v) {
        far(v), v.functions[0].gradients = {{0, 0}, {0.02, 0.2}, {0.1, 1}};
      });
    }
  }
}

TEST(Vectors, project_and_find_surfaces_beside_what_is_no_data) {
  const Vec3d voxels(58, 50, 44);
  for (const std::uint32_t one_of : {12u, 900u}) {
    TestScene scene = planar_scene("vector_gap_modes", {VoxelType::f32, VoxelContent::scalar, 1},
                                   {with_gaps(waves, voxels, one_of)}, {58, 50, 44}, 2, 8);
    scene.view.isovalue = 0.62;
    scene.view.functions[0].opacities = {{0, 0.1}, {1, 0.9}};
    for (const auto& [mode, name] : {std::pair(scene::Mode::maximum, "maximum"),
                                     {scene::Mode::minimum, "minimum"},
                                     {scene::Mode::mean, "mean"},
                                     {scene::Mode::isosurface, "isosurface"}}) {
      const std::string what = "a gap of " + std::to_string(one_of) + ", " + name;
      TestScene seen = scene;
      seen.view.mode = mode;
      expect_alike_as_classified(seen, what);
      // A surface that ends beside a gap may be found in the node before a face or behind it, by rounding.
      if (mode != scene::Mode::isosurface) expect_previews_alike(seen, what);
      seen.view.camera.eye = seen.view.camera.target + 3.0 * (seen.view.camera.eye - seen.view.camera.target);
      expect_alike_as_classified(seen, what + ", far");
    }
    expect_previews_alike(scene, "a gap of " + std::to_string(one_of));
    scene.view.classification = scene::Classification::post;
    expect_previews_alike(scene, "a gap of " + std::to_string(one_of) + ", post");
  }
}

TEST(Vectors, of_channels_see_those_that_are_data) {
  const Vec3d voxels(50, 44, 40);
  const auto mirrored = [&](Vec3d p) { return with_gaps(waves, voxels, 15)(Vec3d(1) - p); };
  for (const std::uint32_t channels : {2u, 3u}) {
    std::vector<Field> planes = {with_gaps(ball, voxels, 900), mirrored, waves};
    planes.resize(channels);
    TestScene scene = planar_scene("vector_gap_channels", {VoxelType::f32, VoxelContent::scalar, channels},
                                   planes, {50, 44, 40}, 2, 8);
    scene.view.functions = {{{{0, {1, 0.4, 0.2}}}, {{0.3, 0}, {0.9, 0.3}}, 0},
                            {{{0, {0.2, 0.6, 1}}}, {{0.45, 0}, {0.5, 0.6}, {0.55, 0}}, 0},
                            {{{0, {0.2, 1, 0.3}}}, {{0.7, 0}, {0.71, 0.9}}, 0}};
    scene.view.functions.resize(channels);
    const auto variant = [&](const char* what, auto change) {
      TestScene changed = scene;
      change(changed.view);
      expect_alike(changed, std::to_string(channels) + " channels with gaps, " + what);
    };
    variant("lit", [](auto&) {});
    variant("unlit", [](auto& v) { v.lighting.enabled = false; });
    variant("far", [](auto& v) { v.camera.eye = v.camera.target + 4.0 * (v.camera.eye - v.camera.target); });
    variant("by gradient", [](auto& v) { v.functions[1].gradients = {{0, 0}, {0.04, 0.1}, {0.2, 1}}; });
    for (const scene::Mode mode : {scene::Mode::maximum, scene::Mode::minimum, scene::Mode::mean}) {
      scene.view.mode = mode;
      expect_alike_as_classified(
          scene, std::to_string(channels) + " channels with gaps, mode " + std::to_string(int(mode)));
    }
  }
}

TEST(Vectors, on_a_real_volume) {
  if (test_data("volumes/nifti/osv_engine.nii.gz").empty()) GTEST_SKIP() << "GVX_TEST_DATA is not set";
  expect_alike(file_scene("volumes/nifti/osv_engine.nii.gz", 16).value(), "engine");
}

TEST(Vectors, draw_the_previews_that_one_ray_at_a_time_draws) {
  for (const scene::Classification how :
       {scene::Classification::preintegrated, scene::Classification::post}) {
    for (const auto& [n, m] : {std::pair(2u, 8u), {3u, 8u}}) {
      TestScene scene = analytic_scene("previews", waves, {70, 62, 55}, {1, 1, 1.2}, n, m);
      scene.view.classification = how;
      const std::string name = "N" + std::to_string(n) + (how == scene::Classification::post ? " post" : "");
      expect_previews_alike(scene, name + " near");
      scene.view.level_of_detail = false;
      expect_previews_alike(scene, name + " finest");
      scene.view.level_of_detail = true;
      scene.view.camera.eye =
          scene.view.camera.target + 3.0 * (scene.view.camera.eye - scene.view.camera.target);
      expect_previews_alike(scene, name + " far");
    }
  }
}

}  // namespace
}  // namespace gvx::tests
