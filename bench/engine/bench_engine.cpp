// What does the engine do for one store and view? Prints JSON:
//   exact     a cold exact frame: time, bricks made, passes
//   need      bricks made against the bricks that hold a sample which adds to the picture, found by marching
//   every ray
//             at twice the sampling, without level of detail
//   budget    frames of a turning camera: how far each exceeded its time
//   rest      budget frames from a cold cache until the picture is exact
//
//     gvx_bench_engine STORE.gvx [WIDTH HEIGHT [BUDGET_MS]]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>
#include <vector>

#include "gvx/engine/engine.h"
#include "gvx/produce/store_producer.h"
#include "gvx/scene/framing.h"
#include "gvx/scene/transfer_presets.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;
using Milliseconds = std::chrono::duration<double, std::milli>;

std::shared_ptr<const produce::Producer> open(const char* path) {
  auto reader = store::StoreReader::open(path);
  if (!reader.ok()) {
    std::fprintf(stderr, "%s\n", reader.error().message.c_str());
    std::exit(1);
  }
  return std::make_shared<produce::StoreProducer>(std::move(reader).value());
}

std::unique_ptr<engine::Engine> cold_engine(const char* path, const render::View& view) {
  auto engine = engine::Engine::create(exec::Device::cpu(), open(path), {4ull << 30, {}}).value();
  GVX_CHECK(engine->look(view).ok());
  return engine;
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

nlohmann::json bench_exact(const char* path, const render::View& view) {
  std::vector<double> cold, warm;
  engine::Statistics statistics;
  for (int run = 0; run < 3; ++run) {
    const auto engine = cold_engine(path, view);
    GVX_CHECK(engine->render_exact().ok());
    statistics = engine->statistics();
    cold.push_back(statistics.frame_milliseconds);
    render::View again = view;
    again.background.x += 0.5f;  // the same rays anew
    GVX_CHECK(engine->look(again).ok());
    GVX_CHECK(engine->render_exact().ok());
    warm.push_back(engine->statistics().frame_milliseconds);
  }
  return {{"cold_ms", median(cold)},
          {"warm_ms", median(warm)},
          {"bricks", statistics.bricks_produced},
          {"passes", statistics.passes},
          {"samples", statistics.samples}};
}

/// Marches every ray of the view over whole bricks of the finest level.
std::size_t necessary_bricks(const char* path, const render::View& view) {
  const auto reader = store::StoreReader::open(path).value();
  const store::VolumeInfo& info = reader->info();
  const std::int64_t m = info.shape.m, edge = m + 2 * kBrickBorder;
  const Vec3d size(info.shape.dimensions);
  using Key = std::tuple<std::int64_t, std::int64_t, std::int64_t>;
  std::map<Key, std::vector<float>> bricks;
  const auto brick_of = [&](const Key& key) -> const std::vector<float>& {
    auto& voxels = bricks[key];
    if (voxels.empty()) {
      const NodeKey node{info.shape.levels - 1, static_cast<std::uint32_t>(std::get<0>(key)),
                         static_cast<std::uint32_t>(std::get<1>(key)),
                         static_cast<std::uint32_t>(std::get<2>(key))};
      std::vector<std::byte> bytes(info.brick_bytes());
      GVX_CHECK(reader->read_brick(node, reader->node(node).value(), bytes).ok());
      with_voxel_type(info.format.type, [&](auto v) {
        for (std::size_t i = 0; i < plane_texels(info.shape.m); ++i) {
          std::memcpy(&v, &bytes[i * sizeof(v)], sizeof(v));
          voxels.push_back(static_cast<float>(info.scale * double(v) + info.offset));
        }
      });
    }
    return voxels;
  };
  const auto camera = scene::make_view(view.camera, view.width, view.height).value();
  const Affine3 to_voxel = inverse(info.voxel_to_world);
  const Affine3& place = info.voxel_to_world;
  const double spacing =
      std::min({length(place.column[0]), length(place.column[1]), length(place.column[2])});
  const double step = spacing / 4;
  std::set<Key> necessary;
  for (std::uint32_t y = 0; y < view.height; ++y) {
    for (std::uint32_t x = 0; x < view.width; ++x) {
      const Ray world = camera.pixel_ray(x, y);
      const Ray ray{to_voxel.point(world.origin), to_voxel.vector(world.direction)};
      const RayInterval inside = intersect(ray, {{0, 0, 0}, size}, 0, 1e300);
      double left = 1;
      for (double t = inside.enter + step / 2; !inside.empty() && t < inside.exit && left > 1e-3; t += step) {
        const Vec3d p = ray.at(t);
        const auto index = [&](int axis) {
          return std::clamp<std::int64_t>(static_cast<std::int64_t>(p[axis]), 0,
                                          info.shape.dimensions[axis] - 1) /
                 m;
        };
        const Key key{index(0), index(1), index(2)};
        const auto& voxels = brick_of(key);
        const Vec3d q =
            p - Vec3d(Vec3i(std::get<0>(key), std::get<1>(key), std::get<2>(key)) * m) + Vec3d(0.5);
        const auto low = [&](int axis) {
          return std::clamp<std::int64_t>(static_cast<std::int64_t>(q[axis]), 0, m);
        };
        double value = 0;
        for (int c = 0; c < 8; ++c) {
          std::int64_t at[3];
          double w = 1;
          for (int axis = 0; axis < 3; ++axis) {
            const bool high = (c >> axis & 1) != 0;
            const double f = q[axis] - static_cast<double>(low(axis));
            at[axis] = low(axis) + (high ? 1 : 0) + kBrickBorder - 1;
            w *= high ? f : 1 - f;
          }
          value += w * voxels[static_cast<std::size_t>(at[0] + edge * (at[1] + edge * at[2]))];
        }
        const double opacity = view.functions[0].opacity(value);
        if (opacity <= 0) continue;
        necessary.insert(key);
        left *= std::pow(1 - opacity, step / spacing);
      }
    }
  }
  return necessary.size();
}

nlohmann::json bench_need(const char* path, render::View view) {
  view.level_of_detail = false;
  const auto engine = cold_engine(path, view);
  GVX_CHECK(engine->render_exact().ok());
  const auto made = engine->statistics().bricks_produced;
  const std::size_t necessary = necessary_bricks(path, view);
  return {{"made", made}, {"necessary", necessary}, {"ratio", double(made) / double(necessary)}};
}

/// The camera turned about the target's vertical.
scene::Camera turned(scene::Camera camera, double radians) {
  const Vec3d d = camera.eye - camera.target;
  camera.eye = camera.target + Vec3d{d.x * std::cos(radians) - d.y * std::sin(radians),
                                     d.x * std::sin(radians) + d.y * std::cos(radians), d.z};
  return camera;
}

nlohmann::json bench_budget(const char* path, render::View view, double budget_ms) {
  const auto budget = std::chrono::nanoseconds(static_cast<std::int64_t>(budget_ms * 1e6));
  const auto engine = cold_engine(path, view);
  std::vector<double> times, shares;
  for (int frame = 0; frame < 120; ++frame) {
    render::View moved = view;
    moved.camera = turned(view.camera, 0.01 * frame);
    const auto start = std::chrono::steady_clock::now();
    GVX_CHECK(engine->look(moved).ok());
    GVX_CHECK(engine->render_for(budget).ok());
    times.push_back(Milliseconds(std::chrono::steady_clock::now() - start).count());
    shares.push_back(engine->statistics().resident_share);
  }
  std::vector<double> sorted = times;
  std::sort(sorted.begin(), sorted.end());
  return {{"budget_ms", budget_ms},
          {"frame_ms_median", sorted[sorted.size() / 2]},
          {"frame_ms_95th", sorted[sorted.size() * 95 / 100]},
          {"frame_ms_worst", sorted.back()},
          {"first_frame_share", shares.front()},
          {"last_frame_share", shares.back()}};
}

nlohmann::json bench_rest(const char* path, const render::View& view, double budget_ms) {
  const auto budget = std::chrono::nanoseconds(static_cast<std::int64_t>(budget_ms * 1e6));
  const auto start = std::chrono::steady_clock::now();
  const auto engine = cold_engine(path, view);
  int frames = 0;
  double first = 0;
  do {
    GVX_CHECK(engine->render_for(budget).ok());
    if (frames++ == 0) first = Milliseconds(std::chrono::steady_clock::now() - start).count();
  } while (!engine->statistics().converged && frames < 100000);
  return {{"frames", frames},
          {"first_picture_ms", first},
          {"exact_ms", Milliseconds(std::chrono::steady_clock::now() - start).count()}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 5) {
    std::fprintf(stderr, "usage: gvx_bench_engine STORE.gvx [WIDTH HEIGHT [BUDGET_MS]]\n");
    return 2;
  }
  const char* path = argv[1];
  const produce::TreeDescription tree = open(path)->description();
  render::View view;
  view.width = argc > 3 ? static_cast<std::uint32_t>(std::atoi(argv[2])) : 640;
  view.height = argc > 3 ? static_cast<std::uint32_t>(std::atoi(argv[3])) : 480;
  const double budget_ms = argc > 4 ? std::atof(argv[4]) : 33;
  view.camera = scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical,
                                 double(view.width) / view.height, 0.95);
  const scene::ValueStatistics statistics =
      scene::physical_statistics(tree.ranges.channel[0], tree.histograms[0], tree.scale, tree.offset);
  view.functions = {scene::preset(scene::suggest_preset(statistics), statistics).value()};
  const nlohmann::json result = {{"store", path},
                                 {"exact", bench_exact(path, view)},
                                 {"need", bench_need(path, view)},
                                 {"budget", bench_budget(path, view, budget_ms)},
                                 {"rest", bench_rest(path, view, budget_ms)}};
  std::cout << result.dump(2) << '\n';
  return 0;
}
