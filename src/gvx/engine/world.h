/// \file
/// World: the objects of a picture. An object is a volume or a surface at a place, shown in a way of its own.
/// Thousands of objects may show one volume: it is in memory once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/engine/surface.h"
#include "gvx/engine/volume.h"
#include "gvx/render/frame/view.h"
#include "gvx/tree/tree_description.h"

namespace gvx::engine {

struct Object {
  std::shared_ptr<Volume> volume;  ///< null where it is a surface
  Affine3 transform;               ///< from the volume's world to the picture's; it may mirror and shear
  render::ObjectLook shown;        ///< mode, transfer functions, clip box..; of a volume
  std::shared_ptr<Surface> surface = {};
};

/// Does not change once it is made: viewers share it.
class World {
 public:
  /// An error, which names the object by its number, if there is none, a volume is missing, or a transform
  /// has no usable inverse.
  static Result<std::shared_ptr<const World>> make(std::vector<Object> objects);

  std::span<const Object> objects() const { return objects_; }
  /// The tree of an object's volume or surface, placed in the picture's world.
  const tree::TreeDescription& tree(std::size_t object) const { return trees_[object]; }
  /// Objects, by their numbers, that are surfaces.
  std::span<const std::size_t> surfaces() const { return surfaces_; }
  bool is_surface(std::size_t object) const { return objects_[object].surface != nullptr; }
  /// The volumes, each once.
  std::span<Volume* const> volumes() const { return volumes_; }

  /// How many of several objects show a greatest, least or mean value.
  std::uint32_t projecting() const { return objects_.size() > 1 ? projecting_ : 0; }

  /// A volume and a way to show it, which some objects have in common.
  struct Kind {
    std::size_t volume = 0;  ///< in volumes()
    std::size_t object = 0;  ///< one that has it
  };
  std::span<const Kind> kinds() const { return kinds_; }
  /// Of a volume.
  std::size_t kind(std::size_t object) const { return kind_of_[object]; }

  /// Can the camera see nothing of an object's box? True is certain.
  bool out_of_sight(std::size_t object, const scene::CameraView& camera) const;

 private:
  void add(Object object);

  std::vector<Object> objects_;
  std::vector<tree::TreeDescription> trees_;  // without histograms and outlines
  std::vector<Volume*> volumes_;
  std::vector<std::size_t> surfaces_;
  std::vector<Kind> kinds_;
  std::vector<std::size_t> kind_of_;
  std::uint32_t projecting_ = 0;
};

}  // namespace gvx::engine
