// Every way to look: modes, channels, labels, colours, lights and gradients, compared with the brute-force
// reference; and each bit for bit the same whatever the cache.

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "gvx/scene/label_table.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

constexpr double kReferenceSamples = 16;

void expect_right(TestScene scene, const char* what, double needed_decibels) {
  scene.view.level_of_detail = false;
  const ReferencePicture reference = render_reference(scene.volume, scene.view, kReferenceSamples);
  for (const exec::Device& device : exec::Device::all()) {
    const double decibels = psnr(render_exact(scene, device), reference.picture);
    EXPECT_GE(decibels, needed_decibels) << what << " on " << device.name();
    std::printf("%-56s %5.1f dB on %s\n", what, decibels, device.name().c_str());
  }
  for (const bool level_of_detail : {false, true}) {
    scene.view.level_of_detail = level_of_detail;
    const render::Picture roomy = render_exact(scene);
    EXPECT_EQ(roomy.rgba, render_exact(scene, exec::Device::cpu(1), {0, engine::PoolSizes{150, 12}}).rgba)
        << what;
  }
}

TEST(Modes, projections_and_isosurfaces_equal_the_reference) {
  const TestScene scene = analytic_scene("modes", waves, {60, 52, 44}, {1, 1, 1.3}, 2, 8);
  const auto variant = [&](const char* what, scene::Mode mode, double decibels) {
    TestScene changed = scene;
    changed.view.mode = mode;
    changed.view.isovalue = 0.62;
    changed.view.functions[0].opacities = {{0, 0.1}, {1, 0.9}};
    expect_right(changed, what, decibels);
  };
  variant("maximum", scene::Mode::maximum, 45);
  variant("minimum", scene::Mode::minimum, 45);
  variant("mean", scene::Mode::mean, 48);
  variant("isosurface", scene::Mode::isosurface, 35);  // a ray that just misses is all or nothing
}

TEST(Modes, post_classification_comes_to_the_same_in_short_steps) {
  TestScene scene = analytic_scene("post", ball, {60, 50, 40}, {1, 1.2, 1}, 2, 16);
  scene.view.classification = scene::Classification::post;
  scene.view.samples_per_voxel = 8;
  scene.view.lighting.enabled = false;
  expect_right(scene, "post-classified, eight samples a voxel", 70);
  // Gradients of cells are not those of the reference.
  scene.view.lighting.enabled = true;
  expect_right(scene, "the same, lit", 45);
  const auto scaled = [](auto field) { return [field](Vec3d p) { return std::round(255 * field(p)); }; };
  scene = planar_scene("post_two", {VoxelType::u8, VoxelContent::scalar, 2}, {scaled(ball), scaled(waves)},
                       {50, 44, 40}, 2, 8);
  scene.view.functions = {{{{0, {1, 0.4, 0.2}}}, {{90, 0}, {230, 0.3}}, 0},
                          {{{0, {0.2, 0.6, 1}}}, {{90, 0}, {230, 0.3}}, 0}};
  scene.view.classification = scene::Classification::post;
  scene.view.samples_per_voxel = 8;
  scene.view.lighting.enabled = false;
  expect_right(scene, "two channels, post-classified", 45);
}

TEST(Modes, what_a_function_hid_is_seen_under_the_next) {
  TestScene scene = analytic_scene("hidden_cells", waves, {50, 50, 50}, {1, 1, 1}, 2, 16);
  scene.view.classification = scene::Classification::post;
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  for (const double least : {0.7, 0.3, 0.55, 0.1}) {
    scene.view.functions[0].opacities = {{least, 0}, {least + 0.05, 0.6}};
    ASSERT_TRUE(engine->look(scene.view).ok());
    ASSERT_TRUE(engine->render_exact().ok());
    EXPECT_EQ(engine->picture().rgba, render_exact(scene).rgba) << least;
  }
}

