#include "built_in_scenes.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_distance.h"
#include "gvx/mesh/mesh_query.h"
#include "gvx/produce/coverage.h"
#include "gvx/produce/deeper_producer.h"
#include "gvx/produce/field_kernels.h"
#include "gvx/produce/field_producer.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/produce/sponge_producer.h"
#include "gvx/produce/terrain.h"
#include "gvx/scene/transfer_presets.h"

namespace gvx::app {
namespace {

using scene::GenerateParts;

/// Lays a part over a value, and takes it out: what is left no scene has taken.
template <typename Value, typename Part>
void take(Value& value, std::optional<Part>& part) {
  if (part) value = static_cast<Value>(*part);
  part.reset();
}

void take_noise(FractalNoise& noise, GenerateParts& parts) {
  take(noise.octaves, parts.octaves);
  take(noise.wavelength, parts.wavelength);
  take(noise.gain, parts.gain);
  take(noise.seed, parts.seed);
}

void take_levels(produce::TreeDescription& tree, GenerateParts& parts) {
  std::uint32_t levels = tree.max_level + 1;
  take(levels, parts.levels);
  tree.max_level = levels - 1;
}

/// Densities from 0 to 1 in bytes.
produce::TreeDescription density_tree(std::uint32_t m, std::uint32_t max_level) {
  produce::TreeDescription tree;
  tree.m = m;
  tree.max_level = max_level;
  tree.scale = 1.0 / 255;
  return tree;
}

/// Example 4 of the 2008 report: 2048^3 voxels in bricks of 32^3. Noise has six octaves unless `parts` says
/// otherwise.
struct CloudScene {
  produce::HypertextureOptions options;
  produce::TreeDescription tree = density_tree(32, 6);

