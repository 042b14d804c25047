// Renders a ball, and fails if the picture shows none. install_test.cmake looks at which libraries this
// program needs: it embeds the engine and reads no files.

#include <cstdio>
#include <memory>

#include <gvx/engine/engine.h>
#include <gvx/produce/field_producer.h>

static const gvx::Vec3d kCentre(0.5);

/// Bounds of 0.4 minus the distance from the centre.
static gvx::ValueRange ball_bounds(const gvx::Box3d& box) {
  const double middle = 0.4 - length(0.5 * (box.minimum + box.maximum) - kCentre);
  const double reach = 0.5 * length(box.maximum - box.minimum);
  return {static_cast<float>(middle - reach), static_cast<float>(middle + reach)};
}

static gvx::Result<gvx::render::Picture> render() {
  gvx::produce::TreeDescription tree;
  tree.format.type = gvx::VoxelType::f32;
  tree.max_level = 2;
  const auto ball = [](gvx::Vec3d p) { return static_cast<float>(0.4 - length(p - kCentre)); };
  const auto producer = std::make_shared<gvx::produce::FieldProducer>(tree, ball, ball_bounds);
  GVX_ASSIGN(const auto engine, gvx::engine::Engine::create(gvx::exec::Device::cpu(), producer, {}));
  gvx::render::View view;
  view.width = view.height = 32;
  view.camera = gvx::scene::frame_box(tree.extent, tree.tree_to_world, false, 1);
  view.functions = {{{{0, {1, 1, 1}}}, {{0, 0}, {0.1, 1}}}};
  GVX_TRY(engine->look(view));
  GVX_TRY(engine->render_exact());
  return engine->picture();
}

int main() {
  const auto picture = render();
  if (!picture.ok()) return std::fprintf(stderr, "%s\n", picture.error().message.c_str()), 1;
  const auto pixels = picture.value().to_8_bit();
  const int middle = pixels[4 * (16 * 32 + 16)], corner = pixels[0];
  std::printf("a ball: %d in the middle, %d in the corner\n", middle, corner);
  return middle > corner + 50 ? 0 : 1;
}
