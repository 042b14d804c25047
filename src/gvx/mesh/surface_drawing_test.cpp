// Pictures of surfaces: the techniques against each other, and against rays through the triangles.

#include "gvx/surface/draw/surface_drawing.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/mesh/mesh_query.h"
#include "gvx/mesh/mesh_test_support.h"
#include "gvx/mesh/surface_store.h"
#include "gvx/surface/draw/surface_test_support.h"

namespace gvx::mesh {
namespace {

using surface::Piece;
using surface::SurfaceDrawing;
using surface::SurfacePixel;
using surface::SurfaceView;
using surface::Technique;
using surface::WholeSurface;

/// A ball with bumps; no axis or plane is special to it.
io::TriangleMesh bumpy_ball(int cuts) {
  io::TriangleMesh mesh = sphere_mesh({}, 1, cuts);
  for (Vec3f& v : mesh.vertices) {
    const float bump = std::sin(5 * v.x + 1) * std::sin(4 * v.y - 2) * std::sin(6 * v.z + 0.5f);
    mesh.colors.emplace_back(0.5f + 0.5f * std::sin(3 * v.x), 0.5f + 0.5f * std::cos(4 * v.z), 0.6f);
    v = (1 + 0.2f * bump) * v;
  }
  return mesh;
}

std::unique_ptr<WholeSurface> surface_of(const io::TriangleMesh& mesh) {
  const std::string path = testing::TempDir() + "gvx_surface_drawing.gvx";
  const auto spool = spooled(mesh);
  GVX_CHECK(build_surface_store(*spool, path, {}).ok());
  return std::make_unique<WholeSurface>(*surface::SurfaceReader::open(path).value());
}

/// Towards the middle, from a distance and in a direction.
SurfaceView view_from(Vec3d eye, std::uint32_t width = 256, std::uint32_t height = 192, double fov = 40,
                      double height_world = 0) {
  SurfaceView view;
  view.width = width;
  view.height = height;
  scene::Camera camera;
  camera.eye = eye;
  camera.up = std::fabs(normalize(eye).z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
  camera.fov_degrees = fov;
  camera.height_world = height_world;
  view.camera = scene::make_view(camera, width, height).value();
  view.lighting = scene::place_lights({}, view.camera.forward, view.camera.right, view.camera.up);
  return view;
}

std::vector<SurfacePixel> pixels_of(const SurfaceDrawing& drawing) {
  const auto film = drawing.film();
  std::vector<SurfacePixel> pixels;
  for (std::uint32_t y = 0; y < film.height; ++y) {
    for (std::uint32_t x = 0; x < film.width; ++x) pixels.push_back(film.at(x, y));
  }
  return pixels;
}

std::vector<SurfacePixel> drawn(const SurfaceView& view, std::span<const surface::SurfaceInstance> instances,
                                int threads = 2) {
  SurfaceDrawing drawing(exec::Device::cpu(threads), view, instances);
  while (!drawing.complete()) {
    if (!drawing.advance().empty()) ADD_FAILURE() << "all is there";
  }
  return pixels_of(drawing);
}
std::vector<SurfacePixel> drawn(const SurfaceView& view, WholeSurface& whole, int threads = 2) {
  const surface::SurfaceInstance instance = whole.instance();
  return drawn(view, std::span(&instance, 1), threads);
}

/// In how many pixels do two pictures show another place or another colour by more than this?
struct Differences {
  int silhouettes = 0, places = 0, colors = 0;
};
Differences differences(const std::vector<SurfacePixel>& a, const std::vector<SurfacePixel>& b, float place,
                        float color) {
  Differences count;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].seen() != b[i].seen()) {
      ++count.silhouettes;
    } else if (a[i].seen()) {
      count.places += std::fabs(a[i].place - b[i].place) > place ? 1 : 0;
      count.colors += length(a[i].color - b[i].color) > color ? 1 : 0;
    }
  }
  return count;
}

