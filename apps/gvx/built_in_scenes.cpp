#include "built_in_scenes.h"

#include <memory>

#include "gvx/produce/field_producer.h"
#include "gvx/produce/hypertexture.h"
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

}  // namespace

Result<std::optional<Scene>> open_built_in_scene(const std::string& name) {
  if (name == "sponge") return std::optional(Scene{std::make_shared<produce::SpongeProducer>(), "solid"});
  if (name == "cloud") return std::optional(cloud());
  if (name == "terrain") return std::optional(terrain());
  return std::optional<Scene>();
}

}  // namespace gvx::app
