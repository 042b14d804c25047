// What does it take to get the picture out of the engine, and its depth? Prints the medians in milliseconds
// of one run, for a store and its default view:
//
//     picture              a new vector of floats, and its bytes
//     rgba8 rgba depth     the same into memory that is there already
//     frame                the exact frame itself, for comparison
//
//     gvx_bench_picture STORE.gvx [WIDTH HEIGHT]

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "gvx/engine/engine.h"
#include "gvx/produce/store_producer.h"
#include "gvx/scene/transfer_presets.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;

template <typename Function>
double median_ms(const Function& function) {
  std::vector<double> times;
  for (int i = 0; i < 9; ++i) {
    const auto start = std::chrono::steady_clock::now();
    function();
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

Status run(const char* path, std::uint32_t width, std::uint32_t height) {
  GVX_ASSIGN(auto reader, store::StoreReader::open(path));
  const auto producer = std::make_shared<produce::StoreProducer>(std::move(reader));
  const produce::TreeDescription& tree = producer->description();
  render::View view;
  view.width = width;
  view.height = height;
  view.camera = scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical, double(width) / height);
  if (tree.format.content == VoxelContent::scalar) {
    const scene::ValueStatistics statistics =
        scene::physical_statistics(tree.ranges.channel[0], tree.histograms[0], tree.scale, tree.offset);
    GVX_ASSIGN(auto function, scene::preset(scene::suggest_preset(statistics), statistics));
    view.functions = {std::move(function)};
  }
  engine::EngineOptions options;
  options.memory_bytes = 4ull << 30;
  GVX_ASSIGN(const auto engine, engine::Engine::create(exec::Device::cpu(), producer, options));
  GVX_TRY(engine->look(view));
  GVX_TRY(engine->render_exact());
  const double frame = median_ms([&] {
    view.background.x += 0.001f;  // the same rays anew
    GVX_CHECK(engine->look(view).ok() && engine->render_exact().ok());
  });
  std::vector<std::uint8_t> bytes(4ull * width * height);
  std::vector<float> floats(bytes.size()), depth(bytes.size() / 4);
  const auto target_ms = [&](const render::PictureTarget& target) {
    return median_ms([&] { GVX_CHECK(engine->picture(target).ok()); });
  };
  std::printf("frame   %8.2f\n", frame);
  std::printf("picture %8.2f\n", median_ms([&] { GVX_CHECK(!engine->picture().to_8_bit().empty()); }));
  std::printf("rgba8   %8.2f\n", target_ms({.rgba8 = {bytes}}));
  std::printf("rgba    %8.2f\n", target_ms({.rgba = {floats}}));
  std::printf("depth   %8.2f\n", target_ms({.depth = {depth}}));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 4) {
    std::fprintf(stderr, "usage: gvx_bench_picture STORE.gvx [WIDTH HEIGHT]\n");
    return 2;
  }
  const auto number = [&](int i, int otherwise) {
    return static_cast<std::uint32_t>(argc > i ? std::atoi(argv[i]) : otherwise);
  };
  const Status status = run(argv[1], number(2, 1920), number(3, 1080));
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