TEST(Modes, matter_begins_behind_the_onset) {
  // Air of exactly the value where a function begins is nothing, in bricks that hold more than air too.
  TestScene scene = analytic_scene(
      "onset", [](Vec3d p) { return p.x < 0.5 || p.y < 0.5 ? 0.0 : 1.0; }, {40, 40, 40}, {1, 1, 1}, 2, 32);
  scene.view.functions[0].opacities = {{0, 0}, {1, 0.5}};
  scene.view.opaque_background = false;
  scene.view.camera = {{10, 10, -100}, {10, 10, 0}, {0, 1, 0}, 30, 8};  // through air alone
  for (const scene::Classification how :
       {scene::Classification::preintegrated, scene::Classification::post}) {
    for (const bool one_ray : {false, true}) {
      scene.view.classification = how;
      const render::Picture picture = render_exact(scene, exec::Device::cpu(), {512u << 20, {}, one_ray});
      for (std::size_t i = 3; i < picture.rgba.size(); i += 4) ASSERT_EQ(picture.rgba[i], 0) << i;
    }
  }
}

TEST(Modes, an_isosurface_is_where_the_value_is) {
  // Of a distance the isosurface is a ball: what it covers is known.
  TestScene scene = analytic_scene(
      "distance", [](Vec3d p) { return length(p - Vec3d(0.5)); }, {64, 64, 64}, {1, 1, 1}, 2, 16);
  scene.view.mode = scene::Mode::isosurface;
  scene.view.isovalue = 0.3;
  scene.view.lighting.enabled = false;
  scene.view.background = {};
  scene.view.functions[0].colors = {{0, {1, 1, 1}}};
  scene.view.camera = {{32, 32, -200}, {32, 32, 32}, {0, 1, 0}, 30, 48};
  const render::Picture picture = render_exact(scene);
  double covered = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) covered += double(picture.rgba[i]);
  const double pixel = 48.0 / scene.view.height, radius = 0.3 * 64;
  EXPECT_NEAR(covered * pixel * pixel, M_PI * radius * radius, 0.005 * M_PI * radius * radius);
}

TEST(Modes, a_negative_slope_is_the_same_picture) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::f32}) {
    const double most = type == VoxelType::u8 ? 200 : 40000;
    const Field up = [=](Vec3d p) { return std::round(most * waves(p)); };
    const Field down = [=](Vec3d p) { return most - up(p); };
    const VoxelFormat format{type, VoxelContent::scalar, 1};
    TestScene rising = planar_scene("rising", format, {up}, {44, 40, 36}, 2, 8);
    TestScene falling = planar_scene("falling", format, {down}, {44, 40, 36}, 2, 8, -1, most);
    for (const scene::Mode mode : {scene::Mode::composite, scene::Mode::maximum, scene::Mode::minimum,
                                   scene::Mode::mean, scene::Mode::isosurface}) {
      for (const double away : {1.0, 6.0}) {
        render::View view = rising.view;
        view.mode = mode;
        view.isovalue = 0.62 * most;
        view.functions = {
            {{{0, {0, 0.2, 0.8}}, {most, {1, 0.7, 0.1}}}, {{0, 0.1}, {0.4 * most, 0.1}, {most, 0.9}}, 0}};
        view.camera.eye = view.camera.target + away * (view.camera.eye - view.camera.target);
        TestScene seen[2] = {rising, falling};
        for (TestScene& scene : seen) scene.view = view;
        // Of floats coarse voxels are rounded otherwise.
        EXPECT_GE(psnr(render_exact(seen[0]), render_exact(seen[1])), away > 1 ? 50 : 70)
            << voxel_name(type) << " mode " << int(mode) << " from " << away;
      }
    }
  }
}

