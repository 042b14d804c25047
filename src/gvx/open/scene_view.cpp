#include "gvx/open/scene_view.h"

#include <sstream>
#include <string>

#include "gvx/open/functions.h"

namespace gvx::open {
namespace {

/// Behind what is composited, dark enough for haze and light enough for what is in shadow; projections have
/// black, which is their least value.
constexpr Vec3d kBackground{0.13, 0.16, 0.20};

/// What a view calls by the opposite name.
template <typename Bool>
struct Opposite {
  Bool& of;

  operator bool() const { return !of; }
  void operator=(bool value) const { of = !value; }
};
template <typename Bool>
Opposite(Bool&) -> Opposite<Bool>;

/// Calls `tie` with each field of a scene that a view has as it is, and with the view's.
template <typename Scene, typename View, typename Tie>
void tie_fields(Scene& scene, View& view, Tie tie) {
  tie(scene.width, view.width);
  tie(scene.height, view.height);
  tie(scene.antialias, view.antialias);
  tie(scene.mode, view.mode);
  tie(scene.classification, view.classification);
  tie(scene.clip, view.clip);
  tie(scene.transparent, Opposite{view.opaque_background});
  tie(scene.samples, view.samples_per_voxel);
  tie(scene.detail, view.detail);
  tie(scene.finest, Opposite{view.level_of_detail});
}

}  // namespace

Status check_isovalue(const scene::ObjectParts& scene, const FieldNaming& naming,
                      const std::string& volume_values) {
  if (scene.mode != scene::Mode::isosurface || scene.isovalue) return {};
  return Error{"isovalue: mode isosurface needs one" + naming.advice(" (--isovalue)", "") + volume_values};
}

Status complete_look(scene::SceneFile& scene, const OpenVolume& volume, const FieldNaming& naming) {
  render::View standard;
  // Volumes are seen by cones; a surface is seen by single rays, which leave steps at its edges.
  if (volume.producer->description().surface) standard.antialias = 2;
  tie_fields(scene, standard, [](auto& field, const auto& of_view) {
    if (!field) field = of_view;
  });
  const scene::ValueStatistics values = value_statistics(volume.producer->description(), 0);
  std::ostringstream range;  // to_string would make 0 of small ones
  range << "; the volume's values are from " << values.minimum << " to " << values.maximum;
  GVX_TRY(check_isovalue(scene, naming, range.str()));
  GVX_ASSIGN(scene.functions, complete_functions(scene, volume, naming));
  scene.lighting = scene::LightingParts(scene.lighting.over(standard.lighting));
  if (!scene.background) scene.background = scene::projects(*scene.mode) ? Vec3d() : kBackground;
  return {};
}

Result<render::View> make_view(const scene::SceneFile& scene, const OpenVolume& volume,
                               const FieldNaming& naming) {
  render::View view;
  tie_fields(scene, view, [](const auto& field, auto&& of_view) { of_view = *field; });
  view.camera = scene.camera.over({});
  view.isovalue = scene.isovalue.value_or(0);
  GVX_ASSIGN(view.functions, open_functions(scene, volume, naming));
  view.lighting = scene.lighting.over(view.lighting);
  view.background = Vec3f(*scene.background);
  view.noise = volume.noise;
  return view;
}

}  // namespace gvx::open
