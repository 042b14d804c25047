// A store bigger than one likes to wait for, seen from afar and along a recorded path. Prints JSON:
//   far     the whole volume, a third of 512 pixels across, cold and then warm: time, bricks, their memory
//   path    from a cold cache at 1280x720: the camera comes from afar, passes by and stops; frames
//           of a budget, without and with prefetching and adapting levels, and how like exact pictures they
//           are
//
//     gvx_bench_path STORE.gvx [BUDGET_MS]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "gvx/engine/engine.h"
#include "gvx/produce/store_producer.h"
#include "gvx/scene/camera_path.h"
#include "gvx/scene/framing.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;
using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

double since(Clock::time_point start) {
  return Milliseconds(Clock::now() - start).count();
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

std::unique_ptr<engine::Engine> cold_engine(const char* path, bool prefetch, bool adapt_levels) {
  auto reader = store::StoreReader::open(path);
  if (!reader.ok()) {
    std::fprintf(stderr, "%s\n", reader.error().message.c_str());
    std::exit(1);
  }
  engine::EngineOptions options;
  options.memory_bytes = 512u << 20;
  options.prefetch = prefetch;
  options.adapt_levels = adapt_levels;
  auto producer = std::make_shared<produce::StoreProducer>(std::move(reader).value());
  return engine::Engine::create(exec::Device::cpu(), std::move(producer), options).value();
}

render::View base_view(const produce::TreeDescription& tree, std::uint32_t width, std::uint32_t height) {
  render::View view;
  view.width = width;
  view.height = height;
  view.camera = scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical,
                                 double(width) / double(height), 0.95);
  view.functions = {{{{60, {0.8, 0.6, 0.4}}, {250, {0.9, 0.75, 0.55}}}, {{60, 0}, {100, 0.95}}, 0}};
  return view;
}

nlohmann::json bench_far(const char* path) {
  std::vector<double> cold, warm;
  engine::Statistics statistics;
  std::uint64_t brick_bytes = 0;
  for (int run = 0; run < 5; ++run) {
    const auto engine = cold_engine(path, false, false);
    brick_bytes = engine->tree().brick_bytes();
    render::View view = base_view(engine->tree(), 512, 512);
    view.camera.eye = view.camera.target + 3.0 * (view.camera.eye - view.camera.target);
    GVX_CHECK(engine->look(view).ok() && engine->render_exact().ok());
    statistics = engine->statistics();
    cold.push_back(statistics.frame_milliseconds);
    view.background.x += 0.5f;  // the same rays anew
    GVX_CHECK(engine->look(view).ok() && engine->render_exact().ok());
    warm.push_back(engine->statistics().frame_milliseconds);
  }
  return {{"cold_ms", percentile(cold, 0.5)},
          {"warm_ms", percentile(warm, 0.5)},
          {"bricks", statistics.bricks_resident},
          {"bricks_mib", static_cast<double>(statistics.bricks_resident * brick_bytes) / (1 << 20)}};
}

/// From where all is seen, to where an eighth of it fills the picture, past it to the side; 120 frames.
scene::CameraPath recorded_path(const scene::Camera& framed, Vec3d size) {
  scene::Camera near = framed, aside = framed;
  near.target = framed.target + 0.2 * Vec3d(size.x, 0, size.z);
  near.eye = near.target + 0.25 * (framed.eye - framed.target);
  aside.target = framed.target - 0.2 * Vec3d(size.x, 0, 0);
  aside.eye = aside.target + 0.25 * (framed.eye - framed.target);
  return scene::CameraPath::create({{0, framed}, {70, near}, {119, aside}}).value();
}

/// What a system can do to show more of a moving camera's view in time.
struct Means {
  bool prefetch, adapt_levels;
};

double psnr(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / std::max(squares, 1.0));
}

/// Exact pictures of every kApart-th frame.
struct ExactPictures {
  static constexpr int kApart = 4;
  std::vector<std::vector<std::uint8_t>> frames;
};

nlohmann::json bench_path(const char* path, double budget_ms, Means means, ExactPictures& exact) {
  const auto budget = std::chrono::nanoseconds(static_cast<std::int64_t>(budget_ms * 1e6));
  const auto start = Clock::now();
  const auto engine = cold_engine(path, means.prefetch, means.adapt_levels);
  render::View view = base_view(engine->tree(), 1280, 720);
  const Affine3& place = engine->tree().tree_to_world;
  const Vec3d extent = engine->tree().extent.maximum;
  const scene::CameraPath camera =
      recorded_path(view.camera, {extent.x * length(place.column[0]), extent.y * length(place.column[1]),
                                  extent.z * length(place.column[2])});
  std::vector<double> times, lacking;
  std::vector<std::vector<std::uint8_t>> shown;
  double first = 0;
  for (int frame = 0; frame < 120; ++frame) {
    view.camera = camera.at(frame);
    const auto frame_start = Clock::now();
    GVX_CHECK(engine->look(view).ok() && engine->render_for(budget).ok());
    times.push_back(since(frame_start));
    if (frame == 0) first = since(start);
    lacking.push_back(1 - engine->statistics().resident_share);
    if (frame % ExactPictures::kApart == 0) shown.push_back(engine->picture().to_8_bit());
  }
  const auto stopped = Clock::now();
  int frames = 0;
  while (!engine->converged() && frames++ < 100000) GVX_CHECK(engine->render_for(budget).ok());
  const double exact_after_stop = since(stopped);
  const engine::Statistics statistics = engine->statistics();
  nlohmann::json stages_ms;
  for (const auto& [name, milliseconds] : statistics.stages.named()) stages_ms[name] = milliseconds;
  for (int frame = 0; exact.frames.size() < shown.size(); frame += ExactPictures::kApart) {
    view.camera = camera.at(frame);
    GVX_CHECK(engine->look(view).ok() && engine->render_exact().ok());
    exact.frames.push_back(engine->picture().to_8_bit());
  }
  std::vector<double> decibels;
  for (std::size_t i = 0; i < shown.size(); ++i) decibels.push_back(psnr(shown[i], exact.frames[i]));
  double mean_lacking = 0;
  for (const double share : lacking) mean_lacking += share / static_cast<double>(lacking.size());
  return {{"prefetch", means.prefetch},
          {"adapt_levels", means.adapt_levels},
          {"budget_ms", budget_ms},
          {"first_picture_ms", first},
          {"frame_ms_median", percentile(times, 0.5)},
          {"frame_ms_95th", percentile(times, 0.95)},
          {"frame_ms_worst", percentile(times, 1)},
          {"lacking_mean", mean_lacking},
          {"lacking_median", percentile(lacking, 0.5)},
          {"lacking_95th", percentile(lacking, 0.95)},
          {"psnr_median", percentile(decibels, 0.5)},
          {"psnr_5th", percentile(decibels, 0.05)},
          {"exact_after_stop_ms", exact_after_stop},
          {"stages_ms", std::move(stages_ms)}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::fprintf(stderr, "usage: gvx_bench_path STORE.gvx [BUDGET_MS]\n");
    return 2;
  }
  const double budget_ms = argc > 2 ? std::atof(argv[2]) : 50;
  ExactPictures exact;
  nlohmann::json runs = nlohmann::json::array();
  for (const Means means : {Means{false, false}, Means{true, false}, Means{true, true}}) {
    runs.push_back(bench_path(argv[1], budget_ms, means, exact));
  }
  const nlohmann::json result = {{"store", argv[1]}, {"far", bench_far(argv[1])}, {"path", runs}};
  std::cout << result.dump(2) << '\n';
  return 0;
}
