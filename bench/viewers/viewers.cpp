// What a viewer whose view changes every frame costs another, which waits for its exact picture, on one
// cache: time until the picture is exact, alone and beside the other, by turns. Fair shares would make it
// take twice as long. Prints JSON:
//
//     gvx_bench_viewers STORE.gvx [ROUNDS [BUDGET_MS]]

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "gvx/engine/cache.h"
#include "gvx/engine/viewer.h"
#include "gvx/produce/store_producer.h"
#include "gvx/scene/framing.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;
using Clock = std::chrono::steady_clock;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::shared_ptr<const produce::Producer> open(const char* path) {
  auto reader = store::StoreReader::open(path);
  if (!reader.ok()) {
    std::fprintf(stderr, "%s\n", reader.error().message.c_str());
    std::exit(1);
  }
  return std::make_shared<produce::StoreProducer>(std::move(reader).value());
}

render::View view_of(const tree::TreeDescription& tree, std::uint32_t width, std::uint32_t height) {
  render::View view;
  view.width = width;
  view.height = height;
  view.camera = scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical,
                                 double(width) / double(height), 0.95);
  view.functions = {{{{60, {0.8, 0.6, 0.4}}, {250, {0.9, 0.75, 0.55}}}, {{60, 0}, {100, 0.95}}, 0}};
  return view;
}

/// Turns around a volume, a frame of a budget after the other, until it is told to stop.
class MovingViewer {
 public:
  MovingViewer(const std::shared_ptr<engine::Cache>& cache, const std::shared_ptr<engine::Volume>& volume,
               std::chrono::milliseconds budget)
      : viewer_(cache), thread_([=, this] {
          render::View view = view_of(volume->tree(), 640, 480);
          const Vec3d from_target = view.camera.eye - view.camera.target;
          for (int frame = 0; !stop_; ++frame) {
            const double angle = 0.02 * frame, c = std::cos(angle), s = std::sin(angle);
            view.camera.eye =
                view.camera.target + Vec3d(c * from_target.x - s * from_target.y,
                                           s * from_target.x + c * from_target.y, from_target.z);
            GVX_CHECK(viewer_.look(view, volume).ok() && viewer_.render_for(budget).ok());
            frames_ = frame + 1;
          }
        }) {}
  ~MovingViewer() {
    stop_ = true;
    thread_.join();
  }
  int frames() const { return frames_; }

 private:
  engine::Viewer viewer_;
  std::atomic<bool> stop_{false};
  std::atomic<int> frames_{0};
  std::thread thread_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: gvx_bench_viewers STORE.gvx [ROUNDS [BUDGET_MS]]\n");
    return 2;
  }
  const int rounds = std::max(argc > 2 ? std::atoi(argv[2]) : 9, 1);
  const std::chrono::milliseconds budget(argc > 3 ? std::atoi(argv[3]) : 33);
  std::vector<double> alone, beside;
  int frames = 0;
  for (int round = 0; round < 2 * rounds; ++round) {
    const bool has_company = round % 2 != 0;
    engine::CacheOptions options;
    const auto cache = engine::Cache::create(exec::Device::cpu(), options).value();
    const auto volume = cache->open(open(argv[1])).value();
    engine::Viewer viewer(cache);
    render::View view = view_of(volume->tree(), 1280, 720);
    view.camera.eye.z += 0.1 * length(view.camera.eye - view.camera.target);
    std::optional<MovingViewer> other;
    if (has_company) other.emplace(cache, volume, budget);
    const auto start = Clock::now();
    GVX_CHECK(viewer.look(view, volume).ok() && viewer.render_exact().ok());
    (has_company ? beside : alone)
        .push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    frames += has_company ? other->frames() : 0;
  }
  const nlohmann::json result = {{"alone_ms", median(alone)},
                                 {"beside_a_moving_viewer_ms", median(beside)},
                                 {"ratio", median(beside) / median(alone)},
                                 {"frames_of_the_other", frames}};
  std::cout << result.dump(2) << "\n";
}