TEST(SurfaceDrawing, casts_and_splats_find_the_same) {
  const auto whole = surface_of(bumpy_ball(6));
  SurfaceView view = view_from({1.5, -4, 1});
  view.plain = true;
  view.only = Technique::cast;
  const auto cast = drawn(view, *whole);
  view.only = Technique::splat;
  const auto splat = drawn(view, *whole);
  const Differences differ = differences(cast, splat, 1e-4f, 1e-3f);
  EXPECT_LE(differ.silhouettes, 2);
  EXPECT_LE(differ.places, 12) << "rays through edges of cells";
  EXPECT_LE(differ.colors, 12);
}

struct VectorCase {
  const char* name;
  Technique technique;
  double height_world;  // 0: perspective
};
class SurfaceVectors : public testing::TestWithParam<VectorCase> {};
INSTANTIATE_TEST_SUITE_P(techniques, SurfaceVectors,
                         testing::Values(VectorCase{"cast", Technique::cast, 0},
                                         VectorCase{"cast_parallel", Technique::cast, 2.6},
                                         VectorCase{"rasterise", Technique::rasterise, 0},
                                         VectorCase{"rasterise_parallel", Technique::rasterise, 2.6}),
                         [](const auto& param) { return param.param.name; });

TEST_P(SurfaceVectors, find_what_the_plain_way_finds) {
  const auto whole = surface_of(bumpy_ball(6));
  for (const Vec3d& eye : {Vec3d(1.5, -4, 1), Vec3d(0.2, 0.1, 5), Vec3d(-0.9, 0.8, -0.7)}) {
    SurfaceView view = view_from(eye, 256, 192, 40, GetParam().height_world);
    view.only = GetParam().technique;
    if (view.only == Technique::rasterise) view.widest_cell = 0;
    const auto vectors = drawn(view, *whole);
    view.plain = true;
    const auto plain = drawn(view, *whole);
    // Rays that graze an edge of a cell, or come within 1/256 pixel of a triangle's edge, may find another.
    const Differences differ = differences(plain, vectors, 0.01f, 0.02f);
    EXPECT_LE(differ.silhouettes, 12);
    EXPECT_LE(differ.places, 40);
    EXPECT_LE(differ.colors, 100);
  }
}

/// What a ray through the middle of each pixel meets first of a mesh: its depth; infinite where none.
std::vector<float> depths_by_rays(const io::TriangleMesh& mesh, const SurfaceView& view) {
  const auto query = MeshQuery::create(mesh).value();
  std::vector<float> depths;
  for (std::uint32_t y = 0; y < view.height; ++y) {
    for (std::uint32_t x = 0; x < view.width; ++x) {
      const Ray ray = view.camera.pixel_ray(x, y);
      const auto met = query->first_and_last(Vec3f(ray.origin), Vec3f(ray.direction));
      depths.push_back(met ? met->first * float(dot(ray.direction, view.camera.forward)) : INFINITY);
    }
  }
  return depths;
}

/// Compares a picture with rays: no pixel may be missing that lies a pixel or more inside the silhouette,
/// none may be shown a pixel or more outside of it, and inside places are within a cell.
void expect_like_rays(const io::TriangleMesh& mesh, const SurfaceView& view,
                      const std::vector<SurfacePixel>& pixels, double cell) {
  const std::vector<float> depths = depths_by_rays(mesh, view);
  const auto width = static_cast<int>(view.width), height = static_cast<int>(view.height);
  int missing = 0, beyond = 0;
  std::vector<double> errors, beyond_neighbours;  // in cells
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      int met = 0;
      float least = INFINITY, most = 0;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          const float depth = depths[static_cast<std::size_t>((y + j) * width + x + i)];
          if (!(depth < INFINITY)) continue;
          ++met;
          least = std::min(least, depth), most = std::max(most, depth);
        }
      }
      const SurfacePixel& pixel = pixels[static_cast<std::size_t>(y * width + x)];
      if (met == 9 && !pixel.seen()) ++missing;
      if (met == 0 && pixel.seen()) ++beyond;
      // Where the surface is torn, which side is seen may differ.
      if (met != 9 || !pixel.seen()) continue;
      const double of_pixel =
          std::max(view.camera.orthographic ? 1.0 : double(most), 0.0) * view.camera.pixel;
      if (most - least > 8 * of_pixel) continue;
      const double finest = std::max(cell, of_pixel);
      const double ray = depths[static_cast<std::size_t>(y * width + x)];
      errors.push_back(std::fabs(pixel.place - ray) / finest);
      const double held = std::clamp(pixel.place, least, most);
      beyond_neighbours.push_back(std::fabs(pixel.place - held) / finest);
    }
  }
  EXPECT_EQ(missing, 0);
  EXPECT_EQ(beyond, 0);
  ASSERT_FALSE(errors.empty());
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.5);
  std::sort(beyond_neighbours.begin(), beyond_neighbours.end());
  EXPECT_LT(beyond_neighbours[beyond_neighbours.size() * 99 / 100], 1);
}