TEST(Modes, points_far_beyond_the_values_are_the_same_picture) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::f32}) {
    const double most = type == VoxelType::u8 ? 200 : type == VoxelType::u16 ? 40000 : 1;
    const Field field = [=](Vec3d p) {
      return type == VoxelType::f32 ? waves(p) : std::round(most * waves(p));
    };
    TestScene scene =
        planar_scene("far_points", {type, VoxelContent::scalar, 1}, {field}, {44, 40, 36}, 2, 8);
    const scene::TransferFunction near = {
        {{0, {0, 0, 1}}, {most, {1, 0, 0}}}, {{0, 0}, {0.5 * most, 0}, {0.55 * most, 0.6}, {most, 0.6}}, 0};
    scene::TransferFunction last = near, first = near, colors = near;
    last.opacities.back().value = 1e9 * most;
    first.opacities.front().value = -1e9 * most;
    colors.colors.insert(colors.colors.begin(), {-1e9 * most, {0, 0, 1}});
    colors.colors.push_back({1e9 * most, {1, 0, 0}});
    const auto variant = [&](const char* what, auto change) {
      TestScene changed = scene;
      change(changed.view);
      changed.view.functions = {near};
      const render::Picture right = render_exact(changed);
      for (const scene::TransferFunction& far : {last, first, colors}) {
        changed.view.functions = {far};
        EXPECT_GE(psnr(render_exact(changed), right), 60) << voxel_name(type) << ' ' << what;
      }
    };
    variant("lit", [](auto&) {});
    variant("unlit", [](auto& v) { v.lighting.enabled = false; });
    variant("post", [](auto& v) { v.classification = scene::Classification::post; });
    variant("mean", [](auto& v) { v.mode = scene::Mode::mean; });
    variant("maximum", [](auto& v) { v.mode = scene::Mode::maximum; });
    variant("far", [](auto& v) { v.camera.eye = v.camera.target + 4.0 * (v.camera.eye - v.camera.target); });
  }
}

TEST(Modes, a_narrow_window_is_as_smooth_as_a_wide_one) {
  // The same matter in values of a thousandth of the range, and in those of all of it.
  const Field wide = [](Vec3d p) { return ball(p); };
  const Field narrow = [](Vec3d p) { return p.x < 0.02 && p.y < 0.02 ? 1000.0 : ball(p); };
  TestScene scenes[2] = {
      planar_scene("window_wide", {VoxelType::f32, VoxelContent::scalar, 1}, {wide}, {48, 48, 48}, 2, 16),
      planar_scene("window_narrow", {VoxelType::f32, VoxelContent::scalar, 1}, {narrow}, {48, 48, 48}, 2,
                   16)};
  const std::vector<scene::ColorPoint> colors = {{0, {0, 0, 1}}, {1, {1, 0.5, 0}}};
  scenes[0].view.functions = {{colors, {{0.2, 0}, {1, 0.3}}, 0}};
  scenes[1].view.functions = {{colors, {{0.2, 0}, {1, 0.3}, {1.1, 0}, {1000, 0}}, 0}};
  for (const scene::Classification how :
       {scene::Classification::preintegrated, scene::Classification::post}) {
    render::Picture picture[2];
    for (int i = 0; i < 2; ++i) {
      scenes[i].view.lighting.enabled = false;
      scenes[i].view.classification = how;
      // Beside the column of the outlier.
      scenes[i].view.clip = {{0.1, 0.1, 0}, {1, 1, 1}};
      picture[i] = render_exact(scenes[i]);
    }
    EXPECT_GE(psnr(picture[0], picture[1]), 50);
  }
}

/// Tubes of this radius in voxels, 1 within them and 0 around.
Field tubes(double radius, double edge) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0.1, 0.9);
  const auto somewhere = [&] { return Vec3d(place(random), place(random), place(random)); };
  std::vector<std::pair<Vec3d, Vec3d>> axes;
  for (int i = 0; i < 14; ++i) {
    const Vec3d from = somewhere();
    axes.emplace_back(from, somewhere() - from);
  }
  return [=](Vec3d p) {
    const bool inside = std::any_of(axes.begin(), axes.end(), [&](const auto& axis) {
      const auto& [from, way] = axis;
      const double share = std::clamp(dot(p - from, way) / dot(way, way), 0.0, 1.0);
      return length(p - (from + share * way)) * edge < radius;
    });
    return inside ? 1.0 : 0.0;
  };
}

