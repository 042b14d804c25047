// How near is the renderer to the processor's limit? Samples per second of the compositing of one brick that
// stays in the nearest cache, every lane of the vectors busy: the roof; and of whole warm frames, as a share
// of the roof before and behind each, since machines change: medians of several. One thread, finest level,
// two samples a voxel. Prints a markdown table.
//
//     gvx_bench_limits STORE.gvx [SIZE [FRAMES]]

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "gvx/engine/engine.h"
#include "gvx/produce/store_producer.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/scene/framing.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

scene::TransferFunction translucent(double first, double last) {
  return {{{first, {0.2, 0.3, 0.9}}, {last, {1, 0.9, 0.7}}}, {{first, 0}, {last, 0.02}}, 0};
}

/// A brick of random voxels, and rays through all of it.
class Roof {
 public:
  Roof(const VoxelFormat& format, ValueRange range, std::uint32_t m)
      : m_(m), brick_(brick_bytes(format, m)), to_eye_(4 * kRays), gathered_(4 * kRays), samples_(kRays) {
    std::mt19937 random(1);
    with_voxel_type(format.type, [&](auto voxel) {
      for (std::size_t i = 0; i < plane_texels(m); ++i) {
        // A slope with little noise: neighbours are alike, as in data.
        const float share = float(i) / float(plane_texels(m)) + 0.03f * float(random() % 100) / 100;
        voxel = static_cast<decltype(voxel)>(range.minimum + share * (range.maximum - range.minimum) / 1.03f);
        std::memcpy(&brick_[i * sizeof(voxel)], &voxel, sizeof(voxel));
      }
    });
    batch_->m = m;
    batch_->units = 0.5f;
    batch_->fine.brick = brick_.data();
    batch_->fine.gradient_scale = 1;
    batch_->count = kRays;
    batch_->to_eye = reinterpret_cast<float(*)[4]>(to_eye_.data());
    batch_->gathered = reinterpret_cast<float(*)[4]>(gathered_.data());
    batch_->samples = samples_.data();
  }

  /// In samples a second, now.
  double measure(const render::FrameView& frame) {
    constexpr int kRepeats = 9;
    std::vector<double> rates;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      begin_rays();
      const auto start = std::chrono::steady_clock::now();
      render::composite_batch(frame, *batch_);
      const double seconds = seconds_since(start);
      rates.push_back(std::accumulate(samples_.begin(), samples_.end(), 0.0) / seconds);
    }
    return median(rates);
  }

 private:
  static constexpr std::uint32_t kEdge = exec::TileGrid::kTile, kRays = render::StretchBatch::kMost;

  void begin_rays() {
    for (std::uint32_t i = 0; i < kRays; ++i) {
      const float x = float(i % kEdge) / kEdge, y = float(i / kEdge) / kEdge;
      const float row[8] = {x * float(m_), y * float(m_),          0.25f, float(2 * m_), 0, 0,
                            0.5f,          std::bit_cast<float>(i)};
      std::copy_n(row, 8, batch_->fine.row[i]);
      batch_->length[i] = static_cast<std::uint8_t>(2 * m_);
      to_eye_[4 * i + 2] = -1;
    }
    std::fill(gathered_.begin(), gathered_.end(), 0.0f);
    std::fill(samples_.begin(), samples_.end(), 0);
  }

  std::uint32_t m_;
  std::vector<std::byte> brick_;
  std::vector<float> to_eye_, gathered_;
  std::vector<std::int32_t> samples_;
  std::unique_ptr<render::StretchBatch> batch_ = std::make_unique<render::StretchBatch>();
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: gvx_bench_limits STORE.gvx [SIZE [FRAMES]]\n");
    return 2;
  }
  const std::uint32_t size = argc > 2 ? static_cast<std::uint32_t>(std::atoi(argv[2])) : 1024;
  const int frames = argc > 3 ? std::atoi(argv[3]) : 5;
  auto reader = store::StoreReader::open(argv[1]);
  if (!reader.ok() || size == 0 || size > 16384 || frames < 1) {
    std::fprintf(stderr, "%s\n",
                 reader.ok() ? "SIZE or FRAMES: out of range" : reader.error().message.c_str());
    return 1;
  }
  auto producer = std::make_shared<produce::StoreProducer>(std::move(reader).value());
  const produce::TreeDescription tree = producer->description();
  const exec::Device cpu = exec::Device::cpu(1);
  const auto engine = engine::Engine::create(cpu, producer, {4ull << 30, {}}).value();
  render::View view;
  view.width = view.height = size;
  view.level_of_detail = false;
  const ValueRange range = tree.ranges.channel[0];
  const double first = tree.scale * range.minimum + tree.offset,
               last = tree.scale * range.maximum + tree.offset;
  const double middle = 0.5 * (first + last);
  scene::TransferFunction surface = translucent(first, last);
  surface.opacities = {{middle, 0}, {middle + 0.02 * (last - first), 0.9}};
  Roof roof(tree.format, range, static_cast<std::uint32_t>(tree.m));
  const scene::Camera framed = scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical, 1, 0.95);
  std::printf(
      "| function | light | roof, M samples/s | frame, ms | M samples | M samples/s | share "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const bool is_surface : {true, false}) {
    for (const bool lit : {false, true}) {
      view.functions = {is_surface ? surface : translucent(first, last)};
      view.lighting.enabled = lit;
      const auto roof_frame = render::Frame::make(cpu, view, tree);
      std::vector<double> times, limits, shares;
      double samples = 0, limit_before = 0;
      for (int frame = 0; frame <= frames; ++frame) {
        view.camera = framed;
        view.camera.eye.x += frame % 2 == 0 ? 0 : 1e-6 * length(framed.eye - framed.target);
        const auto start = std::chrono::steady_clock::now();
        if (!engine->look(view).ok() || !engine->render_exact().ok()) return 1;
        const double seconds = seconds_since(start), limit = roof.measure(roof_frame.value().view());
        samples = static_cast<double>(engine->statistics().samples);
        if (frame > 0) {
          times.push_back(seconds);
          limits.push_back(0.5 * (limit_before + limit));
          shares.push_back(samples / seconds / limits.back());
        }
        limit_before = limit;
      }
      std::printf("| %s | %s | %.0f | %.1f | %.1f | %.0f | %.2f |\n", is_surface ? "surface" : "translucent",
                  lit ? "lit" : "unlit", median(limits) / 1e6, 1e3 * median(times), samples / 1e6,
                  samples / median(times) / 1e6, median(shares));
      std::fflush(stdout);
    }
  }
  return 0;
}
