// NanoVDB's frames for bench/peers: a ray caster as its users write them. A grid of floats; nanovdb::HDDA
// leaps over nodes whose skip bit is set, as those are where the function shows nothing; the library's own
// trilinear sampler and the gradient of its cell; oneTBB over tiles of pixels; a ray ends as gvx's do. (The
// sampler that caches a cell was slower: a step of a voxel leaves the cell.)
//
//     gvx_peers_nanovdb FILE.raw SIZE THREADS          SIZE^3 u8 voxels

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <vector>

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/NodeManager.h>
#include <nanovdb/util/Ray.h>
#include <nanovdb/util/SampleFromVoxels.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "frames.h"

namespace {

using namespace gvx;
using Vector = nanovdb::Vec3f;
using Clock = std::chrono::steady_clock;

constexpr int kLeaf = 8;                    // voxels along a leaf
constexpr int kEntries = 4096;              // of the table of the function
constexpr int kTile = 16;                   // pixels
constexpr float kOpaque = 1 - 1.0f / 1024;  // gvx's

/// The voxels as they are in the file.
struct Voxels {
  int size = 0;
  std::vector<std::uint8_t> value;

  std::uint8_t at(int x, int y, int z) const {
    return value[(static_cast<std::size_t>(z) * size + y) * size + x];
  }
};

Result<Voxels> read_voxels(const std::string& path, int size) {
  Voxels voxels{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size) * size * size)};
  std::ifstream in(path, std::ios::binary);
  const auto bytes = static_cast<std::streamsize>(voxels.value.size());
  if (!in.read(reinterpret_cast<char*>(voxels.value.data()), bytes)) {
    return Error{path + ": does not hold " + std::to_string(bytes) + " bytes"};
  }
  return voxels;
}

/// Of all cells whose lower corner is in a leaf: they reach a voxel beyond it.
struct LeafRange {
  std::uint8_t minimum = 255, maximum = 0;
};

LeafRange range_of(const Voxels& voxels, nanovdb::Coord origin) {
  LeafRange range;
  const auto end = [&](int axis) { return std::min(origin[axis] + kLeaf + 1, voxels.size); };
  for (int z = origin[2]; z < end(2); ++z) {
    for (int y = origin[1]; y < end(1); ++y) {
      for (int x = origin[0]; x < end(0); ++x) {
        range.minimum = std::min(range.minimum, voxels.at(x, y, z));
        range.maximum = std::max(range.maximum, voxels.at(x, y, z));
      }
    }
  }
  return range;
}

/// A grid whose tiles are of one value to a voxel beyond their upper faces, so that no cell of a tile needs
/// another's voxels.
nanovdb::GridHandle<> build_grid(const Voxels& voxels) {
  nanovdb::GridBuilder<float> builder(0.0f);
  builder([&](const nanovdb::Coord& p) { return static_cast<float>(voxels.at(p[0], p[1], p[2])); },
          nanovdb::CoordBBox(nanovdb::Coord(0), nanovdb::Coord(voxels.size - 1)));
  auto accessor = builder.getAccessor();
  for (int z = 0; z < voxels.size; z += kLeaf) {
    for (int y = 0; y < voxels.size; y += kLeaf) {
      for (int x = 0; x < voxels.size; x += kLeaf) {
        const nanovdb::Coord origin(x, y, z);
        const LeafRange range = range_of(voxels, origin);
        if (range.minimum != range.maximum) accessor.setValue(origin, voxels.at(x, y, z));
      }
    }
  }
  builder.setStats(nanovdb::StatsMode::BBox);
  builder.setChecksum(nanovdb::ChecksumMode::Disable);
  return builder.getHandle<>();
}

/// The function at one value: opacity of a step and colour.
struct Matter {
  Vector color{0.0f};
  float opacity = 0;
};

struct Pixel {
  Vector color{0.0f};
  float opacity = 0;
};

class NanoSystem : public bench::PeerSystem {
 public:
  NanoSystem(const Voxels& voxels, int threads)
      : size_(voxels.size), handle_(build_grid(voxels)), grid_(handle_.grid<float>()), arena_(threads) {
    leaves_across_ = (size_ + kLeaf - 1) / kLeaf;
    for (int z = 0; z < size_; z += kLeaf) {
      for (int y = 0; y < size_; y += kLeaf) {
        for (int x = 0; x < size_; x += kLeaf) {
          ranges_.push_back(range_of(voxels, {x, y, z}));
        }
      }
    }
  }