double mean_of(const render::Picture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) sum += double(picture.rgba[i]);
  return sum / double(picture.rgba.size() / 4);
}

TEST(Modes, thin_bright_things_are_as_bright_from_afar) {
  constexpr int kEdge = 160;
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::f32}) {
    const double most = type == VoxelType::u8 ? 255 : type == VoxelType::u16 ? 50000 : 1e-12;
    for (const bool dark : {false, true}) {
      if (dark && type != VoxelType::u8) continue;
      const Field field = [=, tube = tubes(1.1, kEdge)](Vec3d p) {
        return dark ? most - most * tube(p) : most * tube(p);
      };
      TestScene scene =
          planar_scene("tubes", {type, VoxelContent::scalar, 1}, {field}, {kEdge, kEdge, kEdge}, 2, 16);
      scene.view.mode = dark ? scene::Mode::minimum : scene::Mode::maximum;
      scene.view.background = {};
      scene.view.functions = {{{{0, Vec3d(dark ? 1 : 0)}, {most, Vec3d(dark ? 0 : 1)}}, {{0, 1}}, 0}};
      scene.view.camera = {{-250, -560, 190}, Vec3d(kEdge / 2), {0, 0, 1}, 30, 190};
      for (const std::uint32_t pixels : {160u, 80u, 40u, 20u}) {
        scene.view.width = scene.view.height = pixels;
        scene.view.antialias = 1;
        scene.view.level_of_detail = true;
        const render::Picture seen = render_exact(scene);
        EXPECT_EQ(seen.rgba, render_exact(scene, exec::Device::cpu(1), {0, engine::PoolSizes{600, 40}}).rgba);
        scene.view.antialias = 8;
        const render::Picture fine = render_exact(scene);
        scene.view.level_of_detail = false;
        const render::Picture right = render_exact(scene);
        const std::string what =
            std::string(voxel_name(type)) + (dark ? " dark " : " ") + std::to_string(pixels);
        EXPECT_NEAR(mean_of(seen) / mean_of(right), 1, 0.05) << what;
        EXPECT_GE(psnr(fine, right), 40) << what;
        double lit = 0, lit_right = 0;
        for (std::size_t i = 0; i < right.rgba.size(); i += 4) {
          if (right.rgba[i] < 20.0f / 255) continue;
          lit += double(seen.rgba[i]);
          lit_right += double(right.rgba[i]);
        }
        EXPECT_GE(lit, 0.93 * lit_right) << what;
        std::printf("%-12s mean %.4f of %.4f, lit %.3f, %.1f dB, of many rays %.1f dB\n", what.c_str(),
                    mean_of(seen), mean_of(right), lit / lit_right, psnr(seen, right), psnr(fine, right));
      }
    }
  }
}

/// Pictures of two scenes are alike, but within `least` to `most` along both axes, as shares of the picture.
void expect_alike_but_within(const TestScene& a, const TestScene& b, double least, double most,
                             const std::string& what) {
  // The same steps in both, not those of vectors.
  const engine::EngineOptions one_ray{512u << 20, {}, true};
  const render::Picture p = render_exact(a, exec::Device::cpu(), one_ray),
                        q = render_exact(b, exec::Device::cpu(), one_ray);
  const auto within = [&](std::size_t at, std::uint32_t size) {
    const double share = (double(at) + 0.5) / size;
    return share > least && share < most;
  };
  float outside = 0, inside = 0;
  for (std::size_t i = 0; i < p.rgba.size(); ++i) {
    ASSERT_TRUE(std::isfinite(p.rgba[i]) && std::isfinite(q.rgba[i])) << what;
    const std::size_t pixel = i / 4, x = pixel % a.view.width, y = pixel / a.view.width;
    float& greatest = within(x, a.view.width) && within(y, a.view.height) ? inside : outside;
    greatest = std::max(greatest, std::abs(p.rgba[i] - q.rgba[i]));
  }
  EXPECT_LT(outside, 1e-5f) << what;
  EXPECT_EQ(inside > 1e-3f, most > least) << what << ": " << inside;
}

