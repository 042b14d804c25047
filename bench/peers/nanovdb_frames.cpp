// NanoVDB's frames for bench/peers: a ray caster as its users write them. A grid of floats; nanovdb::HDDA
// leaps over nodes whose skip bit is set, as those are where the function shows nothing; the library's own
// trilinear sampler and the gradient of its cell; oneTBB over tiles of pixels; a ray ends as gvx's do. (The
// sampler that caches a cell was slower: a step of a voxel leaves the cell.)
//
//     gvx_peers_nanovdb FILE.raw SIZE THREADS          SIZE^3 u8 voxels

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/NodeManager.h>
#include <nanovdb/util/Ray.h>
#include <nanovdb/util/SampleFromVoxels.h>

#include "ray_caster.h"

namespace {

using namespace gvx;
using bench::Voxels;
using Vector = nanovdb::Vec3f;

constexpr int kLeaf = 8;  // voxels along a leaf

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

class NanoCaster : public bench::RayCaster {
 public:
  NanoCaster(const Voxels& voxels, int threads)
      : RayCaster(voxels.size, threads),
        leaves_across_((voxels.size + kLeaf - 1) / kLeaf),
        handle_(build_grid(voxels)),
        grid_(handle_.grid<float>()) {
    for (int z = 0; z < voxels.size; z += kLeaf) {
      for (int y = 0; y < voxels.size; y += kLeaf) {
        for (int x = 0; x < voxels.size; x += kLeaf) {
          ranges_.push_back(range_of(voxels, {x, y, z}));
        }
      }
    }
  }

 private:
  using Accessor = nanovdb::DefaultReadAccessor<float>;
  using Sampler = nanovdb::TrilinearSampler<Accessor>;

  /// Sets the bit that has Accessor::getDim leap over a node where no cell of it shows anything.
  void prepare() override {
    auto nodes = nanovdb::createNodeManager(*grid_);
    auto& manager = *nodes.template mgr<float>();
    std::vector<bool> leaf_shows(ranges_.size());
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      leaf_shows[i] = !view().function.transparent(ranges_[i].minimum, ranges_[i].maximum);
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

  void draw(const scene::CameraView& rays, const Tile& tile) override {
    view().lighting.enabled ? draw_all<true>(rays, tile) : draw_all<false>(rays, tile);
  }
  template <bool kLit>
  void draw_all(const scene::CameraView& rays, const Tile& tile) {
    const Accessor accessor = grid_->getAccessor();
    const Sampler sampler(accessor);
    const Vec3f to_light(-rays.forward);
    for (int y = tile.rows().begin(); y < tile.rows().end(); ++y) {
      for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) {
        pixel(x, y) = cast<kLit>(accessor, sampler, way(rays, x, y), to_light);
      }
    }
  }

  template <bool kLit>
  Pixel cast(const Accessor& accessor, const Sampler& sampler, const Way& way, const Vec3f& to_light) const {
    Pixel pixel;
    if (!(way.length > 0)) return pixel;
    const nanovdb::Ray<float> ray({way.from.x, way.from.y, way.from.z},
                                  {way.along.x, way.along.y, way.along.z}, 0.0f, way.length);
    nanovdb::HDDA<nanovdb::Ray<float>> hdda(ray, kLeaf);
    float t = 0.5f;
    do {
      const int dim = static_cast<int>(accessor.getDim(hdda.voxel(), ray));
      hdda.update(ray, std::max(dim, kLeaf));
      const float end = hdda.next();
      // A node of many voxels is one to skip, or a tile of one value.
      if (dim > 1 && !(matter_of(accessor.getValue(hdda.voxel())).opacity > 0)) {
        t += std::max(0.0f, std::ceil(end - t));
        continue;
      }
      for (; t < end; t += 1.0f) {
        see<kLit>(sampler, ray(t), way.along, to_light, pixel);
        if (pixel.opacity >= kOpaque) return pixel;
      }
    } while (hdda.step());
    return pixel;
  }

  template <bool kLit>
  void see(const Sampler& sampler, const Vector& place, const Vec3f& ahead, const Vec3f& to_light,
           Pixel& pixel) const {
    // The cell's voxels are fetched once, for value and gradient.
    float cell[2][2][2];
    Vector within = place;
    auto low = nanovdb::Floor<nanovdb::Coord>(within);
    sampler.stencil(low, cell);
    const Matter& matter = matter_of(Sampler::sample(within, cell));
    if (!(matter.opacity > 0)) return;
    if constexpr (kLit) {
      const Vector g = Sampler::gradient(within, cell);
      add(lit(matter.color, {g[0], g[1], g[2]}, ahead, to_light), matter.opacity, pixel);
    } else {
      add(matter.color, matter.opacity, pixel);
    }
  }

  int leaves_across_;
  std::vector<LeafRange> ranges_;  // of the leaves' cells, x fastest
  nanovdb::GridHandle<> handle_;
  nanovdb::NanoGrid<float>* grid_;
};

}  // namespace

int main(int argc, char** argv) {
  return bench::serve_caster<NanoCaster>(argc, argv);
}
