// gvx's frames for bench/peers: the finest level, one sample a voxel, everything resident.
//
//     gvx_peers_gvx STORE.gvx THREADS [narrow] [levels]
//
// narrow: without vectors of AVX-512.
// levels: as it comes, of levels of detail, pre-integrated, two samples a voxel.
// Else samples are classified as the peers classify theirs; GVX_PEERS_CLASSIFICATION=preintegrated shows
// gvx's own way.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <hwy/targets.h>

#include "frames.h"
#include "gvx/engine/engine.h"
#include "gvx/produce/store_producer.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;

class GvxSystem : public bench::PeerSystem {
 public:
  static Result<std::unique_ptr<GvxSystem>> open(const std::string& path, int threads, bool levels) {
    GVX_ASSIGN(auto reader, store::StoreReader::open(path));
    const Vec3i size = reader->info().shape.dimensions;
    auto producer = std::make_shared<produce::StoreProducer>(std::move(reader));
    GVX_ASSIGN(auto engine,
               engine::Engine::create(exec::Device::cpu(threads), std::move(producer), {4ull << 30, {}}));
    return std::unique_ptr<GvxSystem>(new GvxSystem(std::move(engine), Vec3d(size), levels));
  }

  Status look(const bench::PeerView& view) override {
    view_.width = view.width;
    view_.height = view.height;
    view_.functions = {view.function};
    view_.lighting = view.lighting;
    view_.level_of_detail = levels_;
    if (!levels_) {
      view_.samples_per_voxel = 1;
      const char* classification = std::getenv("GVX_PEERS_CLASSIFICATION");
      const bool own_way = classification != nullptr && std::string(classification) == "preintegrated";
      view_.classification = own_way ? scene::Classification::preintegrated : scene::Classification::post;
    }
    // VTK casts between the centres of the outermost voxels: so do all.
    view_.clip = {Vec3d(0.5) / size_, Vec3d(1) - Vec3d(0.5) / size_};
    for (const scene::Camera& camera : {view.camera, bench::moved_aside(view.camera)}) {
      view_.camera = camera;
      GVX_TRY(engine_->look(view_));
      GVX_TRY(engine_->render_exact());
    }
    return {};
  }

  Result<double> frame(const scene::Camera& camera) override {
    view_.camera = camera;
    const auto start = std::chrono::steady_clock::now();
    GVX_TRY(engine_->look(view_));
    GVX_TRY(engine_->render_exact());
    const auto end = std::chrono::steady_clock::now();
    const engine::Statistics statistics = engine_->statistics();
    if (statistics.bricks_produced != 0 || statistics.passes != 1) {
      return Error{"gvx: " + std::to_string(statistics.bricks_produced) + " bricks were made in " +
                   std::to_string(statistics.passes) + " passes of a warm frame"};
    }
    return std::chrono::duration<double, std::milli>(end - start).count();
  }

  std::vector<std::uint8_t> rgb() const override {
    const std::vector<std::uint8_t> rgba = engine_->picture().to_8_bit();
    std::vector<std::uint8_t> rgb;
    for (std::size_t i = 0; i < rgba.size(); i += 4) rgb.insert(rgb.end(), &rgba[i], &rgba[i + 3]);
    return rgb;
  }

 private:
  GvxSystem(std::unique_ptr<engine::Engine> engine, Vec3d size, bool levels)
      : engine_(std::move(engine)), size_(size), levels_(levels) {}

  std::unique_ptr<engine::Engine> engine_;
  Vec3d size_;  // voxels
  bool levels_;
  render::View view_;
};

}  // namespace

int main(int argc, char** argv) {
  bool narrow = false, levels = false, understood = argc >= 3;
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    narrow = narrow || word == "narrow";
    levels = levels || word == "levels";
    understood = understood && (word == "narrow" || word == "levels");
  }
  if (!understood) {
    std::fprintf(stderr, "usage: gvx_peers_gvx STORE.gvx THREADS [narrow] [levels]\n");
    return 2;
  }
  if (narrow) hwy::DisableTargets(HWY_AVX3 | HWY_AVX3_DL);
  auto system = GvxSystem::open(argv[1], std::atoi(argv[2]), levels);
  if (!system.ok()) {
    std::fprintf(stderr, "%s\n", system.error().message.c_str());
    return 1;
  }
  return bench::serve(*system.value());
}