TEST(Modes, no_data_is_transparent_and_takes_no_part) {
  const auto in_block = [](Vec3d p) {
    const auto middle = [](double x) { return x > 0.4 && x < 0.6; };
    return middle(p.x) && middle(p.y) && middle(p.z);
  };
  const auto field = [](Vec3d p) { return -10 + 5 * waves(p); };
  TestScene whole = analytic_scene("whole", field, {50, 50, 50}, {1, 1, 1}, 2, 8);
  TestScene gap = analytic_scene(
      "gap", [&](Vec3d p) { return in_block(p) ? NAN : field(p); }, {50, 50, 50}, {1, 1, 1}, 2, 8);
  for (TestScene* scene : {&whole, &gap}) {
    scene->view.width = scene->view.height = 100;
    scene->view.camera = {{25, 25, -100}, {25, 25, 25}, {0, 1, 0}, 30, 50};
    scene->view.functions[0] = {{{-10, {0.1, 0.2, 0.9}}, {-5, {1, 1, 0.9}}}, {{-9, 0.02}, {-5, 0.4}}, 0};
    scene->view.isovalue = -7;
  }
  for (const bool level_of_detail : {false, true}) {
    for (const scene::Mode mode : {scene::Mode::composite, scene::Mode::maximum, scene::Mode::minimum,
                                   scene::Mode::mean, scene::Mode::isosurface}) {
      for (const scene::Classification how :
           {scene::Classification::preintegrated, scene::Classification::post}) {
        if (mode != scene::Mode::composite && how == scene::Classification::post) continue;
        for (TestScene* scene : {&whole, &gap}) {
          scene->view.level_of_detail = level_of_detail;
          scene->view.mode = mode;
          scene->view.classification = how;
        }
        const std::string what = "mode " + std::to_string(int(mode)) + ", " + std::to_string(int(how));
        expect_alike_but_within(whole, gap, 0.3, 0.7, what);
        EXPECT_EQ(render_exact(gap).rgba,
                  render_exact(gap, exec::Device::cpu(1), {0, engine::PoolSizes{150, 12}}).rgba)
            << what;
      }
    }
  }
}

TEST(Modes, projections_are_of_what_exists) {
  // Of a volume of one value every projection is that value, wherever there is some of it: no ray misses the
  // shell around the gap.
  const auto gap = [](Vec3d p) {
    const Vec3d from_middle = p - Vec3d(0.5);
    return std::max({std::abs(from_middle.x), std::abs(from_middle.y), std::abs(from_middle.z)}) < 0.35;
  };
  const auto some = [&](Vec3d p) { return gap(p) ? NAN : 0.5; };
  TestScene whole = analytic_scene(
      "of_one", [](Vec3d) { return 0.5; }, {48, 48, 48}, {1, 1, 1}, 2, 8);
  TestScene parts = analytic_scene("of_one_with_gap", some, {48, 48, 48}, {1, 1, 1}, 2, 8);
  const VoxelFormat two{VoxelType::f32, VoxelContent::scalar, 2};
  const Field one = [](Vec3d) { return 0.25; };
  TestScene whole_two = planar_scene("two_of_one", two, {one, one}, {48, 48, 48}, 2, 8);
  TestScene parts_two = planar_scene("two_of_one_with_gap", two,
                                     {one, [&](Vec3d p) { return gap(p) ? NAN : 0.25; }}, {48, 48, 48}, 2, 8);
  for (const scene::Mode mode : {scene::Mode::maximum, scene::Mode::minimum, scene::Mode::mean}) {
    for (TestScene* scene : {&whole, &parts, &whole_two, &parts_two}) {
      scene->view.functions[0].opacities = {{0, 0.1}, {1, 0.9}};
      scene->view.mode = mode;
    }
    expect_alike_but_within(whole, parts, 1, 0, "mode " + std::to_string(int(mode)));
    expect_alike_but_within(whole_two, parts_two, 1, 0, "two channels, mode " + std::to_string(int(mode)));
  }
  TestScene none = analytic_scene(
      "of_none", [](Vec3d) { return NAN; }, {20, 20, 20}, {1, 1, 1}, 2, 8);
  none.view.opaque_background = false;
  for (const scene::Mode mode : {scene::Mode::composite, scene::Mode::maximum, scene::Mode::mean}) {
    none.view.mode = mode;
    none.view.functions[0].opacities = {{0, 0.5}};
    for (const float number : render_exact(none).rgba) ASSERT_EQ(number, 0) << int(mode);
  }
}

