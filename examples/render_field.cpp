// A producer in a few lines: a field in closed form, rendered exactly. Nothing is stored; bricks are made
// where rays ask.
//
//     render_field OUT.png

#include <cmath>
#include <cstdio>
#include <memory>

#include <gvx/engine/engine.h>
#include <gvx/io/image.h>
#include <gvx/produce/field_producer.h>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: render_field OUT.png\n");
    return 2;
  }
  // A gyroid in a tree of 5 levels of 16^3 bricks: 256^3 voxels, of which only those near the surface are
  // ever made.
  gvx::produce::TreeDescription tree;
  tree.max_level = 4;
  const double k = 8 * M_PI;
  const auto gyroid = [k](gvx::Vec3d p) {
    return static_cast<float>(std::sin(k * p.x) * std::cos(k * p.y) + std::sin(k * p.y) * std::cos(k * p.z) +
                              std::sin(k * p.z) * std::cos(k * p.x));
  };
  // The oracle: within a box the field differs from its centre's value by no more than its steepest slope
  // allows.
  const auto bounds = [k, gyroid](const gvx::Box3d& box) {
    const float centre = gyroid(0.5 * (box.minimum + box.maximum));
    const auto reach = static_cast<float>(k * std::sqrt(3.0) * 0.5 * length(box.maximum - box.minimum));
    return gvx::ValueRange{std::fmax(centre - reach, -3.0f), std::fmin(centre + reach, 3.0f)};
  };
  const auto producer = std::make_shared<gvx::produce::FieldProducer>(tree, gyroid, bounds);

  const auto engine = gvx::engine::Engine::create(gvx::exec::Device::cpu(), producer, {});
  if (!engine.ok()) return std::fprintf(stderr, "%s\n", engine.error().message.c_str()), 1;

  gvx::render::View view;
  view.width = view.height = 400;
  view.camera = gvx::scene::frame_box(tree.extent, tree.tree_to_world, false, 1);
  view.functions = {{{{-0.3, {0.1, 0.5, 0.7}}, {0.3, {1, 0.7, 0.3}}},
                     {{-0.3, 0}, {-0.1, 0.8}, {0.1, 0.8}, {0.3, 0}},
                     0,
                     {}}};
  if (const auto status = engine.value()->look(view); !status.ok()) {
    return std::fprintf(stderr, "%s\n", status.error().message.c_str()), 1;
  }
  if (const auto status = engine.value()->render_exact(); !status.ok()) {
    return std::fprintf(stderr, "%s\n", status.error().message.c_str()), 1;
  }
  const auto status =
      gvx::io::write_png(argv[1], view.width, view.height, engine.value()->picture().to_8_bit());
  if (!status.ok()) return std::fprintf(stderr, "%s\n", status.error().message.c_str()), 1;
  std::printf("%s: %llu bricks were made\n", argv[1],
              static_cast<unsigned long long>(engine.value()->statistics().bricks_produced));
  return 0;
}
