#include "built_in_scenes.h"

#include <memory>

#include "gvx/io/mesh.h"
#include "gvx/produce/field_producer.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/produce/mesh_distance.h"
#include "gvx/produce/mesh_query.h"
#include "gvx/produce/sponge_producer.h"
#include "gvx/produce/terrain.h"

namespace gvx::app {
namespace {

/// Densities from 0 to 1 in bytes.
produce::TreeDescription density_tree(std::uint32_t m, std::uint32_t max_level) {
  produce::TreeDescription tree;
  tree.m = m;
  tree.max_level = max_level;
  tree.scale = 1.0 / 255;
  return tree;
}

/// Example 4 of the 2008 report: bricks of 32, five octaves, 2048^3.
Scene cloud() {
  produce::HypertextureOptions options;
  options.thickness = 0.1;
  options.strength = 1.1;
  options.noise = {.octaves = 6, .wavelength = 0.13, .gain = 0.55, .seed = 5};
  auto balls = std::make_shared<produce::BallsField>(produce::cumulus_balls(4));
  return {std::make_shared<produce::FieldProducer>(
              density_tree(32, 6), std::make_shared<produce::HypertextureField>(std::move(balls), options)),
          "cloud"};
}

Scene terrain() {
  return {std::make_shared<produce::FieldProducer>(
              density_tree(16, 12), std::make_shared<produce::TerrainField>(produce::TerrainOptions{})),
          "solid"};
}

/// A mesh in the cube, the box of which is the extent, and what its distances are found with.
struct MeshScene {
  std::shared_ptr<const produce::MeshQuery> query;
  produce::TreeDescription tree;
};

Result<MeshScene> open_mesh(const std::string& path, double margin, produce::TreeDescription tree) {
  GVX_ASSIGN(io::TriangleMesh mesh, io::read_mesh(path));
  produce::PlacedMesh placed = produce::PlacedMesh::in_cube(std::move(mesh), margin);
  tree.tree_to_world = placed.tree_to_world;
  tree.extent = placed.extent;
  GVX_ASSIGN(std::shared_ptr<const produce::MeshQuery> query,
             produce::MeshQuery::create(std::move(placed.mesh)));
  return MeshScene{std::move(query), tree};
}

/// Example 3 of the report: bricks of 16.
Result<Scene> hypertexture(const std::string& path, produce::HypertextureKind kind) {
  produce::HypertextureOptions options;
  options.kind = kind;
  if (kind == produce::HypertextureKind::hypertexture) options.thickness = 0.03;
  options.noise = {.octaves = 20, .wavelength = 0.05, .gain = 0.55, .seed = 3};
  constexpr std::uint32_t kLevels = 8;
  const produce::TreeDescription tree = density_tree(16, kLevels);
  // As wide as the coarsest voxels' shell, and no wider than the cube's margin lets be seen.
  const double reach = produce::HypertextureField::reach(options, 1.0 / 16);
  GVX_ASSIGN(const MeshScene mesh, open_mesh(path, 0.1, tree));
  auto distance = std::make_shared<produce::MeshDistanceField>(mesh.query, reach);
  return Scene{std::make_shared<produce::FieldProducer>(
                   mesh.tree, std::make_shared<produce::HypertextureField>(std::move(distance), options)),
               kind == produce::HypertextureKind::blurred ? "cloud" : "solid"};
}

/// Distances in the mesh's own unit, below 0 inside, within a tenth of the cube.
Result<Scene> distance(const std::string& path, bool by_axes) {
  constexpr double kBand = 0.1;
  GVX_ASSIGN(MeshScene mesh, open_mesh(path, kBand, density_tree(16, 7)));
  mesh.tree.format.type = VoxelType::u16;
  mesh.tree.scale = 2 * kBand / 65535;
  mesh.tree.offset = -kBand;
  std::shared_ptr<const produce::Field> field;
  if (by_axes) {
    field = std::make_shared<produce::AxisDistanceField>(mesh.query, kBand);
  } else {
    field = std::make_shared<produce::MeshDistanceField>(mesh.query, kBand);
  }
  return Scene{std::make_shared<produce::FieldProducer>(mesh.tree, std::move(field)), "inside"};
}

Result<std::optional<Scene>> open_of_mesh(const std::string& kind, const std::string& path) {
  const auto some = [](Result<Scene> scene) -> Result<std::optional<Scene>> {
    if (!scene.ok()) return scene.error();
    return std::optional(std::move(scene).value());
  };
  if (kind == "distance") return some(distance(path, false));
  if (kind == "axis-distance") return some(distance(path, true));
  for (std::size_t i = 0; i < produce::kHypertextureNames.size(); ++i) {
    if (kind == produce::kHypertextureNames[i]) {
      return some(hypertexture(path, static_cast<produce::HypertextureKind>(i)));
    }
  }
  return std::optional<Scene>();
}

}  // namespace

Result<std::optional<Scene>> open_built_in_scene(const std::string& name) {
  if (name == "sponge") return std::optional(Scene{std::make_shared<produce::SpongeProducer>(), "solid"});
  if (name == "cloud") return std::optional(cloud());
  if (name == "terrain") return std::optional(terrain());
  const std::size_t colon = name.find(':');
  if (colon == std::string::npos) return std::optional<Scene>();
  return open_of_mesh(name.substr(0, colon), name.substr(colon + 1));
}

}  // namespace gvx::app