  Status look(const bench::PeerView& view) override {
    view_ = view;
    table_.resize(kEntries + 1);
    for (int i = 0; i <= kEntries; ++i) {
      const double value = 255.0 * i / kEntries;
      const Vec3f color(view.function.color(value));
      table_[static_cast<std::size_t>(i)] = {{color.x, color.y, color.z},
                                             static_cast<float>(view.function.opacity(value))};
    }
    glint_.resize(kEntries + 1);
    for (int i = 0; i <= kEntries; ++i) {
      const float cosine = static_cast<float>(i) / kEntries;
      glint_[static_cast<std::size_t>(i)] =
          view.lighting.specular * std::pow(cosine, view.lighting.shininess);
    }
    double low = 255, high = 0;  // of the values that the function tells apart
    const auto widen = [&](double value) {
      low = std::min(low, value);
      high = std::max(high, value);
    };
    for (const auto& point : view.function.colors) widen(point.value);
    for (const auto& point : view.function.opacities) widen(point.value);
    soft_ = static_cast<float>((high - low) * scene::kSoftGradient);
    mark_skipped();
    pixels_.assign(static_cast<std::size_t>(view.width) * view.height, {});
    return {};
  }

  Result<double> frame(const scene::Camera& camera) override {
    GVX_ASSIGN(const scene::CameraView rays, scene::make_view(camera, view_.width, view_.height));
    const auto start = Clock::now();
    arena_.execute([&] {
      tbb::parallel_for(
          tbb::blocked_range2d<int>(0, int(view_.height), kTile, 0, int(view_.width), kTile),
          [&](const tbb::blocked_range2d<int>& tile) {
            view_.lighting.enabled ? draw<true>(rays, tile) : draw<false>(rays, tile);
          },
          tbb::simple_partitioner());
    });
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

  std::vector<std::uint8_t> rgb() const override {
    std::vector<std::uint8_t> bytes;
    for (const Pixel& pixel : pixels_) {
      for (int i = 0; i < 3; ++i) {
        bytes.push_back(static_cast<std::uint8_t>(std::clamp(pixel.color[i], 0.0f, 1.0f) * 255 + 0.5f));
      }
    }
    return bytes;
  }

 private:
  using Accessor = nanovdb::DefaultReadAccessor<float>;
  using Sampler = nanovdb::TrilinearSampler<Accessor>;

  /// Sets the bit that has Accessor::getDim leap over a node where no cell of it shows anything.
  void mark_skipped() {
    auto nodes = nanovdb::createNodeManager(*grid_);
    auto& manager = *nodes.template mgr<float>();
    std::vector<bool> leaf_shows(ranges_.size());
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      leaf_shows[i] = !view_.function.transparent(ranges_[i].minimum, ranges_[i].maximum);
    }
    const auto shows = [&](nanovdb::Coord origin, int across) {
      const int end = leaves_across_;
      const auto first = [&](int axis) { return origin[axis] / kLeaf; };
      const auto last = [&](int axis) { return std::min(first(axis) + across / kLeaf, end); };
      for (int z = first(2); z < last(2); ++z) {
        for (int y = first(1); y < last(1); ++y) {
          for (int x = first(0); x < last(0); ++x) {
            if (leaf_shows[static_cast<std::size_t>((z * end + y) * end + x)]) return true;
          }
        }
      }
      return false;
    };
    const auto set = [](auto& flags, bool skip) {
      using Flags = std::remove_reference_t<decltype(flags)>;
      flags = static_cast<Flags>(skip ? flags | 1u : flags & ~1u);
    };
    for (std::uint32_t i = 0; i < manager.nodeCount(0); ++i) {
      auto& leaf = manager.leaf(i);
      set(leaf.data()->mFlags, !shows(leaf.origin(), kLeaf));
    }
    for (std::uint32_t i = 0; i < manager.nodeCount(1); ++i) {
      auto& lower = manager.lower(i);
      set(lower.data()->mFlags, !shows(lower.origin(), int(nanovdb::NanoLower<float>::DIM)));
    }
    for (std::uint32_t i = 0; i < manager.nodeCount(2); ++i) set(manager.upper(i).data()->mFlags, false);
  }