TEST(SurfaceDrawing, shows_what_rays_meet_from_near_and_far_and_at_grazing_angles) {
  const io::TriangleMesh mesh = bumpy_ball(6);
  if (const auto made = MeshQuery::create(mesh); !made.ok()) GTEST_SKIP() << made.error().message;
  const auto whole = surface_of(mesh);
  const double cell = length(whole->info().cells_to_world.column[0]);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 24; ++i) {
    const Vec3d way = normalize(Vec3d(share(random), share(random), share(random)));
    const double distance = std::exp2(0.6 + 4.4 * std::fabs(share(random)));
    SCOPED_TRACE("view " + std::to_string(i) + " from " + std::to_string(distance));
    const SurfaceView view = view_from(distance * way, 160, 120, i % 3 == 0 ? 12 : 40, i % 5 == 0 ? 3 : 0);
    expect_like_rays(mesh, view, drawn(view, *whole), cell);
  }
}

/// What random parts of a surface are there.
class PartlyThere final : public surface::ResidentSurface {
 public:
  PartlyThere(WholeSurface& whole, std::uint32_t seed) : whole_(whole), random_(seed) {}

  const surface::SurfaceNode* node(std::uint32_t level, std::uint32_t place) override {
    return pages_.contains({level, place / surface::kPageNodes}) ? whole_.node(level, place) : nullptr;
  }
  const std::byte* piece(std::uint32_t level, std::uint32_t place, Piece piece) override {
    return pieces_.contains({level, place, static_cast<int>(piece)}) ? whole_.piece(level, place, piece)
                                                                     : nullptr;
  }
  /// Some of what lacks comes, and some of what is there goes.
  void change(const std::vector<surface::LackingElement>& lacking) {
    for (const auto& element : lacking) {
      if (&element != &lacking.front() && random_() % 3 == 0) continue;
      if (element.page) {
        pages_.insert({element.level, element.place});
      } else {
        pieces_.insert({element.level, element.place, static_cast<int>(element.piece)});
      }
    }
    if (forgets) std::erase_if(pieces_, [&](const auto&) { return random_() % 8 == 0; });
  }
  bool forgets = false;

 private:
  WholeSurface& whole_;
  std::mt19937 random_;
  std::set<std::tuple<std::uint32_t, std::uint32_t>> pages_;
  std::set<std::tuple<std::uint32_t, std::uint32_t, int>> pieces_;
};

TEST(SurfaceDrawing, is_the_same_bits_whatever_comes_when_on_any_number_of_threads) {
  io::TriangleMesh mesh = bumpy_ball(6);
  // Faces that reach through many bricks, and through the ball.
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(),
                       {{-2, -1, -1}, {2, -0.8f, -0.9f}, {1.5f, 1, 1.2f}, {-1.8f, 1.1f, 0.8f}});
  mesh.colors.insert(mesh.colors.end(), 4, {0.9f, 0.8f, 0.2f});
  mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  const auto whole = surface_of(mesh);
  const SurfaceView view = view_from({1.1, -2.1, 0.8});
  const auto expected = drawn(view, *whole, 1);
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    PartlyThere part(*whole, seed);
    part.forgets = seed % 2 == 1;
    surface::SurfaceInstance instance = whole->instance();
    instance.surface = &part;
    SurfaceDrawing drawing(exec::Device::cpu(1 + int(seed % 3)), view, {&instance, 1});
    int passes = 0;
    while (!drawing.complete() && ++passes < 1000) part.change(drawing.advance());
    ASSERT_LT(passes, 1000);
    const auto pixels = pixels_of(drawing);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      ASSERT_EQ(pixels[i].depth, expected[i].depth);
      ASSERT_EQ(pixels[i].place, expected[i].place);
      ASSERT_EQ(pixels[i].color, expected[i].color);
    }
  }
}

