/// \file
/// Scenes of several objects for the tests: analytic fields, each in its own tree and place; how they are
/// rendered; and a brute-force reference that knows nothing but the fields.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "gvx/engine/look.h"
#include "gvx/engine/residency.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/production.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/march_pass.h"

namespace gvx::tests {

/// A field in tree space, with values from 0 to 1.
struct AnalyticField {
  std::function<double(Vec3d)> value;
  double steepest;  ///< no gradient is longer
};

/// One object of a scene. Of its view all but the camera and the size counts.
struct SceneObject {
  AnalyticField field;
  render::View view;
  std::shared_ptr<const produce::Producer> producer;
};

struct ObjectScene {
  std::vector<SceneObject> objects;
  render::View view;  ///< the camera and the size

  /// The view of an object from the scene's camera.
  render::View view_of(const SceneObject& object) const;
};

/// What of a volume is wanted: its voxels, the tree's shape, and how many levels below the root.
struct TreeWanted {
  VoxelType type = VoxelType::f32;
  std::uint32_t n = 2, m = 8, max_level = 2;
};

/// An object of a field, in a tree that is mapped to the world so.
SceneObject object_of(const AnalyticField& field, const Affine3& tree_to_world,
                      const TreeWanted& wanted = {});

/// A soft ball, and waves in a direction.
AnalyticField soft_ball(Vec3d centre, double narrow);
AnalyticField waves_along(Vec3d wave);

/// An object in a random place: turned, sheared, mirrored or not; of a random type, tree, field and function.
/// They lie around the origin, within `spread`.
SceneObject random_object(std::mt19937& random, double spread);
/// So many of these and a camera that sees them.
ObjectScene random_scene(std::uint32_t seed, int objects, double spread);

/// How a scene is rendered.
struct HowRendered {
  exec::Device device = exec::Device::cpu();
  engine::PoolSizes pools = {200, 150};  ///< of each object
  bool one_ray_at_a_time = false;
  double withheld = 0;  ///< share of the bricks that are made but come later
  std::uint32_t seed = 1;
};

/// Objects with what of them is resident.
class ResidentScene {
 public:
  ResidentScene(const ObjectScene& scene, const HowRendered& how);

  /// Renders until no ray lacks anything; the passes that took are in passes().
  render::Picture render_exact();
  std::uint32_t passes() const { return number_; }
  /// A pass over what is resident, for a film of this epoch.
  render::Pass next_pass();
  /// Rays through the first object that are told from another place than the camera's eye, and as wide as one
  /// likes.
  render::Bundle bundle_at(Vec3d origin, ConeShape cones) const;
  /// Where such a ray comes to.
  render::RayState march_ray(const render::Bundle& bundle, const render::BundleRay& ray);
  /// Makes what the rays of the last pass lacked.
  void produce_lacking();
  render::Film& film() { return film_; }

 private:
  struct Resident {
    Resident(const exec::Device& device, const SceneObject& object, const render::View& view,
             engine::PoolSizes pools);
    render::ObjectView view();
    produce::FinishedElement made(const produce::ElementKey& key) const;

    const produce::Producer& producer;
    render::Frame frame;
    engine::Residency residency;
    engine::Look look;
  };

  const ObjectScene& scene_;
  const HowRendered how_;
  std::mt19937 random_;
  std::vector<std::unique_ptr<Resident>> residents_;
  std::vector<render::ObjectView> views_;
  render::Film film_;
  std::uint32_t number_ = 0;
};

/// Every ray in steps of this length through the fields themselves, unlit: extinctions add.
render::Picture render_reference(const ObjectScene& scene, double step_world);

}  // namespace gvx::tests