TEST(Modes, channels_each_have_their_function) {
  const VoxelFormat two{VoxelType::u8, VoxelContent::scalar, 2},
      four{VoxelType::u16, VoxelContent::scalar, 4};
  const auto scaled = [](auto field, double most) {
    return [field, most](Vec3d p) { return std::round(most * field(p)); };
  };
  const auto shifted_ball = [](Vec3d p) { return ball(p + Vec3d(0.15, -0.1, 0)); };
  const auto function = [](double most, Vec3d hue) {
    return scene::TransferFunction{{{0, 0.3 * hue}, {most, hue}}, {{0.35 * most, 0}, {0.9 * most, 0.3}}, 0};
  };
  TestScene scene = planar_scene("two", two, {scaled(ball, 255), scaled(waves, 255)}, {50, 44, 40}, 2, 8);
  scene.view.functions = {function(255, {1, 0.4, 0.2}), function(255, {0.2, 0.6, 1})};
  expect_right(scene, "two channels of u8", 54);
  scene.view.mode = scene::Mode::maximum;
  expect_right(scene, "their maxima", 45);

  scene = planar_scene("four", four,
                       {scaled(ball, 60000), scaled(waves, 60000), scaled(shifted_ball, 60000),
                        scaled([](Vec3d p) { return p.x; }, 60000)},
                       {50, 44, 40}, 3, 16);
  scene.view.functions = {function(60000, {1, 0, 0}), function(60000, {0, 1, 0}), function(60000, {0, 0, 1}),
                          function(60000, {1, 1, 0})};
  expect_right(scene, "four channels of u16", 45);
}

TEST(Modes, labels_are_never_blended) {
  const Field regions = [](Vec3d p) {
    const double r = length(p - Vec3d(0.5));
    return r > 0.45 ? 0.0 : std::floor(p.x * 4) + 4 * std::floor(p.y * 2) + 1;
  };
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16}) {
    TestScene scene = planar_scene("labels", {type, VoxelContent::labels, 1}, {regions}, {48, 48, 48}, 2, 8);
    scene.view.functions = {scene::label_colors(9)};
    scene.view.functions[0].opacities = {{0, 0}, {0.5, 0}, {0.5, 0.15}};
    scene.view.lighting.enabled = false;
    expect_right(scene, "translucent labels", 46);
    // With opaque labels every colour of the picture is one of the table or the background.
    scene.view.functions[0].opacities = {{0, 0}, {0.5, 0}, {0.5, 1}};
    const render::Picture picture = render_exact(scene);
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
      double nearest = 1;
      for (int label = 0; label < 9; ++label) {
        const Vec3d c = label == 0 ? Vec3d(scene.view.background) : scene.view.functions[0].color(label);
        const Vec3d d = c - Vec3d(Vec3f(picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]));
        nearest = std::min(nearest, length(d));
      }
      ASSERT_LT(nearest, 0.003) << i / 4;
    }
    scene.view.lighting.enabled = true;
    scene.view.functions[0].opacities = {{0, 0}, {0.5, 0}, {0.5, 0.15}};
    expect_right(scene, "translucent labels, lit", 37);
  }
}