TEST(SurfaceDrawing, shows_coarser_bricks_in_the_meantime_and_never_a_hole) {
  const auto whole = surface_of(bumpy_ball(6));
  const SurfaceView view = view_from({1.1, -2.1, 0.8});
  const auto exact = drawn(view, *whole);
  PartlyThere part(*whole, 7);
  surface::SurfaceInstance instance = whole->instance();
  instance.surface = &part;
  SurfaceDrawing drawing(exec::Device::cpu(2), view, {&instance, 1});
  bool shows_some = false;
  int passes = 0;
  while (!drawing.complete() && ++passes < 1000) {
    const auto lacking = drawing.draw_resident();
    if (shows_some || drawing.counts().drawn() > 0) {
      shows_some = true;
      const auto rough = pixels_of(drawing);
      for (std::size_t i = 0; i < rough.size(); ++i)
        ASSERT_TRUE(rough[i].shaded() || !exact[i].seen()) << passes;
    }
    part.change(lacking);
  }
  EXPECT_GT(passes, 4);
  EXPECT_LT(passes, 1000);
  const auto pixels = pixels_of(drawing);
  for (std::size_t i = 0; i < pixels.size(); ++i) ASSERT_EQ(pixels[i].color, exact[i].color);
}

TEST(SurfaceDrawing, what_is_hidden_is_not_asked_for) {
  // A plate before a ball.
  io::TriangleMesh mesh = sphere_mesh({0, 2, 0}, 0.9, 6);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{-2, 0, -2}, {2, 0, -2}, {2, 0, 2}, {-2, 0, 2}});
  mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  const auto whole = surface_of(mesh);
  SurfaceView view = view_from({0, -4, 0});
  PartlyThere part(*whole, 1);
  surface::SurfaceInstance instance = whole->instance();
  instance.surface = &part;
  SurfaceDrawing drawing(exec::Device::cpu(2), view, {&instance, 1});
  std::set<std::pair<std::uint32_t, std::uint32_t>> colors_asked;
  while (!drawing.complete()) {
    const auto lacking = drawing.advance();
    for (const auto& element : lacking) {
      if (!element.page && element.piece == Piece::attributes)
        colors_asked.insert({element.level, element.place});
    }
    part.change(lacking);
  }
  EXPECT_TRUE(colors_asked.empty()) << "the plate is drawn as triangles, and all else is behind it";
}

TEST(SurfaceDrawing, is_seen_from_within_too) {
  const io::TriangleMesh mesh = bumpy_ball(5);
  if (const auto made = MeshQuery::create(mesh); !made.ok()) GTEST_SKIP() << made.error().message;
  const auto whole = surface_of(mesh);
  for (const bool plain : {false, true}) {
    SurfaceView view = view_from({0.3, 0.2, -0.1}, 96, 72, 90);
    view.plain = plain;
    const auto pixels = drawn(view, *whole);
    const std::vector<float> depths = depths_by_rays(mesh, view);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      ASSERT_TRUE(pixels[i].seen());
      EXPECT_NEAR(pixels[i].place, depths[i], 0.01);
    }
  }
}

