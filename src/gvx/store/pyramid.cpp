#include "gvx/store/pyramid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "gvx/exec/parallel.h"
#include "gvx/store/codec.h"

namespace gvx::store {
namespace {

constexpr std::size_t kBatch = 256;  // bricks compressed together before they are written in order

/// The 16 high bits of a float's or an integer's order-preserving image: fine bins without knowing the range.
std::size_t fine_bin(std::uint8_t v) {
  return v;
}
std::size_t fine_bin(std::uint16_t v) {
  return v;
}
std::size_t fine_bin(float v) {
  const auto bits = std::bit_cast<std::uint32_t>(v);
  return ((bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u) >> 16;
}

/// The least value of fine bin `bin`.
template <typename Voxel>
double fine_bin_value(std::size_t bin) {
  if constexpr (std::is_same_v<Voxel, float>) {
    const auto high = static_cast<std::uint32_t>(bin) << 16;
    return std::bit_cast<float>((high & 0x80000000u) != 0 ? high & 0x7fffffffu : ~high);
  } else {
    return static_cast<double>(bin);
  }
}

}  // namespace

/// All levels of one volume.
template <typename Voxel>
struct PyramidBuilder::Levels final : PyramidBuilder::Steps {
  struct Level {
    Vec3i dimensions, nodes, pages;
    std::vector<Voxel> window;  // slice z is at z % (m + 2)
    std::int64_t slices = 0;    // that have come
    std::int64_t layers = 0;    // of bricks that were written
    // Ranges of the children of this layer's nodes, joined, and of the next layer's: at the end of a volume
    // children of both come before either is written. Layer z is at z % 2.
    std::vector<ValueRange> below[2];
    std::vector<NodeRecord> records;  // of the current layer of pages
  };

  const exec::Device device;
  StoreWriter& writer;
  VolumeInfo info;
  std::vector<Level> levels;
  std::vector<std::uint64_t> fine_bins = std::vector<std::uint64_t>(65536);

  static constexpr ValueRange kNothing{INFINITY, -INFINITY};

  Levels(const exec::Device& cpu, StoreWriter& w, VolumeInfo i) : device(cpu), writer(w), info(std::move(i)) {
    const TreeShape& shape = info.shape;
    for (std::uint32_t l = 0; l < shape.levels; ++l) {
      Level level;
      level.dimensions = shape.level_dimensions(l);
      level.nodes = shape.level_nodes(l);
      level.pages = shape.level_pages(l);
      level.window.resize(static_cast<std::size_t>(level.dimensions.x * level.dimensions.y) * (shape.m + 2));
      for (auto& below : level.below) {
        below.assign(static_cast<std::size_t>(level.nodes.x * level.nodes.y), kNothing);
      }
      level.records.resize(static_cast<std::size_t>(level.pages.x * level.pages.y) * kPageNodes);
      levels.push_back(std::move(level));
    }
  }

  std::int64_t m() const { return info.shape.m; }

  Voxel* slice(Level& level, std::int64_t z) {
    return level.window.data() + z % (m() + 2) * level.dimensions.x * level.dimensions.y;
  }

  template <typename Function>
  void parallel(std::int64_t count, Function function) {
    exec::parallel_for(device, static_cast<std::size_t>(count),
                       [&](std::size_t i) { function(static_cast<std::int64_t>(i)); });
  }

  Status push(std::int64_t count, std::span<const std::byte> voxels) override {
    const Vec3i d = info.shape.dimensions;
    const std::size_t bytes = static_cast<std::size_t>(d.x * d.y) * sizeof(Voxel);
    GVX_CHECK(voxels.size() == bytes * static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) {
      const auto from = voxels.subspan(static_cast<std::size_t>(i) * bytes, bytes);
      Level& finest = levels.back();
      GVX_CHECK(finest.slices < d.z);
      std::memcpy(slice(finest, finest.slices), from.data(), bytes);
      GVX_TRY(slice_came(info.shape.levels - 1));
    }
    return {};
  }

  /// Slice level.slices stands in the window: writes what it completes, then averages for the level above.
  Status slice_came(std::uint32_t l) {
    Level& level = levels[l];
    const std::int64_t z = level.slices++;
    const bool last = level.slices == level.dimensions.z;
    if (l + 1 == info.shape.levels) count_values(level, z);
    while (level.layers < level.nodes.z && (last || z == (level.layers + 1) * m())) GVX_TRY(write_layer(l));
    if (l > 0 && (last || level.slices % info.shape.n == 0)) {
      average_into(levels[l - 1], level);
      GVX_TRY(slice_came(l - 1));
    }
    return {};
  }