TEST(Modes, colours_and_normals) {
  const auto opacity = [](Vec3d p) { return std::clamp(1.2 - 3 * length(p - Vec3d(0.5)), 0.0, 0.6); };
  const auto plane = [&](auto value) {
    return [=](Vec3d p) { return std::round(255 * opacity(p) * value(p)); };
  };
  const std::vector<Field> colors = {plane([](Vec3d p) { return p.x; }), plane([](Vec3d p) { return p.y; }),
                                     plane([](Vec3d) { return 0.5; }), plane([](Vec3d) { return 1.0; })};
  TestScene scene =
      planar_scene("colors", {VoxelType::u8, VoxelContent::color, 4}, colors, {44, 44, 44}, 2, 8);
  scene.view.functions.clear();
  scene.view.lighting.enabled = false;
  expect_right(scene, "colour voxels", 80);

  std::vector<Field> with_normals = colors;
  for (int axis = 0; axis < 3; ++axis) {
    with_normals.emplace_back([=](Vec3d p) {
      const Vec3d d = p - Vec3d(0.5);
      return std::round(127 + 127 * opacity(p) * d[axis] / std::max(length(d), 1e-9));
    });
  }
  scene = planar_scene("normals", {VoxelType::u8, VoxelContent::color_normal, 7}, with_normals, {44, 44, 44},
                       2, 8);
  scene.view.functions.clear();
  expect_right(scene, "colour voxels with normals", 80);
}

TEST(Modes, lights_and_gradient_opacity) {
  const TestScene scene = analytic_scene("lights", ball, {60, 50, 40}, {1, 1.2, 1}, 2, 16);
  const auto variant = [&](const char* what, auto change) {
    TestScene changed = scene;
    change(changed.view);
    expect_right(changed, what, 80);
  };
  variant("a light in the world", [](auto& v) {
    v.lighting.light[0] = {scene::LightKind::directional, {1, 2, -3}, {1, 0.9f, 0.8f}};
  });
  variant("three lights, one of them near", [](auto& v) {
    v.lighting.lights = 3;
    v.lighting.light[0].color = Vec3f(0.4f);
    v.lighting.light[1] = {scene::LightKind::directional, {1, 2, -3}, {0.5f, 0.2f, 0}};
    v.lighting.light[2] = {scene::LightKind::point, {10, -30, 20}, {0, 0.3f, 0.6f}};
  });
  variant("no light but ambient", [](auto& v) { v.lighting.lights = 0; });
  variant("opacity by gradient", [](auto& v) {
    v.functions[0].gradients = {{0.01, 0}, {0.03, 1}, {0.1, 0.5}};
  });
}

TEST(Modes, what_cannot_be_looked_at_so_is_an_error) {
  const auto look = [](const TestScene& scene) {
    return engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value()->look(scene.view);
  };
  TestScene labels = planar_scene("bad", {VoxelType::u8, VoxelContent::labels, 1},
                                  {[](Vec3d p) { return std::floor(3 * p.x); }}, {20, 20, 20}, 2, 8);
  EXPECT_TRUE(look(labels).ok());
  labels.view.classification = scene::Classification::post;
  EXPECT_FALSE(look(labels).ok());
  labels.view.classification = scene::Classification::preintegrated;
  labels.view.mode = scene::Mode::maximum;
  EXPECT_FALSE(look(labels).ok());
  TestScene two =
      planar_scene("bad2", {VoxelType::u8, VoxelContent::scalar, 2},
                   {[](Vec3d p) { return 9 * p.x; }, [](Vec3d p) { return 9 * p.y; }}, {20, 20, 20}, 2, 8);
  two.view.mode = scene::Mode::isosurface;
  EXPECT_FALSE(look(two).ok());
  two.view.mode = scene::Mode::composite;
  two.view.functions.clear();
  EXPECT_FALSE(look(two).ok());
}

}  // namespace
}  // namespace gvx::tests
