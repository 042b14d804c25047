// gvx render SCENE -o OUT.png: a picture of a scene.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "commands.h"
#include "field_flags.h"
#include "frame_files.h"
#include "gvx/engine/viewer.h"
#include "gvx/io/file_commit.h"
#include "gvx/io/image.h"
#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_proxy.h"
#include "gvx/open/file_names.h"
#include "gvx/open/functions.h"
#include "gvx/open/nothing_seen.h"
#include "gvx/open/open_scene.h"
#include "gvx/scene/camera_path.h"
#include "gvx/scene/scene_fields.h"
#include "gvx/scene/scene_file.h"
#include "mesh_flags.h"
#include "messages.h"
#include "outputs.h"
#include "progress.h"
#include "scene_flags.h"
#include "units.h"
#include "work_bar.h"

namespace gvx::app {
namespace {

struct Options {
  std::string scene, output, budget, frames, memory = "512M", device = "cpu", stats, save_scene, proxy,
                                             overlay = "none";
  int threads = 0, budget_frames = 1;
  double zoom = 0;  // 0: an orbit
  bool exact = false, quiet = false;
  SceneFlags flags;
};

Result<exec::Device> open_device(const Options& o) {
  if (o.device == "cuda") return exec::Device::cuda();
  return exec::Device::cpu(o.threads);
}

/// The mesh of --proxy; none where it names none.
Result<std::optional<io::TriangleMesh>> read_proxy(const Options& o) {
  if (o.proxy.empty() || o.proxy == "nodes") return std::optional<io::TriangleMesh>();
  auto mesh = io::read_mesh(o.proxy);
  if (!mesh.ok()) return Error{"--proxy " + mesh.error().message};
  return std::optional(std::move(mesh).value());
}

/// Of that mesh, or around the nodes that can be seen.
Result<std::shared_ptr<const scene::Proxy>> make_proxy(std::optional<io::TriangleMesh> mesh,
                                                       const open::OpenScene& opened) {
  const produce::Producer& producer = *opened.volume.producer;
  const produce::TreeDescription& tree = producer.description();
  if (mesh) return mesh::MeshProxy::create(std::move(*mesh), tree);
  // What no function shows and no noise can make it show.
  GVX_ASSIGN(const auto frame, render::Frame::make(exec::Device::cpu(1), opened.view, tree));
  const scene::Visibility visibility = frame.view().visibility;
  const std::uint32_t level = std::min(tree.max_level, tree.n == 2 ? 5u : 3u);
  return mesh::MeshProxy::around_nodes(producer, level,
                                       [&](const ChannelRanges& ranges) { return visibility.hides(ranges); });
}

/// An error where the volume is none that flags of raw files say anything of.
Status check_takes_raw(const std::string& volume) {
  const std::string file = volume.substr(open::file_position(volume));
  if (io::is_mesh_name(file)) return VolumeFlags::refuse(file);
  std::error_code error;
  if (file == "-") return {};
  if (!std::filesystem::exists(file, error)) {
    const bool made = file.find_first_of("./") == std::string::npos;
    return made ? Status(VolumeFlags::refuse(file, "a scene that is made")) : Status();
  }
  GVX_ASSIGN(const bool store, open::is_store(file));
  return store ? Status(VolumeFlags::refuse(file, "a store")) : Status();
}

/// What the command line says: a scene file or a volume, and flags.
Result<scene::SceneFile> read_command(const Options& o) {
  scene::SceneFile scene;
  if (o.scene.ends_with(".json")) {
    GVX_ASSIGN(scene, scene::read_scene(o.scene));
    open::resolve_names(scene, o.scene);
  } else if (o.flags.has_volume()) {
    return Error{"--volume: goes with a scene file (.json); " + o.scene + " is a volume itself"};
  } else {
    scene.volume = o.scene;
  }
  GVX_TRY(o.flags.apply(scene));
  if (!scene.volume && scene.objects.empty())
    return Error{o.scene + ": the scene names no volume; expected the field \"volume\", or --volume"};
  if (o.flags.has_raw() && scene.volume) GVX_TRY(check_takes_raw(*scene.volume));
  // Flags obey the limits that a file's fields obey.
  scene::SceneFile checked;
  const Status limits = scene::read_over(scene::to_document(scene), checked);
  if (!limits.ok()) return in_flag_of_field(limits.error());
  return scene;
}

/// Every file that is read: the scene file, if there is one, and what it and the flags name.
std::vector<std::string> input_files(const Options& o, const scene::SceneFile& scene) {
  std::vector<std::string> files = open::files_of_scene(scene);
  files.push_back(o.scene);
  if (o.proxy.empty()) return files;
  const std::vector<std::string> proxy = open::files_of(o.proxy, {});
  files.insert(files.end(), proxy.begin(), proxy.end());
  return files;
}

/// Every file that is to be written, if it can be; and, of pictures, if they can be of that size and format.
Status check_output_files(const Options& o, const scene::SceneFile& scene,
                          const std::optional<FrameRange>& frames) {
  std::vector<Output> outputs;
  if (!o.stats.empty()) outputs.push_back({"--stats", o.stats});
  if (!o.save_scene.empty()) outputs.push_back({"--save-scene", o.save_scene});
  if (frames) {
    for (int frame = frames->first; frame <= frames->last; ++frame) {
      outputs.push_back({"-o", frame_file(o.output, frame), frame > frames->first});
    }
  } else {
    outputs.push_back({"-o", o.output});
  }
  GVX_TRY(check_outputs(outputs, [&] { return input_files(o, scene); }));
  const bool exr = o.output.ends_with(".exr");
  if (!o.output.ends_with(".png") && !exr) {
    return Error{"-o " + o.output + ": the picture's name must end in .png or .exr"};
  }
  if (exr && !io::can_write_exr()) return Error{"-o " + o.output + ": this gvx was built without OpenEXR"};
  const render::View standard;
  const std::uint32_t width = scene.width.value_or(standard.width),
                      height = scene.height.value_or(standard.height);
  return io::check_image_size(o.output, width, height, std::size_t{4} * width * height);
}

Status write_picture(const std::string& path, const render::Picture& picture) {
  if (path.ends_with(".exr")) {
    return io::write_exr(path, picture.width, picture.height, picture.to_linear_premultiplied());
  }
  return io::write_png(path, picture.width, picture.height, picture.to_8_bit());
}

nlohmann::json to_json(const engine::Statistics& s) {
  nlohmann::json stages;
  for (const auto& [name, milliseconds] : s.stages.named()) stages[name] = milliseconds;
  return {{"frame_milliseconds", s.frame_milliseconds},
          {"passes", s.passes},
          {"requests", s.requests},
          {"bricks_produced", s.bricks_produced},
          {"bricks_evicted", s.bricks_evicted},
          {"bricks_resident", s.bricks_resident},
          {"nodes_resident", s.nodes_resident},
          {"bytes_read", s.bytes_read},
          {"samples", s.samples},
          {"peak_memory_bytes", s.peak_memory_bytes},
          {"converged", s.converged},
          {"resident_share", s.resident_share},
          {"worst_lack", s.worst_lack},
          {"level_bias", s.level_bias},
          {"stages", std::move(stages)}};
}

/// The newer frame's state, with the costs of both.
engine::Statistics sum(const engine::Statistics& before, engine::Statistics now) {
  now.frame_milliseconds += before.frame_milliseconds;
  now.passes += before.passes;
  now.requests += before.requests;
  now.bricks_produced += before.bricks_produced;
  now.bricks_evicted += before.bricks_evicted;
  return now;
}

void report(const std::string& path, const render::View& view, const engine::Statistics& s,
            const exec::Device& device) {
  std::printf("%s: %ux%u in %.0f ms on %s, %llu bricks made, %llu resident, %s\n", one_line(path).c_str(),
              view.width, view.height, s.frame_milliseconds, device.name().c_str(),
              static_cast<unsigned long long>(s.bricks_produced),
              static_cast<unsigned long long>(s.bricks_resident),
              s.converged ? "exact"
                          : ("a preview: " + std::to_string(int(100 * s.resident_share)) +
                             "% of the data was in memory at the resolution that it needs")
                                .c_str());
  std::fflush(stdout);
}

/// What pictures are made with.
struct Studio {
  const Options& options;
  const exec::Device& device;
  engine::Viewer& viewer;
  std::function<Status(const render::View&)> look;  ///< at what the scene shows
  const produce::TreeDescription* only_tree;        ///< null: there are several objects
  bool proxy;
  Progress& progress;
};

/// Writes the engine's picture. Says, behind `what`, why nothing can be seen in it; was that said?
Result<bool> write_picture_of(const Studio& studio, const std::string& path, const render::View& view,
                              bool say_nothing_is_seen, const std::string& what) {
  const render::Picture picture = studio.viewer.picture();
  GVX_TRY(write_picture(path, picture));
  if (!say_nothing_is_seen || studio.only_tree == nullptr) return false;
  const auto why =
      open::why_nothing_is_seen(picture, view, *studio.only_tree, studio.viewer.converged(), studio.proxy);
  if (why) warn(what + "nothing can be seen: " + *why);
  return why.has_value();
}

/// A picture of a resting camera, exact or of budget frames.
Result<engine::Statistics> render_still(const Studio& studio, const render::View& view) {
  const Options& o = studio.options;
  engine::Viewer& viewer = studio.viewer;
  GVX_TRY(studio.look(view));
  engine::Statistics statistics;
  if (o.budget.empty()) {
    GVX_TRY(viewer.render_exact(
        [&](std::uint64_t finished, std::uint64_t all) { studio.progress.show(finished, all); }));
    studio.progress.hide();
    statistics = viewer.statistics();
  } else {
    GVX_ASSIGN(const auto budget, in_flag("--budget", parse_duration(o.budget)));
    for (int frame = 0; frame < o.budget_frames && !viewer.converged(); ++frame) {
      GVX_TRY(viewer.render_for(budget));
      statistics = sum(statistics, viewer.statistics());
      studio.progress.show(static_cast<std::uint64_t>(frame) + 1,
                           static_cast<std::uint64_t>(o.budget_frames));
    }
    studio.progress.hide();
  }
  GVX_ASSIGN(const bool says, write_picture_of(studio, o.output, view, true, o.output + ": "));
  (void)says;
  return statistics;
}

/// A picture of each frame, by what is in the caches from those before it.
Result<engine::Statistics> render_frames(const Studio& studio, render::View view, FrameRange frames,
                                         const std::optional<scene::CameraPath>& path) {
  const Options& o = studio.options;
  const scene::Camera camera = view.camera;
  bool said = false;
  const auto render_frame = [&](int frame, const std::string& file) -> Result<engine::Statistics> {
    GVX_TRY(studio.look(view));
    // A frame counts as so many parts, of which some are done while it is rendered.
    constexpr std::uint64_t kParts = 1000;
    const auto frames_done = static_cast<std::uint64_t>(frame - frames.first);
    const std::uint64_t all_parts = kParts * static_cast<std::uint64_t>(frames.count());
    GVX_TRY(studio.viewer.render_exact([&](std::uint64_t finished, std::uint64_t all) {
      studio.progress.show(kParts * frames_done + finished * kParts / all, all_parts);
    }));
    studio.progress.show(kParts * (frames_done + 1), all_parts);
    studio.progress.hide();
    const std::string what = "frame " + std::to_string(frame) + ": ";
    GVX_ASSIGN(const bool says, write_picture_of(studio, file, view, !said, what));
    said = said || says;
    return studio.viewer.statistics();
  };
  engine::Statistics statistics;
  for (int frame = frames.first; frame <= frames.last; ++frame) {
    const double part = double(frame - frames.first) / frames.count();
    view.camera = path         ? path->at(frame)
                  : o.zoom > 0 ? scene::zoom(camera, std::pow(o.zoom, part))
                               : scene::orbit(camera, 360 * part);
    const std::string file = frame_file(o.output, frame);
    const auto rendered = render_frame(frame, file);
    if (!rendered.ok()) return Error{"frame " + std::to_string(frame) + ": " + rendered.error().message};
    if (!o.quiet) report(file, view, rendered.value(), studio.device);
    const std::uint64_t samples = statistics.samples + rendered.value().samples;
    statistics = sum(statistics, rendered.value());
    statistics.samples = samples;
  }
  return statistics;
}

Status write_text(const char* flag, const std::string& path, const std::string& text) {
  std::fflush(stdout);  // which `path` may name
  const Status status = io::write_file_atomically(path, std::as_bytes(std::span(text)));
  return status.ok() ? status : Error{std::string(flag) + " " + status.error().message};
}

/// Will the bricks of such a tree fit the pool?
Status check_memory(std::uint64_t memory_bytes, const produce::TreeDescription& tree) {
  const auto sizes = engine::PoolSizes::fitting(memory_bytes, tree);
  return sizes.ok() ? Status() : Error{"--" + sizes.error().message};  // which begins with "memory"
}

/// What was guessed of a mesh's upper side; empty where nothing was.
std::string guess_of_up(const scene::SceneFile& scene, const produce::TreeDescription& tree) {
  const std::string file = scene.volume->substr(open::file_position(*scene.volume));
  if (scene.up_axis || !io::is_mesh_name(file)) return {};
  const Box3d box = tree.bounds.value_or(tree.extent);
  const io::MeshUp up =
      io::mesh_up(file, {tree.tree_to_world.point(box.minimum), tree.tree_to_world.point(box.maximum)});
  return up.axis == tree.up ? up_note(file, up) : "";
}

/// What its numbers mean where the scene has a table of labels; a warning where the volume has none of them.
Result<nlohmann::json> legend_of(const open::OpenScene& opened, const open::FieldNaming& naming) {
  if (!opened.scene.labels || opened.scene.labels->table.empty()) return nlohmann::json::array();
  GVX_ASSIGN(nlohmann::json legend,
             open::label_legend(opened.scene, opened.view.functions.front(), opened.volume));
  if (legend.empty()) {
    warn(naming.before_value("labels") + opened.scene.labels->table +
         ": the volume has none of these labels");
  }
  return legend;
}

/// Opens the scene of a command line, if its bricks fit the memory.
Result<open::OpenScene> open_scene(const Options& o, const scene::SceneFile& scene,
                                   const exec::Device& device, std::uint64_t memory_bytes,
                                   const open::FieldNaming& naming) {
  WorkBar bar("building a temporary store (gvx build keeps it)", o.quiet);
  open::OpenOptions options{exec::Device::cpu(o.threads), device};
  options.warn = [&](const std::string& message) {
    bar.clear();
    warn(message);
  };
  options.show_work = [&](const open::Work& work) { bar.show(work); };
  options.before_build = [&](const VoxelFormat& format) {
    produce::TreeDescription tree;
    tree.format = format;
    return check_memory(memory_bytes, tree);
  };
  options.naming = naming;
  return open::open_scene(scene, options);
}

/// How a viewer comes to look at what was opened: a volume by itself, or a world of objects.
Result<std::function<Status(const render::View&)>> look_at(engine::Cache& cache, engine::Viewer& viewer,
                                                           const open::OpenScene& opened, bool alone) {
  using Look = std::function<Status(const render::View&)>;
  if (alone && !opened.volume.producer->description().surface) {
    GVX_ASSIGN(const auto volume, cache.open(opened.volume.producer));
    return Look([&viewer, volume](const render::View& view) { return viewer.look(view, volume); });
  }
  std::vector<engine::Object> objects;
  for (const open::OpenObject& object : opened.objects) {
    engine::Object placed{nullptr, object.to_world, object.look};
    if (object.volume.producer->description().surface) {
      GVX_ASSIGN(placed.surface, cache.open_surface(object.volume.producer));
    } else {
      GVX_ASSIGN(placed.volume, cache.open(object.volume.producer));
    }
    objects.push_back(std::move(placed));
  }
  GVX_ASSIGN(const auto world, engine::World::make(std::move(objects)));
  return Look([&viewer, world](const render::View& view) { return viewer.look(view, world); });
}

surface::Overlay overlay_of(const std::string& name) {
  const auto found = std::find(std::begin(surface::kOverlayNames), std::end(surface::kOverlayNames), name);
  return found == std::end(surface::kOverlayNames)
             ? surface::Overlay::none
             : static_cast<surface::Overlay>(found - std::begin(surface::kOverlayNames));
}

Status save_scene(const Options& o, scene::SceneFile scene) {
  if (o.save_scene.empty()) return {};
  open::relate_names(scene, o.save_scene);
  return write_text("--save-scene", o.save_scene, scene::to_json(scene));
}

Status render(const Options& o) {
  std::optional<FrameRange> frames;
  if (!o.frames.empty()) {
    GVX_ASSIGN(frames, parse_frames(o.frames));
  }
  engine::CacheOptions cache_options;
  engine::ViewerOptions viewer_options;
  cache_options.warn = warn;
  GVX_ASSIGN(cache_options.memory_bytes, in_flag("--memory", parse_bytes(o.memory)));
  if (!o.budget.empty()) {
    GVX_ASSIGN(const auto budget, in_flag("--budget", parse_duration(o.budget)));
    (void)budget;
  }
  GVX_ASSIGN(const scene::SceneFile scene, read_command(o));
  GVX_TRY(check_output_files(o, scene, frames));
  GVX_ASSIGN(const exec::Device device, open_device(o));
  GVX_ASSIGN(auto proxy, read_proxy(o));
  const open::FieldNaming naming([&](const std::string& field) { return o.flags.flag_of(field); });
  GVX_ASSIGN(const open::OpenScene opened, open_scene(o, scene, device, cache_options.memory_bytes, naming));
  const produce::TreeDescription& tree = opened.volume.producer->description();
  render::View view = opened.view;
  view.overlay = overlay_of(o.overlay);
  GVX_ASSIGN(const nlohmann::json legend, legend_of(opened, naming));
  GVX_TRY(save_scene(o, opened.scene));
  const bool alone = !open::has_placed_objects(scene);
  if (!o.proxy.empty()) {
    if (!alone) return Error{"--proxy: goes with a scene of one object without a transform"};
    GVX_ASSIGN(viewer_options.proxy, make_proxy(std::move(proxy), opened));
  }
  if (!tree.surface) GVX_TRY(check_memory(cache_options.memory_bytes, tree));
  GVX_ASSIGN(const auto cache, engine::Cache::create(device, cache_options));
  engine::Viewer viewer(cache, viewer_options);
  GVX_ASSIGN(const auto look, look_at(*cache, viewer, opened, alone));
  // A frame is done in parts, and those of a budget are few: only the share that is done says anything.
  const bool counts_rays = !frames && o.budget.empty();
  Progress progress("rendering", counts_rays ? Progress::Unit::rays : Progress::Unit::none, o.quiet);
  const Studio studio{o,
                      device,
                      viewer,
                      look,
                      alone && !tree.surface ? &tree : nullptr,
                      viewer_options.proxy != nullptr,
                      progress};
  GVX_ASSIGN(const engine::Statistics statistics,
             frames ? render_frames(studio, view, *frames, opened.path) : render_still(studio, view));
  if (!o.stats.empty()) {
    nlohmann::json stats = to_json(statistics);
    if (!legend.empty()) stats["labels"] = legend;
    const std::string text = stats.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    GVX_TRY(write_text("--stats", o.stats, text + "\n"));
  }
  const std::string guess = alone ? guess_of_up(opened.scene, tree) : "";
  if (!guess.empty() && !o.quiet) std::printf("%s\n", one_line(guess).c_str());
  if (!frames && !o.quiet) {
    report(o.output, view, statistics, device);
    std::printf("--camera '%s'\n", scene::to_text(view.camera).c_str());
  }
  return {};
}

}  // namespace

Command add_render(CLI::App& program) {
  auto o = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("render", "Make a picture of a scene");
  command
      ->add_option(
          "scene", o->scene,
          "A .gvx store; a volume, folder or mesh (see gvx build); a scene file (.json), whose fields are "
          "overridden by flags; or a made scene: sponge, stored-sponge, cloud, cloud:MESH, terrain, "
          "hypertexture:MESH (or pseudo-mesh: ramp: blurred: solid-noise:), distance:MESH, "
          "axis-distance:MESH, repeat:SCENE, amplify:SCENE")
      ->required();
  command->add_option("-o,--output", o->output, "The picture to write; its name ends in .png or .exr")
      ->required();
  CLI::Option* exact = command->add_flag("--exact", o->exact, "Render the complete picture (the default)");
  CLI::Option* budget =
      command
          ->add_option("--budget", o->budget,
                       "Render for about this time, such as 33ms, and write the picture as it then is")
          ->excludes(exact);
  command
      ->add_option("--budget-frames", o->budget_frames,
                   "Render up to this many frames from the same camera, each for that time, until the "
                   "picture is exact")
      ->check(CLI::Range(1, 1000000))
      ->needs(budget);
  command
      ->add_option(
          "--frames", o->frames,
          "N or A-B: write numbered pictures along the camera path, or once around the target. %04d in the "
          "picture's name is replaced by the number")
      ->excludes(budget);
  command
      ->add_option(
          "--zoom", o->zoom,
          "With --frames and no camera path: come nearer to the target, this many times in all, by the same "
          "factor in each frame")
      ->check(CLI::Range(1e-30, 1e30))
      ->needs("--frames");
  command->add_option("--memory", o->memory, "Memory for bricks, nodes and index pages")
      ->capture_default_str();
  command->add_option("--threads", o->threads, "Number of threads; 0: all cores")->check(CLI::Range(0, 1024));
  command->add_option("--device", o->device, "Where to render")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  command
      ->add_option("--proxy", o->proxy,
                   "A closed mesh around everything that can be seen: rays march only from the first to the "
                   "last point where they cross it. nodes: gvx makes this mesh from the nodes that may be "
                   "visible")
      ->check(not_empty());
  command
      ->add_option(
          "--overlay", o->overlay,
          "What the colours of surfaces show. technique: what was rasterised (red), cast (green) and "
          "splatted (blue); samples: how many samples the column of a cell has, one (green), one span "
          "(blue), several (red)")
      ->check(CLI::IsMember(
          std::vector<std::string>(std::begin(surface::kOverlayNames), std::end(surface::kOverlayNames))))
      ->capture_default_str();
  command->add_option("--stats", o->stats, "Write statistics to this JSON file")->check(not_empty());
  command
      ->add_option("--save-scene", o->save_scene,
                   "Write the scene, with the settings of all flags, to this JSON file")
      ->check(not_empty());
  command->add_flag("--quiet", o->quiet, "Print nothing but errors and warnings");
  o->flags.add_to(*command);
  o->flags.functions().let_labels_precede(command->get_option("scene"), &o->scene);
  return [o] { return render(*o); };
}

}  // namespace gvx::app
