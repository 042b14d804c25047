// A producer of one's own, from nothing: balls without number on a lattice, each of a size of its own. What a
// producer must do is in produce/producer.h; docs/write-a-producer.md goes through this one.
//
//     lattice_of_balls OUT.png

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <gvx/core/noise.h>
#include <gvx/engine/engine.h>
#include <gvx/io/image.h>
#include <gvx/produce/producer.h>
#include <gvx/scene/transfer_presets.h>

// [producer]
class LatticeOfBalls final : public gvx::produce::Producer {
 public:
  LatticeOfBalls() {
    tree_.max_level = 10;     // 16 * 2^10 voxels along an axis
    tree_.scale = 1.0 / 255;  // bytes that mean 0 to 1
    tree_.ranges = gvx::ValueRange{0, 255};
  }
  const gvx::produce::TreeDescription& description() const override { return tree_; }

  gvx::Status describe(std::span<const gvx::NodeKey> keys,
                       std::span<gvx::tree::NodeInfo> infos) const override {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const double nodes = gvx::nodes_across(2, keys[i].level), voxel = 1 / (nodes * tree_.m);
      const gvx::Vec3d middle = (gvx::corner(keys[i]) + gvx::Vec3d(0.5)) / nodes;
      // From the middle to the corners of the node and its rim of two voxels; as far as a voxel is soft.
      const double reach = std::sqrt(3.0) * (0.5 / nodes + 2 * voxel) + 2 * voxel, d = distance(middle);
      const gvx::ValueRange range = d > reach    ? gvx::ValueRange{0, 0}
                                    : d < -reach ? gvx::ValueRange{255, 255}
                                                 : gvx::ValueRange{0, 255};
      infos[i] = {range, keys[i].level == tree_.max_level};
    }
    return {};
  }

  gvx::Status produce(const gvx::NodeKey& key, std::span<std::byte> voxels) const override {
    const int m = static_cast<int>(tree_.m), border = gvx::kBrickBorder;
    const double voxel = 1 / (gvx::nodes_across(2, key.level) * m);
    const gvx::Vec3d first = double(m) * gvx::corner(key) + gvx::Vec3d(0.5);
    std::size_t i = 0;
    for (int z = -border; z < m + border; ++z) {
      for (int y = -border; y < m + border; ++y) {
        for (int x = -border; x < m + border; ++x) {
          const gvx::Vec3d p = voxel * (first + gvx::Vec3d(x, y, z));
          const double covered = std::clamp(0.5 - distance(p) / (2 * voxel), 0.0, 1.0);
          voxels[i++] = static_cast<std::byte>(std::lround(255 * covered));
        }
      }
    }
    return {};
  }

 private:
  // To the surface of the nearest ball; below 0 inside.
  static double distance(gvx::Vec3d p) {
    constexpr double kCells = 4;
    double least = INFINITY;
    for (int i = 0; i < 27; ++i) {  // a place is nearest to a ball of its own cell or of one around
      const auto cell = [&](double v, int shift) { return std::floor(v * kCells) + shift; };
      const gvx::Vec3d at(cell(p.x, i % 3 - 1), cell(p.y, i / 3 % 3 - 1), cell(p.z, i / 9 - 1));
      const gvx::Vec3i whole(at);
      const double size = 0.15 + 0.015 * gvx::noise::gradient_at(whole.x, whole.y, whole.z, 1);
      least = std::min(least, (length(kCells * p - at - gvx::Vec3d(0.5)) - size) / kCells);
    }
    return least;
  }

  gvx::produce::TreeDescription tree_;
};
// [producer]

static gvx::Status run(const char* picture) {
  const auto producer = std::make_shared<LatticeOfBalls>();
  GVX_ASSIGN(const auto engine, gvx::engine::Engine::create(gvx::exec::Device::cpu(), producer, {}));
  gvx::render::View view;
  view.width = view.height = 400;
  view.detail = 1;
  view.camera = gvx::scene::frame_box(producer->description().extent, {}, false, 1);
  GVX_ASSIGN(const auto function, gvx::scene::preset("solid", {0, 1, {}}));
  view.functions = {function};
  GVX_TRY(engine->look(view));
  GVX_TRY(engine->render_exact());
  std::printf("%s: %llu bricks were made\n", picture,
              static_cast<unsigned long long>(engine->statistics().bricks_produced));
  return gvx::io::write_png(picture, view.width, view.height, engine->picture().to_8_bit());
}

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: lattice_of_balls OUT.png\n"), 2;
  const gvx::Status status = run(argv[1]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