TEST(SurfaceDrawing, instances_stand_before_each_other_as_they_should) {
  const auto whole = surface_of(bumpy_ball(5));
  std::vector<surface::SurfaceInstance> instances;
  for (int i = 0; i < 5; ++i) {
    surface::SurfaceInstance instance = whole->instance(i);
    // Mirrored, turned and sheared.
    const Affine3 place{{{i % 2 == 0 ? 0.5 : -0.5, 0.1 * i, 0}, {0, 0.6, 0.05 * i}, {0, -0.1, 0.5}},
                        {0.4 * i - 0.8, 0.7 * i, 0.1 * i}};
    instance.cells_to_world = place * instance.cells_to_world;
    instances.push_back(instance);
  }
  const SurfaceView view = view_from({0.5, -4, 0.6});
  const auto together = drawn(view, instances);
  std::vector<SurfacePixel> nearest(together.size());
  for (const auto& instance : instances) {
    const auto alone = drawn(view, {&instance, 1});
    for (std::size_t i = 0; i < alone.size(); ++i) {
      if (alone[i].depth < nearest[i].depth) nearest[i] = alone[i];
    }
  }
  for (std::size_t i = 0; i < together.size(); ++i) {
    ASSERT_EQ(together[i].object, nearest[i].object);
    ASSERT_EQ(together[i].depth, nearest[i].depth);
    ASSERT_LT(length(together[i].color - nearest[i].color), 1e-4f);
  }
}

TEST(SurfaceDrawing, another_view_in_the_same_memory_is_like_one_of_its_own) {
  const auto whole = surface_of(bumpy_ball(5));
  const surface::SurfaceInstance instance = whole->instance();
  SurfaceDrawing drawing(exec::Device::cpu(2), view_from({3, -3, 0}), {&instance, 1});
  while (!drawing.complete()) drawing.advance();
  const SurfaceView other = view_from({0, 2, 6});
  drawing.see(other, {&instance, 1});
  while (!drawing.complete()) drawing.advance();
  const auto again = pixels_of(drawing), expected = drawn(other, *whole);
  for (std::size_t i = 0; i < again.size(); ++i) ASSERT_EQ(again[i].color, expected[i].color);
}

/// Meshes that break rules are shown as far as there is something to see.
TEST(SurfaceDrawing, thin_doubled_inverted_and_torn_faces_are_shown) {
  io::TriangleMesh mesh;
  const auto add = [&](Vec3f a, Vec3f b, Vec3f c) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (int i = 0; i < 2000; ++i) {  // a torn sheet, every second face turned over
    const float x = float(i % 50) / 25 - 1, z = float(i / 50) / 20 - 1, s = 0.04f;
    if (i % 2 == 0) {
      add({x, 0, z}, {x + s, 0, z}, {x, 0, z + s});
    } else {
      add({x, 0, z}, {x, 0, z + s}, {x + s, 0, z});
    }
  }
  add({-0.5f, -0.2f, -0.5f}, {0.5f, -0.2f, -0.5f}, {0, -0.2f, 0.6f});  // one before it, and its like
  add({-0.5f, -0.2f, -0.5f}, {0.5f, -0.2f, -0.5f}, {0, -0.2f, 0.6f});
  add({-0.9f, -0.3f, 0.9f}, {0.9f, -0.3f, 0.9f}, {0.9f, -0.3f, 0.93f});  // thinner than a cell
  const auto whole = surface_of(mesh);
  if (const auto made = MeshQuery::create(mesh); !made.ok()) GTEST_SKIP() << made.error().message;
  const auto compare = [&](double distance, int most_missing_of, auto counts) {
    const SurfaceView view = view_from({0, -distance, 0.2}, 160, 120);
    const auto pixels = drawn(view, *whole);
    const std::vector<float> depths = depths_by_rays(mesh, view);
    int seen_by_both = 0, missing = 0, elsewhere = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!counts(depths[i])) continue;
      (pixels[i].seen() ? seen_by_both : missing) += 1;
      elsewhere += pixels[i].seen() && std::fabs(pixels[i].place - depths[i]) > 0.1f ? 1 : 0;
    }
    EXPECT_GT(seen_by_both, 300);
    EXPECT_LT(missing, seen_by_both / most_missing_of);
    EXPECT_LT(elsewhere, seen_by_both / 100);
  };
  compare(2.5, 100, [](float depth) { return depth < INFINITY; });
  // From afar what is as thin as a pixel may lie between two samples: a face of the torn sheet, and some of
  // the needle.
  compare(5, 25, [](float depth) { return depth < 4.9f; });
}

}  // namespace
}  // namespace gvx::mesh