  void count_values(Level& level, std::int64_t z) {
    // Two tables in turn: equal neighbours would otherwise wait for each other's increment.
    const Voxel* voxels = slice(level, z);
    const std::int64_t count = level.dimensions.x * level.dimensions.y;
    thread_local std::vector<std::uint32_t> odd(65536), even(65536);
    std::fill(odd.begin(), odd.end(), 0u);
    std::fill(even.begin(), even.end(), 0u);
    for (std::int64_t i = 0; i + 1 < count; i += 2) {
      ++even[fine_bin(voxels[i])];
      ++odd[fine_bin(voxels[i + 1])];
    }
    if (count % 2 != 0) ++even[fine_bin(voxels[count - 1])];
    for (std::size_t i = 0; i < fine_bins.size(); ++i) fine_bins[i] += even[i] + odd[i];
  }

  /// Averages the newest up to n slices of `from` into the next slice of `to`.
  void average_into(Level& to, Level& from) {
    const std::int64_t n = info.shape.n;
    const std::int64_t z0 = (from.slices - 1) / n * n, z1 = from.slices;
    Voxel* target = slice(to, to.slices);
    parallel(to.dimensions.y, [&](std::int64_t y) {
      const std::int64_t y1 = std::min((y + 1) * n, from.dimensions.y);
      for (std::int64_t x = 0; x < to.dimensions.x; ++x) {
        const std::int64_t x1 = std::min((x + 1) * n, from.dimensions.x);
        using Sum = std::conditional_t<std::is_same_v<Voxel, float>, double, std::uint32_t>;
        Sum sum = 0;
        for (std::int64_t zz = z0; zz < z1; ++zz) {
          for (std::int64_t yy = y * n; yy < y1; ++yy) {
            const Voxel* row = slice(from, zz) + yy * from.dimensions.x;
            for (std::int64_t xx = x * n; xx < x1; ++xx) sum += row[xx];
          }
        }
        const auto count = static_cast<Sum>((z1 - z0) * (y1 - y * n) * (x1 - x * n));
        if constexpr (std::is_same_v<Voxel, float>) {
          target[y * to.dimensions.x + x] = static_cast<float>(sum / count);
        } else {
          target[y * to.dimensions.x + x] = static_cast<Voxel>((sum + count / 2) / count);
        }
      }
    });
  }

  /// Cuts out the brick of node (nx, ny) of the current layer, border included; returns the range of its
  /// voxels.
  ValueRange gather(Level& level, std::int64_t nx, std::int64_t ny, Voxel* brick) {
    const std::int64_t edge = m() + 2;
    const Vec3i d = level.dimensions;
    Voxel least = std::numeric_limits<Voxel>::max(), greatest = std::numeric_limits<Voxel>::lowest();
    for (std::int64_t k = 0; k < edge; ++k) {
      const Voxel* from = slice(level, std::clamp(level.layers * m() + k - 1, std::int64_t(0), d.z - 1));
      for (std::int64_t j = 0; j < edge; ++j) {
        const Voxel* row = from + std::clamp(ny * m() + j - 1, std::int64_t(0), d.y - 1) * d.x;
        Voxel* to = brick + (k * edge + j) * edge;
        const std::int64_t x0 = nx * m() - 1;
        if (x0 >= 0 && x0 + edge <= d.x) {
          std::memcpy(to, row + x0, static_cast<std::size_t>(edge) * sizeof(Voxel));
        } else {
          for (std::int64_t i = 0; i < edge; ++i) to[i] = row[std::clamp(x0 + i, std::int64_t(0), d.x - 1)];
        }
        for (std::int64_t i = 0; i < edge; ++i) {
          least = std::min(least, to[i]);
          greatest = std::max(greatest, to[i]);
        }
      }
    }
    return {static_cast<float>(least), static_cast<float>(greatest)};
  }