  template <bool kLit>
  void draw(const scene::CameraView& rays, const tbb::blocked_range2d<int>& tile) {
    const Accessor accessor = grid_->getAccessor();
    const Sampler sampler(accessor);
    const Vec3f back(-rays.forward);
    const Vector to_light(back.x, back.y, back.z);
    for (int y = tile.rows().begin(); y < tile.rows().end(); ++y) {
      for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) {
        pixels_[static_cast<std::size_t>(y) * view_.width + static_cast<std::size_t>(x)] =
            cast<kLit>(accessor, sampler, rays.pixel_ray(x, y), to_light);
      }
    }
  }

  /// Steps of one voxel, sampled at their centres, from where the ray enters the box of the voxels' centres.
  template <bool kLit>
  Pixel cast(const Accessor& accessor, const Sampler& sampler, const Ray& world,
             const Vector& to_light) const {
    Pixel pixel;
    const RayInterval inside = intersect(world, {Vec3d(0), Vec3d(size_ - 1)}, 0, 1e300);
    if (inside.empty()) return pixel;
    const Vec3f from(world.at(inside.enter)), along(world.direction);
    const float length = static_cast<float>(inside.exit - inside.enter);
    const nanovdb::Ray<float> ray({from.x, from.y, from.z}, {along.x, along.y, along.z}, 0.0f, length);
    nanovdb::HDDA<nanovdb::Ray<float>> hdda(ray, kLeaf);
    float t = 0.5f;
    do {
      const int dim = static_cast<int>(accessor.getDim(hdda.voxel(), ray));
      hdda.update(ray, std::max(dim, kLeaf));
      const float end = hdda.next();
      // A node of many voxels is one to skip, or a tile of one value.
      if (dim > 1 && !(opacity_of(accessor.getValue(hdda.voxel())) > 0)) {
        t += std::max(0.0f, std::ceil(end - t));
        continue;
      }
      for (; t < end; t += 1.0f) {
        add<kLit>(sampler, ray(t), ray.dir(), to_light, pixel);
        if (pixel.opacity >= kOpaque) return pixel;
      }
    } while (hdda.step());
    return pixel;
  }

  float opacity_of(float value) const { return matter_of(value).opacity; }
  const Matter& matter_of(float value) const {
    return table_[static_cast<std::size_t>(value * (kEntries / 255.0f) + 0.5f)];
  }

  /// Puts a sample behind what was gathered, lit as scene::LightingView::shade does.
  template <bool kLit>
  void add(const Sampler& sampler, const Vector& place, const Vector& ahead, const Vector& to_light,
           Pixel& pixel) const {
    // The cell's voxels are fetched once, for value and gradient.
    float cell[2][2][2];
    Vector within = place;
    auto low = nanovdb::Floor<nanovdb::Coord>(within);
    sampler.stencil(low, cell);
    const Matter& matter = matter_of(Sampler::sample(within, cell));
    if (!(matter.opacity > 0)) return;
    Vector color = matter.color;
    if constexpr (kLit) {
      const Vector gradient = Sampler::gradient(within, cell);
      const float square = gradient.lengthSqr();
      float facing = 1, glint = 0;
      if (square > 0) {
        const float certainty = square / (square + soft_ * soft_);
        const Vector normal = gradient * (1 / std::sqrt(square));
        Vector half = to_light - ahead;
        half = half * (1 / half.length());
        const float mirrored = std::min(std::fabs(normal.dot(half)), 1.0f);
        facing = 1 + certainty * (std::fabs(normal.dot(to_light)) - 1);
        glint = certainty * glint_[static_cast<std::size_t>(mirrored * kEntries + 0.5f)];
      }
      const scene::Lighting& light = view_.lighting;
      color = color * (light.ambient + light.diffuse * facing) + Vector(glint);
    }
    const float weight = (1 - pixel.opacity) * matter.opacity;
    pixel.color += color * weight;
    pixel.opacity += weight;
  }

  int size_, leaves_across_ = 0;
  std::vector<LeafRange> ranges_;  // of the leaves' cells, x fastest
  nanovdb::GridHandle<> handle_;
  nanovdb::NanoGrid<float>* grid_;
  tbb::task_arena arena_;
  bench::PeerView view_;
  std::vector<Matter> table_;
  std::vector<float> glint_;  // by the cosine between normal and half vector
  float soft_ = 0;            // gradient of matter that is half a surface, as gvx takes it
  std::vector<Pixel> pixels_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: gvx_peers_nanovdb FILE.raw SIZE THREADS\n");
    return 2;
  }
  auto voxels = read_voxels(argv[1], std::atoi(argv[2]));
  if (!voxels.ok()) {
    std::fprintf(stderr, "%s\n", voxels.error().message.c_str());
    return 1;
  }
  NanoSystem system(voxels.value(), std::atoi(argv[3]));
  return bench::serve(system);
}
