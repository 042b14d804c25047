#include "scene_view.h"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "built_in_scenes.h"
#include "gvx/engine/engine.h"
#include "gvx/render/frame/frame.h"
#include "gvx/scene/camera_path.h"
#include "gvx/scene/framing.h"
#include "scene_functions.h"
#include "visible_bounds.h"

namespace gvx::app {
namespace {

namespace fs = std::filesystem;

/// Behind what is composited, dark enough for haze and light enough for what is in shadow; projections have
/// black, which is their least value.
constexpr Vec3d kBackground{0.13, 0.16, 0.20};

bool is_projection(scene::Mode mode) {
  return mode != scene::Mode::composite && mode != scene::Mode::isosurface;
}

/// What of the modes can be told without a volume.
Status check_mode(const scene::SceneFile& scene, const SceneFlags& flags) {
  const scene::Mode mode = scene.mode.value_or(render::View().mode);
  if (flags.has_isovalue() && mode != scene::Mode::isosurface) {
    return Error{"--isovalue: only mode isosurface has one"};
  }
  GVX_ASSIGN(const auto gradients, flags.functions().gradients());
  if (!gradients.empty() && mode != scene::Mode::composite) {
    return Error{"--gradient-opacity: only mode composite has opacities"};
  }
  return {};
}

bool lacks_isovalue(const scene::SceneFile& scene) {
  return scene.mode == scene::Mode::isosurface && !scene.isovalue;
}

Error no_isovalue(const std::string& more) {
  return Error{"isovalue: mode isosurface needs one (--isovalue)" + more};
}

/// What cameras frame where nothing is known of the volume.
const scene::Framing kAnyFraming{{{0, 0, 0}, {1, 1, 1}}, {}, {}, scene::Stance::z_up, 1};

/// In tree space, what can be seen of a scene that is complete but for its camera.
Result<VisibleBounds> visible_part(const scene::SceneFile& scene, const SceneFlags& flags,
                                   const Scene& opened) {
  const produce::TreeDescription& tree = opened.producer->description();
  const Vec3d corner = tree.extent.minimum, size = tree.extent.maximum - tree.extent.minimum;
  const Box3d all = tree.bounds.value_or(tree.extent);
  const Box3d shown =
      intersect(all, Box3d{corner + scene.clip->minimum * size, corner + scene.clip->maximum * size});
  if (shown.empty()) return VisibleBounds{all, {}};
  // What is made, not stored, tells less than what it will be.
  if (!tree.exact_ranges || is_projection(*scene.mode)) return VisibleBounds{shown, {}};
  scene::SceneFile seen_somehow = scene;
  seen_somehow.camera = scene::CameraParts(scene::Camera());
  GVX_ASSIGN(const render::View view, make_view(seen_somehow, flags, opened));
  GVX_ASSIGN(const auto frame, render::Frame::make(exec::Device::cpu(1), view, tree));
  return visible_bounds(*opened.producer, frame.view().visibility, shown);
}

/// Of a scene that is complete but for its camera.
Result<scene::Framing> framing_of(const scene::SceneFile& scene, const SceneFlags& flags,
                                  const Scene& opened) {
  const produce::TreeDescription& tree = opened.producer->description();
  scene::Framing framing;
  GVX_ASSIGN(const VisibleBounds visible, visible_part(scene, flags, opened));
  framing.box = visible.box;
  framing.points = visible.points;
  framing.box_to_world = tree.tree_to_world;
  framing.stance =
      scene.up_axis ? scene::stance_of(*scene.up_axis, false) : scene::stance_of(tree.up, tree.anatomical);
  framing.aspect = double(*scene.width) / double(*scene.height);
  return framing;
}

/// The camera of a scene and of the flags over it, and what of it was said.
struct StatedCamera {
  scene::Camera camera;
  Vec3d up;                ///< before another was chosen that does not point along the view
  bool has_up = false;     ///< was it given?
  bool has_place = false;  ///< eye and target: the framing does not matter
};

Result<StatedCamera> stated_camera(const scene::SceneFile& scene, const SceneFlags& flags,
                                   const scene::Framing& framing) {
  GVX_ASSIGN(const scene::CameraParts typed, flags.camera());
  const scene::CameraParts parts = typed.laid_over(scene.camera);
  if (parts.up && !(length(*parts.up) > 0)) return Error{"camera: up: expected a direction, found 0,0,0"};
  return StatedCamera{scene::complete_camera(parts, framing),
                      parts.up.value_or(scene::standard_outlook(framing.stance).up), parts.up.has_value(),
                      parts.eye && (parts.target || parts.origin)};
}

/// The camera of a key frame: what it leaves out is that of all of them.
scene::Camera key_camera(const scene::KeyFrameParts& key, const StatedCamera& all) {
  scene::Camera camera = key.camera.over(all.camera);
  if (key.camera.up || all.has_up) return camera;
  camera.up = all.up;
  return scene::with_fitting_up(camera);
}

Status check_view(const scene::Camera& camera) {
  GVX_ASSIGN(const auto view, scene::make_view(camera, 1, 1));
  (void)view;
  return {};
}

/// What of the camera and its path can be told before a volume says what else is to be framed.
Status check_cameras(const scene::SceneFile& scene, const SceneFlags& flags) {
  GVX_ASSIGN(const StatedCamera stated, stated_camera(scene, flags, kAnyFraming));
  GVX_ASSIGN(auto keys, flags.key_frames());
  if (keys.empty()) keys = scene.camera_path;
  if (keys.empty()) return stated.has_place ? check_view(stated.camera) : Status();
  std::vector<scene::KeyFrame> path;
  for (const scene::KeyFrameParts& key : keys) {
    scene::Camera camera = key_camera(key, stated);
    const bool has_place = (key.camera.eye && (key.camera.target || key.camera.origin)) || stated.has_place;
    if (!has_place) {
      // Any place that is a view will do.
      camera.eye = {1, 0, 0};
      camera.target = {0, 0, 0};
      camera.up = {0, 0, 1};
    }
    path.push_back({key.frame, camera});
  }
  GVX_ASSIGN(const auto checked, scene::CameraPath::create(std::move(path)));
  (void)checked;
  return {};
}

/// The last step of complete().
Status complete_cameras(scene::SceneFile& scene, const SceneFlags& flags, const Scene& opened) {
  GVX_ASSIGN(const scene::Framing framing, framing_of(scene, flags, opened));
  GVX_ASSIGN(const StatedCamera stated, stated_camera(scene, flags, framing));
  GVX_ASSIGN(const auto key_frames, flags.key_frames());
  if (!key_frames.empty()) scene.camera_path = key_frames;
  for (scene::KeyFrameParts& key : scene.camera_path)
    key.camera = scene::CameraParts(key_camera(key, stated));
  if (scene.camera_path.empty()) GVX_TRY(check_view(stated.camera));
  scene.camera = scene::CameraParts(stated.camera);
  return {};
}

template <typename Rename>
void rename_files(scene::SceneFile& scene, Rename rename) {
  if (scene.volume) {
    const std::size_t file = file_position(*scene.volume);
    scene.volume = scene.volume->substr(0, file) + rename(scene.volume->substr(file));
  }
  for (scene::FunctionParts& function : scene.functions) {
    if (!function.from.empty() && !is_preset(function.from)) function.from = rename(function.from);
  }
  if (scene.labels && !scene.labels->table.empty()) scene.labels->table = rename(scene.labels->table);
}

/// Of what is no file: addresses, pipes.
bool has_no_place(const std::string& name) {
  return name == "-" || name.find("://") != std::string::npos;
}

}  // namespace

io::VolumeOptions volume_options(const scene::SceneFile& scene) {
  io::VolumeOptions options;
  options.raw.dimensions = scene.raw.dimensions;
  if (scene.raw.type) options.raw.type = io::parse_sample_type(*scene.raw.type);
  options.raw.big_endian = scene.raw.big_endian;
  options.raw.offset = scene.raw.offset;
  options.raw.spacing = scene.raw.spacing;
  options.raw.components = scene.raw.components;
  options.series = scene.series;
  options.time = scene.time;
  if (scene.labels) options.labels = scene.labels->enabled;
  options.even_slices = scene.even_slices.value_or(false);
  return options;
}

Result<scene::SceneFile> complete(scene::SceneFile scene, const SceneFlags& flags, const Scene& opened) {
  const produce::TreeDescription& tree = opened.producer->description();
  const render::View standard;
  if (!scene.width) scene.width = standard.width;
  if (!scene.height) scene.height = standard.height;
  if (!scene.antialias) scene.antialias = standard.antialias;
  if (!scene.mode) scene.mode = standard.mode;
  if (!scene.classification) scene.classification = standard.classification;
  GVX_TRY(check_mode(scene, flags));
  if (lacks_isovalue(scene)) {
    const scene::ValueStatistics values = value_statistics(tree, 0);
    std::ostringstream range;  // to_string would make 0 of small ones
    range << values.minimum << " to " << values.maximum;
    return no_isovalue("; the volume's values are from " + range.str());
  }
  GVX_ASSIGN(scene.functions, complete_functions(scene, flags.functions(), opened));
  scene.lighting = scene::LightingParts(scene.lighting.over(standard.lighting));
  if (!scene.clip) scene.clip = standard.clip;
  if (!scene.background) scene.background = is_projection(*scene.mode) ? Vec3d() : kBackground;
  if (!scene.transparent) scene.transparent = !standard.opaque_background;
  if (!scene.samples) scene.samples = standard.samples_per_voxel;
  if (!scene.detail) scene.detail = standard.detail;
  if (!scene.finest) scene.finest = !standard.level_of_detail;
  GVX_TRY(complete_cameras(scene, flags, opened));
  return scene;
}

Status check_before_opening(const scene::SceneFile& scene, const SceneFlags& flags) {
  GVX_TRY(check_mode(scene, flags));
  GVX_TRY(check_function_files(scene, flags.functions()));
  return check_cameras(scene, flags);
}

Status check_before_building(const scene::SceneFile& scene, const SceneFlags& flags,
                             const VoxelFormat& format) {
  if (lacks_isovalue(scene)) return no_isovalue("");
  GVX_TRY(check_functions(scene, flags.functions(), format));
  render::View view;
  view.mode = scene.mode.value_or(view.mode);
  view.classification = scene.classification.value_or(view.classification);
  view.lighting = scene.lighting.over(view.lighting);
  view.functions = {{{{0, {}}}, {{0, 0}}}};
  tree::TreeDescription tree;
  tree.format = format;
  GVX_ASSIGN(const auto frame, render::Frame::make(exec::Device::cpu(1), view, tree));
  (void)frame;
  return {};
}

Result<render::View> make_view(const scene::SceneFile& scene, const SceneFlags& flags, const Scene& opened) {
  render::View view;
  view.width = *scene.width;
  view.height = *scene.height;
  view.antialias = *scene.antialias;
  view.camera = scene.camera.over({});
  view.mode = *scene.mode;
  view.isovalue = scene.isovalue.value_or(0);
  view.classification = *scene.classification;
  GVX_ASSIGN(view.functions, open_functions(scene, flags.functions(), opened));
  view.lighting = scene.lighting.over(view.lighting);
  view.clip = *scene.clip;
  view.background = Vec3f(*scene.background);
  view.opaque_background = !*scene.transparent;
  view.samples_per_voxel = *scene.samples;
  view.detail = *scene.detail;
  view.level_of_detail = !*scene.finest;
  view.noise = opened.noise;
  return view;
}

void resolve_names(scene::SceneFile& scene, const std::string& scene_path) {
  const fs::path folder = fs::path(scene_path).parent_path();
  rename_files(scene, [&](const std::string& name) {
    const fs::path here = folder / name;
    std::error_code ignored;
    const bool built_in = name.find_first_of("./") == std::string::npos && !fs::exists(here, ignored);
    return built_in || has_no_place(name) ? name : here.string();
  });
}

void relate_names(scene::SceneFile& scene, const std::string& scene_path) {
  std::error_code error;
  const fs::path folder = fs::absolute(scene_path, error).parent_path();
  rename_files(scene, [&](const std::string& name) {
    if (has_no_place(name) || !fs::exists(name, error)) return name;
    const fs::path there = fs::proximate(name, folder, error);
    return error ? fs::absolute(name).string() : there.string();
  });
}

}  // namespace gvx::app
