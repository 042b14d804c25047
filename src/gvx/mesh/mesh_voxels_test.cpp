// Meshes that do not fit memory: what is known of them, their corners' normals, the slabs that they are
// sorted into, and that a store does not tell in how many slabs it was made.

#include "gvx/mesh/mesh_voxels.h"

#include <fstream>
#include <iterator>
#include <random>

#include <gtest/gtest.h>

#include "gvx/mesh/corner_normals.h"
#include "gvx/mesh/mesh_query.h"
#include "gvx/mesh/mesh_test_support.h"

namespace gvx::mesh {
namespace {

io::TriangleMesh cube() {
  io::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// With vertices of its own for each triangle.
io::TriangleMesh unconnected(const io::TriangleMesh& mesh) {
  io::TriangleMesh soup;
  for (const io::Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : t) soup.vertices.push_back(mesh.vertices[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

std::vector<SpooledTriangle> all_of(const MeshSpool& spool) {
  std::vector<SpooledTriangle> triangles(spool.summary().triangles);
  EXPECT_TRUE(spool.triangles().read(0, triangles).ok());
  return triangles;
}

TEST(MeshSpool, knows_the_mesh_as_a_whole) {
  io::TriangleMesh mesh = cube();
  EXPECT_TRUE(spooled(mesh)->summary().closed());
  EXPECT_TRUE(spooled(unconnected(mesh))->summary().closed());
  // The two zeros are one place.
  io::TriangleMesh soup = unconnected(mesh);
  soup.vertices[0].x = -0.0f;
  EXPECT_TRUE(spooled(soup)->summary().closed());
  soup.vertices[0].x = 1e-6f;
  EXPECT_FALSE(spooled(soup)->summary().closed());

  mesh.triangles.push_back({0, 1, 99});  // of a vertex that is not there
  mesh.triangles.push_back({0, 1, 1});
  mesh.vertices.emplace_back(NAN, 0, 0);
  mesh.triangles.push_back({0, 1, 8});
  mesh.vertices.emplace_back(100, 0, 0);  // of no triangle
  MeshSummary summary = spooled(mesh)->summary();
  EXPECT_EQ(summary.triangles, 12u);
  EXPECT_EQ(summary.dropped, 3u);
  EXPECT_EQ(summary.vertices, 10u);
  EXPECT_TRUE(summary.closed());
  EXPECT_FALSE(summary.colors);
  EXPECT_EQ(summary.bounds, (Box3d{{0, 0, 0}, {1, 1, 1}}));

  // Missing any one triangle it is open, and the mean colour is that of what is there.
  for (std::size_t missing = 0; missing < 12; ++missing) {
    io::TriangleMesh open = cube();
    open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(missing));
    EXPECT_FALSE(spooled(open)->summary().closed()) << missing;
  }
  io::TriangleMesh colored = cube();
  for (const Vec3f& v : colored.vertices) colored.colors.push_back(v);
  summary = spooled(colored)->summary();
  EXPECT_TRUE(summary.colors);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(summary.mean_color[axis], 0.5f, 1e-6f);
}

TEST(MeshSpool, finds_vertices_that_are_not_in_memory) {
  // More vertices than the spool keeps, met in any order, and some that come later.
  auto spool = MeshSpool::create(testing::TempDir(), 1).value();
  std::mt19937 random(3);
  std::vector<Vec3d> places;
  std::vector<io::Triangle> triangles;
  for (int round = 0; round < 2; ++round) {
    std::vector<Vec3d> more;
    for (int i = 0; i < 30500; ++i) {
      more.emplace_back(double(random() % 1000), double(random() % 1000), double(random() % 1000));
    }
    ASSERT_TRUE(spool->add_vertices(more, {}).ok());
    places.insert(places.end(), more.begin(), more.end());
    std::vector<io::Triangle> these;
    for (int i = 0; i < 2000; ++i) {
      const auto any = [&] { return static_cast<std::uint32_t>(random() % places.size()); };
      const io::Triangle t = {any(), any(), any()};
      if (io::has_area(places[t[0]], places[t[1]], places[t[2]])) these.push_back(t);
    }
    ASSERT_TRUE(spool->add_triangles(these).ok());
    triangles.insert(triangles.end(), these.begin(), these.end());
  }
  ASSERT_TRUE(spool->finish().ok());
  const std::vector<SpooledTriangle> found = all_of(*spool);
  ASSERT_EQ(found.size(), triangles.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(found[i].corners[k], places[triangles[i][k]]);
  }
}

/// The normals of a mesh's corners, of unit length.
std::vector<std::array<Vec3f, 3>> normals_of(const io::TriangleMesh& mesh, std::uint64_t memory_bytes) {
  CornerNormals normals(testing::TempDir(), memory_bytes, mesh.triangles.size());
  for (const io::Triangle& t : mesh.triangles) {
    EXPECT_TRUE(normals.push({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}).ok());
  }
  std::vector<std::array<Vec3f, 3>> found;
  const auto take = [&](const std::array<Normal16, 3>& corners) -> Status {
    auto& triangle = found.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = Vec3f(Vec3<std::int16_t>(corners[k][0], corners[k][1], corners[k][2])) / 32767.0f;
    }
    return {};
  };
  EXPECT_TRUE(normals.for_each(take).ok());
  EXPECT_EQ(found.size(), mesh.triangles.size());
  return found;
}

TEST(CornerNormals, are_smooth_on_a_ball_and_keep_the_edges_of_a_cube) {
  for (const std::uint64_t memory : {1u << 24, 1u << 12}) {
    const io::TriangleMesh ball = sphere_mesh({1, 2, 3}, 2, 4);
    const auto smooth = normals_of(ball, memory);
    for (std::size_t t = 0; t < smooth.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f radial = normalize(ball.vertices[ball.triangles[t][k]] - Vec3f(1, 2, 3));
        ASSERT_GT(std::fabs(dot(smooth[t][k], radial)), 0.9998f);
      }
    }
    const auto sharp = normals_of(unconnected(cube()), memory);
    const io::TriangleMesh mesh = cube();
    for (std::size_t t = 0; t < sharp.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3f flat =
          normalize(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
      for (const Vec3f& normal : sharp[t]) EXPECT_EQ(normal, flat);
    }
  }
}

TEST(CornerNormals, of_a_hub_of_very_many_triangles_are_those_of_each) {
  io::TriangleMesh cone;
  cone.vertices.emplace_back(0, 0, 1);
  constexpr int kTriangles = 1000;
  for (int i = 0; i < kTriangles; ++i) {
    const auto angle = static_cast<float>(2 * M_PI * i / kTriangles);
    cone.vertices.emplace_back(3 * std::cos(angle), 3 * std::sin(angle), 0);
    const auto v = static_cast<std::uint32_t>(i);
    cone.triangles.push_back({0, 1 + v, 1 + (v + 1) % kTriangles});
  }
  const auto normals = normals_of(cone, 1 << 24);
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const auto& [a, b, c] = cone.triangles[t];
    const Vec3f flat =
        normalize(cross(cone.vertices[b] - cone.vertices[a], cone.vertices[c] - cone.vertices[a]));
    ASSERT_GT(dot(normals[t][0], flat), 0.9999f) << t;
    // At the rim the two that meet there are mixed.
    ASSERT_GT(dot(normals[t][1], flat), 0.9999f) << t;
  }
}

/// Triangles of any size anywhere.
io::TriangleMesh random_soup(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> number(0, 1);
  io::TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const Vec3f centre(100 * number(random), 70 * number(random), 50 * number(random));
    const float size = number(random) < 0.1f ? 60 : 3;
    for (int k = 0; k < 3; ++k) {
      Vec3f v = centre;
      for (int axis = 0; axis < 3; ++axis) {
        const float most = axis == 0 ? 100 : axis == 1 ? 70 : 50;
        v[axis] = std::clamp(v[axis] + size * (number(random) - 0.5f), 0.0f, most);
      }
      mesh.vertices.push_back(v);
    }
    const auto first = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TEST(MeshSlabs, hold_what_is_near_to_them_in_order_and_no_more_than_they_may) {
  const Vec3i dimensions(100, 70, 50);
  std::size_t cut_rows = 0, refused = 0;
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    const auto spool = spooled(random_soup(3000, seed));
    const std::vector<SpooledTriangle> all = all_of(*spool);
    for (const std::uint64_t most : {4000u, 2000u, 1000u, 400u, 250u}) {
      const auto sorted = MeshSlabs::sort(*spool, {{0, 0, 0}, 1, dimensions}, 1 << 18, most, {});
      ASSERT_TRUE(sorted.ok());
      if (!sorted.value()) {
        ++refused;
        EXPECT_EQ(most, 250u);
        continue;
      }
      const MeshSlabs& slabs = *sorted.value();
      std::int64_t y = 0, z = 0, z_end = 0;
      for (const MeshSlabs::Slab& slab : slabs.slabs()) {
        // They cover everything, slices by slices.
        if (y == 0) z_end = slab.z_end;
        ASSERT_EQ(slab.y_begin, y);
        ASSERT_EQ(slab.z_begin, z);
        ASSERT_EQ(slab.z_end, z_end);
        cut_rows += slab.y_end < dimensions.y ? 1 : 0;
        y = slab.y_end == dimensions.y ? 0 : slab.y_end;
        if (y == 0) z = z_end;

        ASSERT_LE(slab.count, most);
        std::vector<SlabTriangle> found(slab.count);
        ASSERT_TRUE(slabs.read(slab, 0, found).ok());
        std::size_t next = 0;
        for (const SpooledTriangle& triangle : all) {
          bool near = true;
          for (const auto& [axis, begin, end] :
               {std::tuple(1, slab.y_begin, slab.y_end), std::tuple(2, slab.z_begin, slab.z_end)}) {
            const auto [low, high] = std::minmax(
                {triangle.corners[0][axis], triangle.corners[1][axis], triangle.corners[2][axis]});
            near = near && low - 1.6f < static_cast<float>(end) && high + 1.6f > static_cast<float>(begin);
          }
          const auto& [a, b, c] = triangle.corners;
          const bool here = next < found.size() &&
                            found[next].corners == std::array<Vec3f, 3>{Vec3f(a), Vec3f(b), Vec3f(c)};
          ASSERT_TRUE(here || !near);
          next += here ? 1 : 0;
        }
        ASSERT_EQ(next, found.size());
      }
      EXPECT_EQ(z, dimensions.z);
      EXPECT_EQ(y, 0);
    }
  }
  EXPECT_GT(cut_rows, 10u);
  EXPECT_GT(refused, 0u);
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(MeshVoxels, are_the_same_bytes_in_however_many_slabs) {
  if (const auto made = MeshQuery::create(cube()); !made.ok()) GTEST_SKIP() << made.error().message;
  io::TriangleMesh mesh = sphere_mesh({0, 0, 0}, 1, 6);
  for (Vec3f& v : mesh.vertices) {
    mesh.colors.emplace_back(0.5f + 0.5f * std::sin(7 * v.x), 0.5f + 0.5f * v.y, 0.3f);
    v = (1 + 0.2f * std::sin(9 * v.y) * std::sin(8 * v.z)) * v;
  }
  // Faces along the axes, in squares of which many voxels are as near to several.
  constexpr std::uint32_t kSquares = 24;
  for (const float x : {-0.7f, 0.5f}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i < kSquares; ++i) {
      for (std::uint32_t j = 0; j < kSquares; ++j) {
        mesh.vertices.emplace_back(x, float(i) / kSquares - 0.5f, float(j) / kSquares - 0.5f);
        mesh.colors.emplace_back(float(i % 2), float(j % 2), 1);
        if (i == 0 || j == 0) continue;
        const std::uint32_t v = first + i * kSquares + j;
        mesh.triangles.push_back({v, v - 1, v - kSquares});
        mesh.triangles.push_back({v - 1, v - kSquares, v - kSquares - 1});
      }
    }
  }
  const auto spool = spooled(mesh);
  for (const bool solid : {true, false}) {
    std::string first;
    std::size_t most_slabs = 0;
    // In the last there are fewer triangles than in a block of slices.
    for (const std::uint64_t memory : {1ull << 30, 15ull << 20, 13800ull << 10}) {
      MeshStoreOptions options;
      options.resolution = 70;
      options.solid = solid;
      options.memory_bytes = memory;
      options.source = "ball";
      const std::string path = testing::TempDir() + "gvx_mesh_slabs.gvx";
      const auto built = build_mesh_store(exec::Device::cpu(), *spool, path, options, {});
      ASSERT_TRUE(built.ok()) << built.error().message;
      most_slabs = std::max(most_slabs, built.value().slabs);
      if (first.empty()) {
        first = bytes_of(path);
        EXPECT_EQ(built.value().slabs, 1u);
      }
      EXPECT_TRUE(bytes_of(path) == first) << built.value().slabs << " slabs";
    }
    EXPECT_GT(most_slabs, 9u) << "slices in ten blocks";
  }
}

/// Both in one, each with its own vertices.
io::TriangleMesh together(io::TriangleMesh a, const io::TriangleMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({first + i, first + j, first + k});
  return a;
}

io::TriangleMesh turned_round(io::TriangleMesh mesh) {
  for (io::Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

io::TriangleMesh moved(io::TriangleMesh mesh, Vec3f by) {
  for (Vec3f& v : mesh.vertices) v = v + by;
  return mesh;
}

/// The store of a mesh with so many voxels along its longest side, filled where it is closed.
StoredMesh stored(const MeshSpool& spool, std::int64_t resolution) {
  MeshStoreOptions options;
  options.resolution = resolution;
  options.solid = spool.summary().closed();
  const std::string path = testing::TempDir() + "gvx_mesh_inside.gvx";
  const auto built = build_mesh_store(exec::Device::cpu(), spool, path, options, {});
  GVX_CHECK(built.ok());
  return StoredMesh(path);
}

class MeshInside : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto made = MeshQuery::create(cube()); !made.ok()) GTEST_SKIP() << made.error().message;
  }
};

TEST_F(MeshInside, a_cube_is_solid_however_its_faces_are_repeated_or_wound) {
  io::TriangleMesh one_face_twice = cube();
  one_face_twice.triangles.push_back({2, 1, 0});
  io::TriangleMesh one_face_behind_itself = cube();
  one_face_behind_itself.triangles.push_back({0, 1, 2});
  io::TriangleMesh one_face_turned = cube();
  std::swap(one_face_turned.triangles[5][0], one_face_turned.triangles[5][1]);
  // A vertex in the middle of an edge, which one side has and the other has not: a triangle without an area
  // closes it.
  io::TriangleMesh sliver = cube();
  sliver.vertices.emplace_back(0.5f, 0, 0);
  sliver.triangles[0] = {0, 2, 8};
  sliver.triangles.push_back({8, 2, 1});
  sliver.triangles.push_back({0, 8, 1});
  io::TriangleMesh sliver_turned = sliver;
  sliver_turned.triangles.back() = {8, 0, 1};
  io::TriangleMesh inconsistent_twice = together(one_face_turned, one_face_turned);
  const io::TriangleMesh two_sided = together(cube(), turned_round(cube()));

  struct Case {
    const char* name;
    io::TriangleMesh mesh;
    InsideRule rule;
    std::uint64_t triangles, doubled;
  };
  for (const Case& c :
       {Case{"plain", cube(), InsideRule::winding, 12, 0},
        Case{"inward", turned_round(cube()), InsideRule::winding, 12, 0},
        Case{"pasted twice", together(cube(), cube()), InsideRule::winding, 24, 0},
        Case{"three times", together(together(cube(), cube()), cube()), InsideRule::winding, 36, 0},
        Case{"two-sided", two_sided, InsideRule::parity, 12, 12},
        Case{"one face twice", one_face_twice, InsideRule::winding, 12, 1},
        Case{"one face two-sided", one_face_behind_itself, InsideRule::parity, 12, 1},
        Case{"one face turned", one_face_turned, InsideRule::parity, 12, 0},
        Case{"inconsistent twice", inconsistent_twice, InsideRule::parity, 12, 12},
        Case{"sliver", sliver, InsideRule::winding, 13, 0},
        Case{"sliver twice", together(sliver, sliver), InsideRule::winding, 26, 0},
        Case{"sliver turned", sliver_turned, InsideRule::parity, 13, 0}}) {
    const auto spool = spooled(c.mesh);
    EXPECT_EQ(spool->summary().inside, c.rule) << c.name;
    EXPECT_EQ(spool->summary().triangles, c.triangles) << c.name;
    EXPECT_EQ(spool->summary().doubled, c.doubled) << c.name;
    const StoredMesh voxels = stored(*spool, 32);
    EXPECT_NEAR(voxels.volume(), 1, 1e-6) << c.name;
    EXPECT_EQ(voxels.opaque(), 32768u) << c.name;
    EXPECT_EQ(voxels.opacity({0.5, 0.5, 0.5}), 1) << c.name;
    io::TriangleMesh in_memory = c.mesh;
    const InsideRule rule = settle_inside(in_memory);
    EXPECT_EQ(rule, c.rule) << c.name;
    const auto query = MeshQuery::create(std::move(in_memory), rule).value();
    EXPECT_TRUE(query->inside({0.4f, 0.5f, 0.6f})) << c.name;
    EXPECT_FALSE(query->inside({0.4f, 1.5f, 0.6f})) << c.name;
  }
}

TEST_F(MeshInside, parts_that_overlap_or_touch_are_one_and_cavities_stay) {
  const double ball = 4.0 / 3 * M_PI;
  // Two balls of radius 1 that are d apart share 2 caps of height 1 - d/2.
  const double h = 0.55, shared = 2 * M_PI * h * h / 3 * (3 - h);
  const io::TriangleMesh sphere = sphere_mesh({0, 0, 0}, 1, 4);
  const StoredMesh overlapping = stored(*spooled(together(sphere, moved(sphere, {0.9f, 0, 0}))), 64);
  EXPECT_NEAR(overlapping.volume(), 2 * ball - shared, 0.03);
  // Nothing of the surfaces within is left.
  for (double x = -0.9; x < 1.8; x += 0.01) EXPECT_EQ(overlapping.opacity({x, 0, 0}), 1) << x;
  for (double y = -0.7; y < 0.7; y += 0.01) EXPECT_EQ(overlapping.opacity({0.45, y, 0}), 1) << y;

  const StoredMesh inward = stored(*spooled(turned_round(together(sphere, moved(sphere, {0.9f, 0, 0})))), 64);
  EXPECT_NEAR(inward.volume(), overlapping.volume(), 1e-3);

  const StoredMesh hollow =
      stored(*spooled(together(sphere, turned_round(sphere_mesh({0, 0, 0}, 0.5, 4)))), 64);
  EXPECT_NEAR(hollow.volume(), ball * (1 - 0.125), 0.03);
  EXPECT_EQ(hollow.opacity({0, 0, 0}), 0);
  EXPECT_EQ(hollow.opacity({0.75, 0, 0}), 1);
  const StoredMesh nested = stored(*spooled(together(sphere, sphere_mesh({0, 0, 0}, 0.5, 4))), 64);
  EXPECT_NEAR(nested.volume(), ball, 0.03);
  EXPECT_EQ(nested.opacity({0.5, 0, 0}), 1);

  // Side by side, with a face in common; and overlapping by much less than a voxel.
  for (const float apart : {1.0f, 0.9999f, 0.99f}) {
    const StoredMesh touching = stored(*spooled(together(cube(), moved(cube(), {apart, 0, 0}))), 40);
    EXPECT_NEAR(touching.volume(), 1 + apart, 2e-3) << apart;
    for (double x = 0.1; x < 1.9; x += 0.01)
      EXPECT_EQ(touching.opacity({x, 0.5, 0.5}), 1) << apart << ' ' << x;
  }
}

TEST_F(MeshInside, of_a_mesh_without_one_there_is_a_shell) {
  // A sheet that has a back, and a cube without a face.
  io::TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 0}, {3, 2, 0}};
  EXPECT_FALSE(spooled(sheet)->summary().closed());
  EXPECT_GT(stored(*spooled(sheet), 32).opaque(), 1000u);
  io::TriangleMesh open = cube();
  open.triangles.resize(10);
  EXPECT_FALSE(spooled(open)->summary().closed());
  EXPECT_EQ(stored(*spooled(open), 32).opacity({0.5, 0.5, 0.5}), 0);
}

