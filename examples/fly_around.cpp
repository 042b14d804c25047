// Flies around a volume with a budget of 33 milliseconds for each frame, as an interactive program does. Then
// the camera rests, and the picture becomes the exact one.
//
//     gvx build VOLUME -o STORE.gvx
//     fly_around STORE.gvx FOLDER      writes frame_000.png, frame_030.png, frame_060.png and rest.png

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <gvx/engine/engine.h>
#include <gvx/io/image.h>
#include <gvx/produce/store_producer.h>
#include <gvx/scene/camera_path.h>
#include <gvx/scene/transfer_presets.h>

static gvx::Status run(const char* path, const std::string& folder) {
  using namespace std::chrono_literals;
  GVX_ASSIGN(auto store, gvx::store::StoreReader::open(path));
  const auto volume = std::make_shared<gvx::produce::StoreProducer>(std::move(store));
  const gvx::produce::TreeDescription& tree = volume->description();

  // Bricks are kept in this much memory, however big the volume is.
  gvx::engine::EngineOptions options;
  options.memory_bytes = 256 << 20;
  GVX_ASSIGN(const auto engine, gvx::engine::Engine::create(gvx::exec::Device::cpu(), volume, options));

  gvx::render::View view;
  view.width = 640;
  view.height = 480;
  const double aspect = double(view.width) / view.height;
  const gvx::scene::Camera start =
      gvx::scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical, aspect);
  // An opacity that grows with the value; docs/program.md lists the presets that choose more.
  if (tree.format.content == gvx::VoxelContent::scalar) {
    const auto statistics =
        gvx::scene::physical_statistics(tree.ranges.channel[0], {}, tree.scale, tree.offset);
    GVX_ASSIGN(auto function, gvx::scene::preset("gray", statistics));
    view.functions = {std::move(function)};
  }

  // What a window would show: the engine writes into it.
  std::vector<std::uint8_t> pixels(4ull * view.width * view.height);
  const auto write = [&](const std::string& name) -> gvx::Status {
    GVX_TRY(engine->picture({.rgba8 = {pixels}}));
    return gvx::io::write_png(folder + "/" + name, view.width, view.height, pixels);
  };

  for (int frame = 0; frame < 90; ++frame) {
    view.camera = gvx::scene::orbit(start, 2.0 * frame);
    GVX_TRY(engine->look(view));
    GVX_TRY(engine->render_for(33ms));
    if (frame % 30 != 0) continue;
    // A frame shows what is there by then; the rest is loaded while the camera moves on.
    const gvx::engine::Statistics statistics = engine->statistics();
    std::printf("frame %d: %.1f ms, has %.0f%% of what it wants\n", frame, statistics.frame_milliseconds,
                100 * statistics.resident_share);
    char name[32];
    std::snprintf(name, sizeof(name), "frame_%03d.png", frame);
    GVX_TRY(write(name));
  }
  int frames = 0;
  for (; !engine->converged(); ++frames) GVX_TRY(engine->render_for(33ms));
  std::printf("at rest: exact after %d frames\n", frames);
  return write("rest.png");
}

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: fly_around STORE.gvx FOLDER\n"), 2;
  const gvx::Status status = run(argv[1], argv[2]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