  explicit CloudScene(GenerateParts& parts) {
    options.thickness = 0.1;
    options.strength = 1.1;
    options.noise = {.octaves = 6, .wavelength = 0.13, .gain = 0.55, .seed = 5};
    take_noise(options.noise, parts);
    take(options.strength, parts.strength);
    take(options.thickness, parts.thickness);
    take_levels(tree, parts);
  }
};

/// Of balls.
Scene cloud(const exec::Device& device, GenerateParts& parts) {
  const CloudScene cloud(parts);
  if (device.kind() == exec::DeviceKind::cuda) {
    return {produce::make_balls_producer(device, cloud.tree, produce::cumulus_balls(4), cloud.options),
            "cloud"};
  }
  auto balls = std::make_shared<produce::BallsField>(produce::cumulus_balls(4));
  return {std::make_shared<produce::FieldProducer>(
              cloud.tree, std::make_shared<produce::HypertextureField>(std::move(balls), cloud.options)),
          "cloud"};
}

Scene terrain(const exec::Device& device, GenerateParts& parts) {
  produce::TerrainOptions options;
  take_noise(options.noise, parts);
  take(options.relief, parts.strength);
  produce::TreeDescription tree = density_tree(16, 12);
  take_levels(tree, parts);
  if (device.kind() == exec::DeviceKind::cuda) {
    return {produce::make_terrain_producer(device, tree, options), "solid"};
  }
  return {std::make_shared<produce::FieldProducer>(tree, std::make_shared<produce::TerrainField>(options)),
          "solid"};
}

/// A mesh in the cube, the box of which is the extent, and what its distances are found with.
struct MeshScene {
  std::shared_ptr<const mesh::MeshQuery> query;
  produce::TreeDescription tree;
};

Result<MeshScene> open_mesh(const std::string& path, double margin, produce::TreeDescription tree) {
  GVX_ASSIGN(io::TriangleMesh mesh, io::read_mesh(path));
  tree.up = io::mesh_up(path, mesh.bounds()).axis;
  mesh::PlacedMesh placed = mesh::PlacedMesh::in_cube(std::move(mesh), margin);
  tree.tree_to_world = placed.tree_to_world;
  tree.extent = placed.extent;
  const mesh::InsideRule rule = mesh::settle_inside(placed.mesh);
  GVX_ASSIGN(std::shared_ptr<const mesh::MeshQuery> query,
             mesh::MeshQuery::create(std::move(placed.mesh), rule));
  return MeshScene{std::move(query), tree};
}

/// The same for bricks of distances that are no farther from 0 than `band`.
Result<MeshScene> open_mesh_for_distances(const std::string& path, double band,
                                          const produce::TreeDescription& tree) {
  GVX_ASSIGN(MeshScene mesh, open_mesh(path, 0.1, tree));
  mesh.tree.format.type = VoxelType::u16;
  mesh.tree.scale = 2 * band / 65535;
  mesh.tree.offset = -band;
  return mesh;
}

/// Of a mesh, as the report has it.
Result<Scene> cloud_of_mesh(const std::string& path, GenerateParts& parts) {
  const CloudScene cloud(parts);
  const double reach = produce::HypertextureField::reach(cloud.options, 1.0 / cloud.tree.m);
  GVX_ASSIGN(const MeshScene mesh, open_mesh(path, 0.2, cloud.tree));
  auto distance = std::make_shared<produce::SparseField>(
      std::make_shared<mesh::MeshDistanceField>(mesh.query, reach), cloud.options.thickness);
  auto density = std::make_shared<produce::HypertextureField>(std::move(distance), cloud.options);
  return Scene{std::make_shared<produce::FieldProducer>(mesh.tree, std::move(density)), "cloud"};
}

const char* preset_of(produce::HypertextureKind kind) {
  return kind == produce::HypertextureKind::blurred ? "cloud" : "solid";
}

/// Has distances shown as the densities are that HypertextureField makes of them, across a shell this wide.
Status show_distances(const produce::HypertextureOptions& options, double width, Scene& scene) {
  GVX_ASSIGN(const scene::TransferFunction densities,
             scene::preset(preset_of(options.kind), {.minimum = 0, .maximum = 1}));
  constexpr int kPoints = 32;
  for (int i = 0; i <= kPoints; ++i) {
    const double from_inside = static_cast<double>(i) / kPoints, distance = (from_inside - 0.5) * width;
    const double density = produce::shaped(options.kind, 1 - from_inside);
    scene.colors.push_back({distance, densities.color(density)});
    scene.opacities.push_back({distance, densities.opacity(density)});
  }
  return {};
}

/// Example 3 of the report with bricks of distances, as coarse as the shell is thick: rays make densities of
/// them, and add noise where it moves the surface.
Result<Scene> hypertexture_in_march(const std::string& path, const produce::HypertextureOptions& options,
                                    std::uint32_t levels) {
  const double finest = 1 / std::ldexp(16.0, static_cast<int>(levels) - 1);
  const double width = produce::coverage_width(options.shell(), finest);
  // Four voxels across a shell; of a surface, which distances know between voxels, one of four of its own.
  const double coarsest = options.shell() > 0 ? width / 4 : 4 * finest;
  const double needed = std::max(std::ceil(std::log2(1 / coarsest / 16)), 0.0);
  // Coarse voxels from which what is seen is mixed must not be cut off.
  const double band = options.shift() * options.noise.most() + std::max(width, 0.05);
  produce::TreeDescription tree = density_tree(16, std::min(static_cast<std::uint32_t>(needed), levels - 1));
  GVX_ASSIGN(const MeshScene mesh, open_mesh_for_distances(path, band, tree));
  AddedNoise noise{.noise = options.noise, .strength = options.shift() / mesh.tree.scale, .fades = {}};
  if (options.shift() == 0) noise.noise.octaves = 0;
  auto bricks = std::make_shared<produce::FieldProducer>(
      mesh.tree, std::make_shared<mesh::MeshDistanceField>(mesh.query, band));
  GVX_ASSIGN(auto deeper, produce::DeeperProducer::create(std::move(bricks), levels - 1 - tree.max_level));
  Scene scene{std::move(deeper), "inside", noise};
  GVX_TRY(show_distances(options, width, scene));
  return scene;
}

/// Example 3 of the report: bricks of 16.
Result<Scene> hypertexture(const std::string& path, produce::HypertextureKind kind, GenerateParts& parts) {
  produce::HypertextureOptions options;
  options.kind = kind;
  if (kind == produce::HypertextureKind::hypertexture) options.thickness = 0.03;
  options.noise = {.octaves = 20, .wavelength = 0.05, .gain = 0.55, .seed = 3};
  produce::TreeDescription tree = density_tree(16, 8);
  take_noise(options.noise, parts);
  take(options.strength, parts.strength);
  take(options.thickness, parts.thickness);
  take_levels(tree, parts);
  if (kind != produce::HypertextureKind::solid_noise) {  // which multiplies
    bool in_march = false;
    take(in_march, parts.in_march);
    if (in_march) return hypertexture_in_march(path, options, tree.max_level + 1);
  }
  // As wide as the root's voxels make the shell.
  const double reach = produce::HypertextureField::reach(options, 1.0 / 16);
  GVX_ASSIGN(const MeshScene mesh, open_mesh(path, 0.1, tree));
  std::shared_ptr<const produce::Field> distance =
      std::make_shared<mesh::MeshDistanceField>(mesh.query, reach);
  const bool shell =
      kind != produce::HypertextureKind::pseudo_mesh && kind != produce::HypertextureKind::solid_noise;
  if (shell) distance = std::make_shared<produce::SparseField>(std::move(distance), options.thickness);
  return Scene{std::make_shared<produce::FieldProducer>(
                   mesh.tree, std::make_shared<produce::HypertextureField>(std::move(distance), options)),
               preset_of(kind)};
}

/// Distances in the mesh's own unit, below 0 inside, no farther from 0 than the thickness.
Result<Scene> distance(const std::string& path, bool by_axes, GenerateParts& parts) {
  double band = 0.05;
  take(band, parts.thickness);
  produce::TreeDescription tree = density_tree(16, 7);
  take_levels(tree, parts);
  GVX_ASSIGN(const MeshScene mesh, open_mesh_for_distances(path, band, tree));
  std::shared_ptr<const produce::Field> field;
  if (by_axes) {
    field = std::make_shared<mesh::AxisDistanceField>(mesh.query, band);
  } else {
    field = std::make_shared<mesh::MeshDistanceField>(mesh.query, band);
  }
  return Scene{std::make_shared<produce::FieldProducer>(mesh.tree, std::move(field)), "inside"};
}

Result<std::optional<Scene>> open_of_mesh(const std::string& kind, const std::string& path,
                                          GenerateParts& parts) {
  const auto some = [](Result<Scene> scene) -> Result<std::optional<Scene>> {
    if (!scene.ok()) return scene.error();
    return std::optional(std::move(scene).value());
  };
  if (kind == "cloud") return some(cloud_of_mesh(path, parts));
  if (kind == "distance") return some(distance(path, false, parts));
  if (kind == "axis-distance") return some(distance(path, true, parts));
  for (std::size_t i = 0; i < produce::kHypertextureNames.size(); ++i) {
    if (kind == produce::kHypertextureNames[i]) {
      return some(hypertexture(path, static_cast<produce::HypertextureKind>(i), parts));
    }
  }
  return std::optional<Scene>();
}

}  // namespace

std::size_t file_position(const std::string& scene) {
  std::vector<std::string> kinds = {"repeat", "amplify", "cloud", "distance", "axis-distance"};
  kinds.insert(kinds.end(), produce::kHypertextureNames.begin(), produce::kHypertextureNames.end());
  std::size_t begin = 0;
  bool counted = false;  // a number may follow
  while (true) {
    const std::size_t colon = scene.find(':', begin);
    if (colon == std::string::npos) return begin;
    const std::string word = scene.substr(begin, colon - begin);
    const bool number = counted && !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
    if (!number && std::find(kinds.begin(), kinds.end(), word) == kinds.end()) return begin;
    counted = word == "repeat";
    begin = colon + 1;
  }
}

Result<std::optional<Scene>> open_built_in_scene(const exec::Device& device, const std::string& name,
                                                 GenerateParts& parts) {
  using Nodes = produce::SpongeProducer::Nodes;
  for (const auto& [sponge, nodes] :
       {std::pair{"sponge", Nodes::shared}, std::pair{"stored-sponge", Nodes::stored}}) {
    if (name == sponge) {
      return std::optional(Scene{std::make_shared<produce::SpongeProducer>(16, nodes), "solid"});
    }
  }
  if (name == "cloud") return std::optional(cloud(device, parts));
  if (name == "terrain") return std::optional(terrain(device, parts));
  const std::size_t colon = name.find(':');
  if (colon == std::string::npos) return std::optional<Scene>();
  return open_of_mesh(name.substr(0, colon), name.substr(colon + 1), parts);
}

}  // namespace gvx::app