  Status write_layer(std::uint32_t l) {
    Level& level = levels[l];
    auto& below = level.below[level.layers % 2];
    const std::size_t count = below.size();
    std::vector<std::vector<std::byte>> compressed(std::min(count, kBatch));
    std::vector<ValueRange> ranges(count);
    for (std::size_t first = 0; first < count; first += kBatch) {
      const std::size_t batch = std::min(kBatch, count - first);
      parallel(static_cast<std::int64_t>(batch), [&](std::int64_t i) {
        const std::size_t node = first + static_cast<std::size_t>(i);
        thread_local std::vector<Voxel> brick;
        brick.resize(info.shape.brick_voxels());
        ValueRange range = gather(level, static_cast<std::int64_t>(node) % level.nodes.x,
                                  static_cast<std::int64_t>(node) / level.nodes.x, brick.data());
        range.include(below[node]);
        ranges[node] = range;
        auto& bytes = compressed[static_cast<std::size_t>(i)];
        bytes.clear();
        if (!range.constant()) compress(info.codec, sizeof(Voxel), std::as_bytes(std::span(brick)), bytes);
      });
      for (std::size_t i = 0; i < batch; ++i) {
        const std::size_t node = first + i;
        NodeRecord record{0, 0, 0, ranges[node]};
        if (!compressed[i].empty()) {
          GVX_ASSIGN(record, writer.add_brick(compressed[i], ranges[node]));
        }
        record_at(level, node) = record;
      }
    }
    pass_ranges_up(l, ranges);
    std::fill(below.begin(), below.end(), kNothing);
    ++level.layers;
    if (level.layers % kPageEdge == 0 || level.layers == level.nodes.z) {
      GVX_TRY(writer.add_page_layer(l, (level.layers - 1) / kPageEdge, level.records));
      std::fill(level.records.begin(), level.records.end(), NodeRecord{});
    }
    return {};
  }

  NodeRecord& record_at(Level& level, std::size_t node) {
    const auto x = static_cast<std::int64_t>(node) % level.nodes.x,
               y = static_cast<std::int64_t>(node) / level.nodes.x;
    const std::int64_t row = level.pages.x * kPageEdge, rows = level.pages.y * kPageEdge;
    return level.records[static_cast<std::size_t>((level.layers % kPageEdge * rows + y) * row + x)];
  }

  void pass_ranges_up(std::uint32_t l, const std::vector<ValueRange>& ranges) {
    if (l == 0) {
      info.range = ranges[0];
      return;
    }
    Level& above = levels[l - 1];
    const Level& level = levels[l];
    const std::int64_t n = info.shape.n;
    const std::int64_t above_layer = level.layers / n;
    GVX_CHECK(above_layer == above.layers || above_layer == above.layers + 1);
    for (std::int64_t y = 0; y < level.nodes.y; ++y) {
      for (std::int64_t x = 0; x < level.nodes.x; ++x) {
        above.below[above_layer % 2][static_cast<std::size_t>(y / n * above.nodes.x + x / n)].include(
            ranges[static_cast<std::size_t>(y * level.nodes.x + x)]);
      }
    }
  }

  Status finish() override {
    for (const Level& level : levels)
      GVX_CHECK(level.slices == level.dimensions.z && level.layers == level.nodes.z);
    const double least = info.range.minimum, width = info.range.maximum - least;
    info.histogram.assign(kHistogramBins, 0);
    for (std::size_t i = 0; i < fine_bins.size(); ++i) {
      if (fine_bins[i] == 0) continue;
      const double where = width > 0 ? (fine_bin_value<Voxel>(i) - least) / width : 0;
      const double bin = std::clamp(std::floor(where * kHistogramBins), 0.0, double(kHistogramBins - 1));
      info.histogram[static_cast<std::size_t>(bin)] += fine_bins[i];
    }
    return writer.finish(info);
  }
};

PyramidBuilder::PyramidBuilder(const exec::Device& cpu, StoreWriter& writer, VolumeInfo info) {
  steps_ = with_voxel_type(info.type, [&](auto zero) -> std::unique_ptr<Steps> {
    return std::make_unique<Levels<decltype(zero)>>(cpu, writer, std::move(info));
  });
}

PyramidBuilder::~PyramidBuilder() = default;

std::uint64_t PyramidBuilder::window_bytes(const TreeShape& shape, VoxelType type) {
  double bytes = 0;
  for (std::uint32_t l = 0; l < shape.levels; ++l) {
    const Vec3d d(shape.level_dimensions(l)), pages(shape.level_pages(l));
    bytes += d.x * d.y * (shape.m + 2) * static_cast<double>(voxel_bytes(type));
    bytes += pages.x * pages.y * kPageNodes * sizeof(NodeRecord);
    bytes += pages.x * pages.y * pages.z * sizeof(PageEntry);
  }
  return bytes < 0x1p63 ? static_cast<std::uint64_t>(bytes) : UINT64_MAX / 2;
}

Status PyramidBuilder::push_slices(std::int64_t count, std::span<const std::byte> voxels) {
  return steps_->push(count, voxels);
}

Status PyramidBuilder::finish() {
  return steps_->finish();
}

}  // namespace gvx::store
