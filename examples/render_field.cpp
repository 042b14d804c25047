// Renders a function of one's own. Nothing is stored: bricks are made where rays ask.
//
//     render_field OUT.png

#include <cmath>
#include <cstdio>
#include <memory>

#include <gvx/engine/engine.h>
#include <gvx/io/image.h>
#include <gvx/produce/field_producer.h>
#include <gvx/produce/sampled_bounds.h>

// A gyroid: four periods along each axis of the cube [0, 1]^3.
static float gyroid(gvx::Vec3d p) {
  const gvx::Vec3d q = 8 * M_PI * p;
  return static_cast<float>(std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) +
                            std::sin(q.z) * std::cos(q.x));
}

static gvx::Status run(const char* picture) {
  // 16 * 2^4 = 256 voxels along an axis, of which only those near the surface are ever made.
  gvx::produce::TreeDescription tree;
  tree.max_level = 4;

  // The engine must know between which values the function lies in a box, to tell where there is nothing to
  // see. Here that is estimated from samples. A period is 1/4 long; its bumps are half as wide.
  gvx::produce::SampledBoundsOptions sampling;
  sampling.feature = 1.0 / 8;
  GVX_ASSIGN(const auto bounds, gvx::produce::SampledBounds::create(gyroid, sampling));
  const auto producer = std::make_shared<gvx::produce::FieldProducer>(tree, gyroid, bounds);

  // Where the estimate turns out to be wrong, the engine says so.
  gvx::engine::EngineOptions options;
  options.warn = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  GVX_ASSIGN(const auto engine, gvx::engine::Engine::create(gvx::exec::Device::cpu(), producer, options));

  gvx::render::View view;
  view.width = view.height = 400;
  view.camera = gvx::scene::frame_box(tree.extent, tree.tree_to_world, false, 1);
  // Only values near 0 can be seen: a thin sheet, blue on one side and orange on the other.
  view.functions = {gvx::scene::TransferFunction()
                        .add_color(-0.3, {0.1, 0.5, 0.7})
                        .add_color(0.3, {1, 0.7, 0.3})
                        .add_opacity(-0.3, 0)
                        .add_opacity(-0.1, 0.8)
                        .add_opacity(0.1, 0.8)
                        .add_opacity(0.3, 0)};
  GVX_TRY(engine->look(view));
  GVX_TRY(engine->render_exact());
  std::printf("%s: %llu bricks were made\n", picture,
              static_cast<unsigned long long>(engine->statistics().bricks_produced));
  return gvx::io::write_png(picture, view.width, view.height, engine->picture().to_8_bit());
}

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: render_field OUT.png\n"), 2;
  const gvx::Status status = run(argv[1]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