TEST_F(MeshInside, seams_that_rounding_made_are_closed) {
  // Each triangle with vertices of its own, which differ by some units of their last places.
  io::TriangleMesh mesh = unconnected(sphere_mesh({0, 0, 0}, 1, 3));
  std::mt19937 random(7);
  for (Vec3f& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) {
      v[axis] += 6e-8f * (static_cast<float>(random() % 3) - 1);
    }
  }
  const auto spool = spooled(mesh);
  EXPECT_EQ(spool->summary().inside, InsideRule::winding);
  EXPECT_NEAR(stored(*spool, 48).volume(), 4.0 / 3 * M_PI, 0.05);
  mesh.vertices[0] = 1.001f * mesh.vertices[0];
  EXPECT_FALSE(spooled(mesh)->summary().closed());
}

TEST_F(MeshInside, far_from_0_a_mesh_is_as_it_is_near) {
  const Vec3d origin(500000.125, 5400000.375, 312.5);
  io::TriangleMesh mesh = cube();
  for (Vec3f& v : mesh.vertices) v = 0.1f * v;
  mesh.origin = origin;
  const auto spool = spooled(mesh);
  EXPECT_EQ(spool->summary().triangles, 12u);
  EXPECT_EQ(spool->summary().bounds.minimum, origin);
  const StoredMesh voxels = stored(*spool, 32);
  EXPECT_NEAR(voxels.volume(), 0.001, 1e-8);
  EXPECT_EQ(voxels.opacity(origin + Vec3d(0.05)), 1);
  EXPECT_LT(length(voxels.info().voxel_to_world.origin + Vec3d(3 * 0.1 / 32) - origin), 1e-6);
}

TEST_F(MeshInside, unions_are_the_same_bytes_in_however_many_slabs) {
  const io::TriangleMesh sphere = sphere_mesh({0, 0, 0}, 1, 5);
  const auto spool = spooled(together(sphere, moved(sphere, {0.3f, 0.4f, 0.5f})));
  std::string first;
  for (const std::uint64_t memory : {1ull << 30, 16ull << 20}) {
    MeshStoreOptions options;
    options.resolution = 70;
    options.solid = true;
    options.memory_bytes = memory;
    const std::string path = testing::TempDir() + "gvx_mesh_union.gvx";
    const auto built = build_mesh_store(exec::Device::cpu(), *spool, path, options, {});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_EQ(built.value().slabs > 1, !first.empty());
    if (first.empty()) first = bytes_of(path);
    EXPECT_TRUE(bytes_of(path) == first);
  }
}

}  // namespace
}  // namespace gvx::mesh
