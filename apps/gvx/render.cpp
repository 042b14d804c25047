// gvx render SCENE -o OUT.png: a picture of a scene.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "gvx/engine/engine.h"
#include "gvx/io/file_commit.h"
#include "gvx/io/image.h"
#include "gvx/io/transfer_function_file.h"
#include "open_scene.h"
#include "units.h"

namespace gvx::app {
namespace {

struct Options {
  std::string scene, output, size = "1024x1024", camera, function, budget, memory = "512M", device = "cpu",
                             stats, clip, background = "0,0,0";
  int threads = 0, frames = 1;
  double samples = 2;
  bool exact = false, flat = false, finest = false, transparent = false, quiet = false;
  RawFlags raw;
};

Result<exec::Device> open_device(const Options& o) {
  if (o.device == "cuda") return exec::Device::cuda();
  return exec::Device::cpu(o.threads);
}

Result<scene::TransferFunction> open_function(const Options& o, const Scene& scene) {
  const std::string name = o.function.empty() ? scene.preset : o.function;
  const auto names = scene::preset_names();
  const bool is_preset = std::find(names.begin(), names.end(), name) != names.end();
  if (!is_preset && std::filesystem::exists(name)) return io::read_transfer_function(name);
  auto function = scene::preset(name, value_statistics(scene.producer->description(), 0));
  if (!function.ok()) return Error{"--tf: no file and " + function.error().message};
  return function;
}

Result<render::View> make_view(const Options& o, const Scene& scene) {
  render::View view;
  GVX_ASSIGN(const Size size, parse_size(o.size));
  view.width = size.width;
  view.height = size.height;
  GVX_ASSIGN(auto function, open_function(o, scene));
  view.functions = {std::move(function)};
  const produce::TreeDescription& tree = scene.producer->description();
  view.camera =
      scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical, double(size.width) / size.height);
  if (!o.camera.empty()) {
    GVX_ASSIGN(view.camera, scene::parse_camera(o.camera, view.camera));
  }
  if (!o.clip.empty()) {
    GVX_ASSIGN(view.clip, parse_box(o.clip));
  }
  GVX_ASSIGN(const Vec3d background, parse_vec3(o.background));
  view.background = Vec3f(background);
  view.opaque_background = !o.transparent;
  view.lighting.enabled = !o.flat;
  view.samples_per_voxel = o.samples;
  view.level_of_detail = !o.finest;
  return view;
}

Status write_picture(const std::string& path, const render::Picture& picture) {
  if (path.ends_with(".exr")) {
    return io::write_exr(path, picture.width, picture.height, picture.to_linear_premultiplied());
  }
  return io::write_png(path, picture.width, picture.height, picture.to_8_bit());
}

nlohmann::json to_json(const engine::Statistics& s) {
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
          {"worst_lack", s.worst_lack}};
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

Status render(const Options& o) {
  if (!o.output.ends_with(".png") && !o.output.ends_with(".exr")) {
    return Error{o.output + ": the picture's name must end in .png or .exr"};
  }
  if (o.exact && !o.budget.empty()) return Error{"--exact and --budget exclude each other"};
  GVX_ASSIGN(const exec::Device device, open_device(o));
  GVX_ASSIGN(const io::RawOptions raw, o.raw.parse());
  GVX_ASSIGN(const Scene scene, open_scene(exec::Device::cpu(o.threads), o.scene, raw));
  engine::EngineOptions engine_options;
  GVX_ASSIGN(engine_options.memory_bytes, parse_bytes(o.memory));
  GVX_ASSIGN(const render::View view, make_view(o, scene));
  GVX_ASSIGN(const auto engine, engine::Engine::create(device, scene.producer, engine_options));
  GVX_TRY(engine->look(view));
  engine::Statistics statistics;
  if (o.budget.empty()) {
    GVX_TRY(engine->render_exact());
    statistics = engine->statistics();
  } else {
    GVX_ASSIGN(const auto budget, parse_duration(o.budget));
    for (int frame = 0; frame < o.frames && !engine->converged(); ++frame) {
      GVX_TRY(engine->render_for(budget));
      statistics = sum(statistics, engine->statistics());
    }
  }
  GVX_TRY(write_picture(o.output, engine->picture()));
  if (!o.stats.empty()) {
    const std::string text = to_json(statistics).dump(2) + "\n";
    GVX_TRY(io::write_file_atomically(o.stats, std::as_bytes(std::span(text))));
  }
  if (o.quiet) return {};
  std::printf("%s: %ux%u in %.0f ms on %s, %llu bricks made, %llu resident, %s\n", o.output.c_str(),
              view.width, view.height, statistics.frame_milliseconds, device.name().c_str(),
              static_cast<unsigned long long>(statistics.bricks_produced),
              static_cast<unsigned long long>(statistics.bricks_resident),
              statistics.converged ? "exact"
                                   : ("a preview: " + std::to_string(int(100 * statistics.resident_share)) +
                                      "% of what it wants is resident")
                                         .c_str());
  std::printf("--camera '%s'\n", scene::to_text(view.camera).c_str());
  return {};
}

}  // namespace

Command add_render(CLI::App& program) {
  auto o = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("render", "Render a picture of a scene");
  command->add_option("scene", o->scene, "A .gvx store, a volume file (see gvx build), or sponge")
      ->required();
  command->add_option("-o,--output", o->output, "The picture to write, .png or .exr")->required();
  command->add_option("--size", o->size, "Of the picture, WxH")->capture_default_str();
  command->add_option(
      "--camera", o->camera,
      "eye=x,y,z;target=x,y,z;up=x,y,z;fov=degrees in world space, or height=world for an orthographic "
      "one; parts that are left out are as without this flag: all of the scene framed");
  command->add_option(
      "--tf", o->function,
      "Transfer function: a ParaView JSON colour map, or a preset: ct-bone ct-skin ct-tissue gray solid; "
      "without it a preset that suits the values");
  CLI::Option* exact = command->add_flag("--exact", o->exact, "Until no ray lacks anything (the default)");
  command->add_option("--budget", o->budget, "Render for this long instead, such as 33ms")->excludes(exact);
  command->add_option("--frames", o->frames, "With --budget: as many such frames of the resting camera")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--memory", o->memory, "Bound of the brick pool")->capture_default_str();
  command->add_option("--threads", o->threads, "Threads; 0 takes all cores")->check(CLI::Range(0, 1024));
  command->add_option("--device", o->device, "Where to render")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  command->add_option("--stats", o->stats, "Write statistics to this JSON file");
  command->add_option("--clip", o->clip,
                      "Show only this box, X0,Y0,Z0,X1,Y1,Z1 in fractions of the volume's");
  command->add_option("--background", o->background, "Red,green,blue, 0 to 1")->capture_default_str();
  command->add_flag("--transparent", o->transparent, "Keep the picture's alpha instead of a background");
  command->add_flag("--flat", o->flat, "Without shading");
  command->add_flag("--finest", o->finest, "The finest level everywhere, however small it is in the picture");
  command->add_option("--samples", o->samples, "Samples a voxel along a ray")->capture_default_str();
  command->add_flag("--quiet", o->quiet, "Print nothing but errors");
  o->raw.add_to(*command);
  return [o] { return render(*o); };
}

}  // namespace gvx::app
