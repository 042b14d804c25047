#include "gvx/mesh/surface_store.h"

#include <fstream>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "gvx/mesh/mesh_test_support.h"
#include "gvx/surface/surface_pieces.h"
#include "gvx/surface/surface_reader.h"

namespace gvx::mesh {
namespace {

using surface::Piece;
using surface::SurfaceNode;
using surface::SurfaceReader;

class SurfaceStore : public testing::Test {
 protected:
  void build(const io::TriangleMesh& mesh, std::uint64_t memory = 64 << 20,
             store::Codec codec = store::Codec::zstd) {
    const auto spool = spooled(mesh);
    SurfaceStoreOptions options;
    options.memory_bytes = memory;
    options.source = "test.ply";
    options.codec = codec;
    options.up = UpAxis::y;
    auto built = build_surface_store(*spool, path_, options);
    ASSERT_TRUE(built.ok()) << built.error().message;
    report_ = built.value();
    std::ifstream file(path_, std::ios::binary);
    good_.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  Result<surface::SurfaceVerifyReport> verify_bytes(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), std::streamsize(bytes.size()));
    return surface::verify_surface(path_, {});
  }

  std::string path_ = testing::TempDir() + "gvx_surface_store.gvx";
  SurfaceStoreReport report_;
  std::string good_;
};

TEST_F(SurfaceStore, says_what_was_built) {
  build(sphere_mesh({10, 20, 30}, 2, 5));
  const auto reader = SurfaceReader::open(path_).value();
  const surface::SurfaceInfo& info = reader->info();
  EXPECT_EQ(info.levels, report_.levels);
  EXPECT_EQ(info.triangles, 20u * 1024);
  EXPECT_EQ(info.source, "test.ply");
  EXPECT_EQ(info.up, UpAxis::y);
  const Vec3d low = info.cells_to_world.point(info.bounds.minimum);
  EXPECT_NEAR(low.x, 8, 1e-3);
  EXPECT_NEAR(low.z, 28, 1e-2);
  const auto verified = surface::verify_surface(path_, {}).value();
  EXPECT_EQ(verified.nodes, report_.bricks);
  EXPECT_EQ(verified.samples, report_.samples);
  EXPECT_GE(verified.triangles, info.triangles) << "one that meets several bricks is in all of them";
  EXPECT_LT(verified.triangles, info.triangles * 3 / 2);
  EXPECT_LT(report_.bytes_written, 24 * info.triangles);
}

TEST_F(SurfaceStore, holds_every_triangle_at_its_place) {
  const io::TriangleMesh mesh = sphere_mesh({1, 2, 3}, 1, 3);
  build(mesh);
  const auto reader = SurfaceReader::open(path_).value();
  const std::uint32_t finest = reader->info().levels - 1;
  std::set<std::tuple<long, long, long>> places;  // of corners, in thousandths
  const auto key = [](Vec3d p) {
    return std::tuple(std::lround(p.x * 1000), std::lround(p.y * 1000), std::lround(p.z * 1000));
  };
  for (const Vec3f& vertex : mesh.vertices) {
    for (int i = 0; i < 8; ++i) {  // rounded either way
      const auto shift = [&](int bit) { return (i >> bit & 1) != 0 ? 4e-4 : -4e-4; };
      places.insert(key(Vec3d(vertex) + Vec3d(shift(0), shift(1), shift(2))));
    }
  }
  // Nodes know their places from their parents.
  std::vector<NodeKey> keys = {{}};
  for (std::uint32_t level = 0; level <= finest; ++level) {
    std::vector<NodeKey> next;
    for (std::uint64_t i = 0; i < reader->nodes(level); ++i) {
      const auto page = reader->read_page(level, i / surface::kPageNodes).value();
      const SurfaceNode& node = page[i % surface::kPageNodes];
      for (int octant = 0; octant < 8; ++octant) {
        if ((node.children >> octant & 1) == 0) continue;
        EXPECT_EQ(node.child_at(octant), next.size());
        next.push_back(child(keys[i], 2, octant));
      }
      if (node.triangles == 0) continue;
      EXPECT_EQ(level, finest);
      const auto bytes = reader->read_piece(node, Piece::triangles).value();
      const auto view = surface::triangle_view(node, bytes.data());
      for (std::uint32_t v = 0; v < view.vertices; ++v) {
        const Vec3d cells =
            double(surface::kCells) * corner(keys[i]) + Vec3d(view.place(v)) / double(surface::kCellParts);
        EXPECT_TRUE(places.contains(key(reader->info().cells_to_world.point(cells))));
        const Vec3d out = normalize(reader->info().cells_to_world.point(cells) - Vec3d(1, 2, 3));
        EXPECT_GT(dot(Vec3f(out), surface::normal_of(view.attributes(v))), 0.99f);
      }
    }
    keys = std::move(next);
  }
}

TEST_F(SurfaceStore, large_triangles_are_not_resolved_but_at_the_top) {
  io::TriangleMesh mesh = sphere_mesh({}, 1, 4);
  // A plate beside it, many times as wide as its cells.
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{-3, -3, 1.5f}, {3, -3, 1.5f}, {3, 3, 1.5f}, {-3, 3, 1.5f}});
  mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  build(mesh);
  const auto reader = SurfaceReader::open(path_).value();
  std::uint64_t unresolved = 0, resolved = 0;
  for (std::uint32_t level = 0; level < reader->info().levels; ++level) {
    for (std::uint64_t page = 0; page < surface::pages_of(reader->nodes(level)); ++page) {
      const auto nodes = reader->read_page(level, page).value();
      for (const SurfaceNode& node : nodes) {
        EXPECT_TRUE(level > 0 || node.resolved());
        (node.resolved() ? resolved : unresolved) += 1;
        EXPECT_TRUE(node.resolved() || node.children != 0 || node.triangles > 0);
      }
    }
  }
  EXPECT_GT(unresolved, resolved / 4) << "the plate's";
  EXPECT_GT(resolved, 10u) << "the ball's";
}

