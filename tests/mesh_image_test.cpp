// Meshes as voxels, seen: against Embree's own hits of the same mesh, near and from afar.

#include <cmath>

#include <gtest/gtest.h>

#include "gvx/mesh/mesh_query.h"
#include "gvx/mesh/mesh_test_support.h"
#include "gvx/mesh/mesh_voxels.h"
#include "gvx/produce/store_producer.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

/// A ball with bumps; no axis or plane is special to it.
io::TriangleMesh bumpy_ball() {
  io::TriangleMesh mesh = mesh::sphere_mesh({0, 0, 0}, 1, 5);
  for (Vec3f& v : mesh.vertices) {
    const float bump = std::sin(5 * v.x + 1) * std::sin(4 * v.y - 2) * std::sin(6 * v.z + 0.5f);
    v = (1 + 0.2f * bump) * v;
  }
  return mesh;
}

struct Seen {
  std::vector<bool> hit;
  Vec3d mean;  ///< of the normals' components, without their signs: both sides are lit
};

/// What lines along x through the pixels' middles meet first. Pixels go along -y and down along -z, as a
/// camera sees that looks along x with z up.
Seen seen_by_embree(const io::TriangleMesh& mesh, std::uint32_t size, double height) {
  const auto query = mesh::MeshQuery::create(mesh).value();
  Seen seen{std::vector<bool>(std::size_t(size) * size), {}};
  std::vector<mesh::MeshQuery::Crossing> crossings;
  for (std::uint32_t j = 0; j < size; ++j) {
    for (std::uint32_t i = 0; i < size; ++i) {
      const double y = (0.5 - (i + 0.5) / size) * height, z = (0.5 - (j + 0.5) / size) * height;
      const Vec3f from(-3, static_cast<float>(y), static_cast<float>(z));
      query->crossings(from, 0, crossings);
      if (crossings.empty()) continue;
      seen.hit[j * size + i] = true;
      const auto at = query->nearest(from + Vec3f(crossings[0].distance, 0, 0), 0.01f).value();
      const auto& t = mesh.triangles[at.triangle];
      const Vec3d a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
      const Vec3d normal = normalize(cross(b - a, c - a));
      for (int axis = 0; axis < 3; ++axis) seen.mean[axis] += std::fabs(normal[axis]);
    }
  }
  return seen;
}

class MeshImage : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(near_and_far, MeshImage, testing::Values(120u, 60u, 24u));

TEST_P(MeshImage, has_the_silhouette_and_the_mean_normal_that_embree_finds) {
  const std::uint32_t size = GetParam();
  const io::TriangleMesh mesh = bumpy_ball();
  if (const auto made = mesh::MeshQuery::create(mesh); !made.ok()) GTEST_SKIP() << made.error().message;
  const double height = 2.6;
  const std::string path = testing::TempDir() + "gvx_mesh_image.gvx";
  const auto spool = mesh::spooled(mesh);
  for (const bool solid : {true, false}) {
    mesh::MeshStoreOptions options;
    options.resolution = 160;
    options.solid = solid;
    const auto built = mesh::build_mesh_store(exec::Device::cpu(), *spool, path, options, {});
    ASSERT_TRUE(built.ok()) << built.error().message;

    render::View view;
    view.width = view.height = size;
    view.camera.eye = {-3, 0, 0};
    view.camera.target = {0, 0, 0};
    view.camera.up = {0, 0, 1};
    view.camera.height_world = height;
    view.opaque_background = false;
    // Light along one axis at a time, and nothing but what surfaces that face it throw back.
    view.lighting.ambient = 0;
    view.lighting.diffuse = 1;
    view.lighting.specular = 0;
    auto engine = engine::Engine::create(
        exec::Device::cpu(), std::make_shared<produce::StoreProducer>(store::StoreReader::open(path).value()),
        {});
    ASSERT_TRUE(engine.ok());
    const auto picture_lit_from = [&](Vec3d towards) {
      view.lighting.light[0] = {scene::LightKind::directional, towards, {1, 1, 1}};
      GVX_CHECK(engine.value()->look(view).ok() && engine.value()->render_exact().ok());
      return engine.value()->picture();
    };
    const Seen seen = seen_by_embree(mesh, size, height);
    const render::Picture first = picture_lit_from({1, 0, 0});
    const auto hit = [&](int i, int j) {
      const auto last = static_cast<int>(size) - 1;
      return seen.hit[static_cast<std::size_t>(std::clamp(j, 0, last)) * size +
                      static_cast<std::size_t>(std::clamp(i, 0, last))];
    };
    // Where all around is hit, so is the pixel; where nothing is, it is not.
    int wrong = 0;
    double covered = 0, hits = 0;
    for (int j = 0; j < static_cast<int>(size); ++j) {
      for (int i = 0; i < static_cast<int>(size); ++i) {
        const float alpha =
            first.rgba[4 * (static_cast<std::size_t>(j) * size + static_cast<std::size_t>(i)) + 3];
        covered += alpha;
        hits += hit(i, j) ? 1 : 0;
        bool all = true, any = false;
        for (int dj = -1; dj <= 1; ++dj) {
          for (int di = -1; di <= 1; ++di) {
            all = all && hit(i + di, j + dj);
            any = any || hit(i + di, j + dj);
          }
        }
        wrong += (all && alpha < 0.5f) || (!any && alpha > 0.5f) ? 1 : 0;
      }
    }
    EXPECT_EQ(wrong, 0) << (solid ? "solid" : "shell");
    EXPECT_NEAR(covered / hits, 1, solid && size > 100 ? 0.02 : 0.06);

    // What light along an axis shows is the normals' component.
    Vec3d mean;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d towards;
      towards[axis] = 1;
      const render::Picture picture = picture_lit_from(towards);
      for (std::size_t p = 0; p < picture.rgba.size(); p += 4) {
        mean[axis] += double(picture.rgba[p]) * double(picture.rgba[p + 3]);
      }
    }
    const double degrees =
        std::acos(std::clamp(dot(normalize(mean), normalize(seen.mean)), -1.0, 1.0)) * 180 / M_PI;
    EXPECT_LT(degrees, size > 100 ? 2 : size > 50 ? 3 : 5) << (solid ? "solid" : "shell");
  }
}

}  // namespace
}  // namespace gvx::tests