TEST_F(SurfaceStore, is_the_same_bytes_for_any_memory) {
  const io::TriangleMesh mesh = sphere_mesh({}, 1, 4);
  build(mesh);
  const std::string plenty = good_;
  build(mesh, 20000);
  EXPECT_TRUE(plenty == good_);
}

TEST_F(SurfaceStore, cut_anywhere_is_an_error_that_names_it) {
  build(sphere_mesh({}, 1, 3));
  for (std::size_t bytes = 0; bytes < good_.size(); bytes += 1 + good_.size() / 97) {
    const auto verified = verify_bytes(good_.substr(0, bytes));
    ASSERT_FALSE(verified.ok());
    EXPECT_NE(verified.error().message.find(path_), std::string::npos);
  }
}

TEST_F(SurfaceStore, one_damaged_byte_is_found) {
  build(sphere_mesh({}, 1, 3));
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    std::string bytes = good_;
    bytes[random() % bytes.size()] ^= static_cast<char>(1 << random() % 8);
    EXPECT_FALSE(verify_bytes(bytes).ok());
  }
  EXPECT_TRUE(verify_bytes(good_).ok());
}

TEST_F(SurfaceStore, bytes_that_are_made_up_do_no_harm_with_their_checksums_mended) {
  build(sphere_mesh({}, 1, 3), 64 << 20, store::Codec::none);
  const auto reader = SurfaceReader::open(path_).value();
  std::mt19937 random(6);
  const auto page = reader->read_page(reader->info().levels - 1, 0).value();
  for (int i = 0; i < 20000; ++i) {
    const SurfaceNode& node = page[random() % page.size()];
    const auto piece = random() % 2 == 0 ? Piece::geometry : Piece::triangles;
    if (surface::piece_bytes(node, piece) == 0) continue;
    auto bytes = reader->read_piece(node, piece).value();
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = std::byte(random());
    if (!surface::check_piece(node, piece, bytes).ok()) continue;
    // What passes can be looked at all over.
    if (piece == Piece::triangles) {
      const auto view = surface::triangle_view(node, bytes.data());
      for (std::uint32_t t = 0; t < view.triangles; ++t) ASSERT_LT(view.vertex(t, int(t % 3)), view.vertices);
    } else {
      const auto view = surface::brick_view(node, bytes.data(), nullptr);
      for (int u = 0; u < surface::kCells; ++u) {
        for (int v = 0; v < surface::kCells; ++v) {
          for (std::uint32_t cells = view.grid.column(u, v); cells != 0; cells &= cells - 1) {
            ASSERT_LT(view.grid.rank(u, v, surface::lowest_bit(cells)), node.samples);
          }
        }
      }
    }
  }
}

TEST_F(SurfaceStore, bounds_of_nodes_hold_triangles_where_there_is_no_sample) {
  io::TriangleMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  build(one);
  const auto reader = SurfaceReader::open(path_).value();
  const auto page = reader->read_page(0, 0).value();
  const Affine3 to_cells = inverse(reader->info().cells_to_world);
  for (const Vec3f& vertex : one.vertices) {
    const Vec3d cells = to_cells.point(Vec3d(vertex));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(cells[axis] + 0.01, page[0].low[axis]);
      EXPECT_LE(cells[axis] - 0.01, page[0].high[axis] + 1);
    }
  }
}

TEST_F(SurfaceStore, one_face_a_hundred_thousand_times_is_sound) {
  io::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles.assign(100000, {0, 1, 2});
  build(mesh);
  const auto verified = surface::verify_surface(path_, {});
  ASSERT_TRUE(verified.ok()) << verified.error().message;
  EXPECT_GE(verified.value().triangles, 1u);
}

TEST_F(SurfaceStore, thin_and_tiny_parts_do_not_get_lost) {
  // A needle that no line meets, far from a ball whose triangles say how large cells are.
  io::TriangleMesh mesh = sphere_mesh({}, 1, 4);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{4, 4, 4}, {4.0001f, 4, 4}, {4, 4.0001f, 4.0001f}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  build(mesh);
  const auto reader = SurfaceReader::open(path_).value();
  const Vec3d cells = inverse(reader->info().cells_to_world).point({4, 4, 4});
  // The whole way down there is a node that holds it.
  std::uint64_t at = 0;
  for (std::uint32_t level = 0; level < reader->info().levels; ++level) {
    const auto page = reader->read_page(level, at / surface::kPageNodes).value();
    const SurfaceNode& node = page[at % surface::kPageNodes];
    if (level + 1 == reader->info().levels) {
      EXPECT_EQ(node.triangles, 1u);
      break;
    }
    const double width = reader->info().cells() / double(1u << (level + 1));
    int octant = 0;
    for (int axis = 0; axis < 3; ++axis) octant |= (static_cast<int>(cells[axis] / width) & 1) << axis;
    ASSERT_NE(node.children >> octant & 1, 0);
    at = node.child_at(octant);
  }
}

}  // namespace
}  // namespace gvx::mesh
