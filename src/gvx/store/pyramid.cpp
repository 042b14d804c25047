#include "gvx/store/pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <future>

#include "gvx/exec/parallel.h"
#include "gvx/store/codec.h"
#include "gvx/store/downsample.h"
#include "gvx/store/value_histogram.h"

namespace gvx::store {
namespace {

constexpr std::int64_t kLeastBand = 64;  // rows of a slice that are worth a thread's while

/// How many bricks are compressed together before they are written in order.
std::size_t bricks_at_once(std::size_t brick_bytes) {
  constexpr std::size_t kBytes = 8 << 20, kLeast = 16, kMost = 512;
  return std::clamp(kBytes / brick_bytes, kLeast, kMost);
}

/// What is known of a node's voxels, of a rim of n around them, and of all nodes below with theirs.
struct NodeSummary {
  ChannelRanges ranges;
  bool gaps = false;  ///< some of them are no data

  void include(const NodeSummary& other) {
    ranges.include(other.ranges);
    gaps = gaps || other.gaps;
  }
};

NodeSummary nothing(std::uint32_t channels) {
  NodeSummary summary;
  for (std::uint32_t c = 0; c < channels; ++c) summary.ranges.channel[c] = kNoValues;
  return summary;
}

}  // namespace

/// All levels of one volume.
template <typename Voxel>
struct PyramidBuilder::Levels final : PyramidBuilder::Steps {
  struct Level {
    Vec3i dimensions, nodes, pages;
    // Slice z is at z % depth of each window. Variances are of scalars above the finest level.
    std::vector<std::vector<Voxel>> planes;
    std::vector<std::vector<float>> variances;
    std::int64_t slices = 0;  // that have come
    std::int64_t layers = 0;  // of bricks that were written
    // Of the children of this layer's nodes, joined, and of the next layer's: at the end of a volume children
    // of both come before either is written. Layer z is at z % 2.
    std::vector<NodeSummary> below[2];
    std::vector<NodeRecord> records;  // of the current layer of pages
  };

  const exec::Device device;
  StoreWriter& writer;
  VolumeInfo info;
  const VoxelFormat format;
  const std::int64_t m, n, border;
  std::vector<Level> levels;
  // Of each channel as many as there are bands; a slice's rows are counted band by band, side by side.
  const std::int64_t bands;
  std::vector<ValueHistogram<Voxel>> histograms;

  Levels(const exec::Device& cpu, StoreWriter& w, VolumeInfo i)
      : device(cpu),
        writer(w),
        info(std::move(i)),
        format(info.format),
        m(info.shape.m),
        n(info.shape.n),
        border(info.border),
        bands(std::clamp<std::int64_t>(info.shape.dimensions.y / kLeastBand, 1, device.threads())),
        histograms(format.channels() * static_cast<std::size_t>(bands)) {
    GVX_CHECK(border >= 1 && border <= std::int64_t{kMostBorder} && border <= n);
    const TreeShape& shape = info.shape;
    for (std::uint32_t l = 0; l < shape.levels; ++l) {
      Level level;
      level.dimensions = shape.level_dimensions(l);
      level.nodes = shape.level_nodes(l);
      level.pages = shape.level_pages(l);
      const auto window = static_cast<std::size_t>(level.dimensions.x * level.dimensions.y * depth());
      level.planes.assign(format.planes, std::vector<Voxel>(window));
      const bool coarse = l + 1 < shape.levels;
      if (coarse && format.has_deviations()) {
        level.variances.assign(format.planes, std::vector<float>(window));
      }
      for (auto& below : level.below) {
        below.assign(static_cast<std::size_t>(level.nodes.x * level.nodes.y), nothing(format.channels()));
      }
      level.records.resize(static_cast<std::size_t>(level.pages.x * level.pages.y) * kPageNodes);
      levels.push_back(std::move(level));
    }
  }

  /// Slices of a window: a layer of bricks and a rim of n on both sides.
  std::int64_t depth() const { return m + 2 * n; }

  template <typename T>
  T* slice(std::vector<T>& window, const Level& level, std::int64_t z) {
    return window.data() + z % depth() * level.dimensions.x * level.dimensions.y;
  }

  template <typename Function>
  void parallel(std::int64_t count, Function function) {
    exec::parallel_for(device, static_cast<std::size_t>(count),
                       [&](std::size_t i) { function(static_cast<std::int64_t>(i)); });
  }

  Status push(std::int64_t count, std::span<const std::byte> voxels) override {
    const Vec3i d = info.shape.dimensions;
    const auto area = static_cast<std::size_t>(d.x * d.y);
    const std::size_t bytes = area * format.planes * sizeof(Voxel);
    GVX_CHECK(voxels.size() == bytes * static_cast<std::size_t>(count));
    Level& finest = levels.back();
    for (std::int64_t i = 0; i < count; ++i) {
      GVX_CHECK(finest.slices < d.z);
      const std::byte* from = voxels.data() + static_cast<std::size_t>(i) * bytes;
      parallel(bands, [&](std::int64_t band) { take_band(finest, from, band); });
      GVX_TRY(slice_came(info.shape.levels - 1));
    }
    return {};
  }

  /// Puts a band of a new slice's rows into the window, and counts its values.
  void take_band(Level& finest, const std::byte* from, std::int64_t band) {
    const Vec3i d = info.shape.dimensions;
    const auto first = static_cast<std::size_t>(band * d.y / bands * d.x);
    const auto last = static_cast<std::size_t>((band + 1) * d.y / bands * d.x);
    for (std::size_t c = 0; c < format.planes; ++c) {
      Voxel* to = slice(finest.planes[c], finest, finest.slices);
      if (format.planes == 1) {
        std::memcpy(to + first, from + first * sizeof(Voxel), (last - first) * sizeof(Voxel));
        continue;
      }
      for (std::size_t v = first; v < last; ++v) {
        std::memcpy(to + v, from + (v * format.planes + c) * sizeof(Voxel), sizeof(Voxel));
      }
    }
    for (std::uint32_t c = 0; c < format.channels(); ++c) {
      const Voxel* values = slice(range_plane(finest, c), finest, finest.slices);
      histograms[static_cast<std::size_t>(c * bands + band)].add(values + first,
                                                                 static_cast<std::int64_t>(last - first));
    }
  }

  /// Slice level.slices stands in the window: writes what it completes, then makes one for the level above.
  Status slice_came(std::uint32_t l) {
    Level& level = levels[l];
    ++level.slices;
    const bool last = level.slices == level.dimensions.z;
    while (level.layers < level.nodes.z && (last || level.slices == (level.layers + 1) * m + n)) {
      GVX_TRY(write_layer(l));
    }
    if (l > 0 && (last || level.slices % n == 0)) {
      downsample_into(levels[l - 1], level);
      GVX_TRY(slice_came(l - 1));
    }
    return {};
  }

  /// The plane that a channel's ranges are of.
  std::vector<Voxel>& range_plane(Level& level, std::uint32_t channel) {
    return level.planes[colored() ? 3 : channel];
  }

  bool colored() const {
    return format.content == VoxelContent::color || format.content == VoxelContent::color_normal;
  }

  /// The newest up to n slices of `from` make the next slice of `to`.
  void downsample_into(Level& to, Level& from) {
    const std::int64_t z0 = (from.slices - 1) / n * n;
    const bool in_eights = format.content == VoxelContent::scalar && n == 2 && from.slices - z0 == 2;
    parallel(to.dimensions.y, [&](std::int64_t y) {
      std::int64_t begin = 0;
      if (in_eights && 2 * y + 1 < from.dimensions.y) {
        begin = from.dimensions.x / 2;
        for (std::size_t c = 0; c < format.planes; ++c) average_eights(to, from, c, y, z0, begin);
      }
      for (std::int64_t x = begin; x < to.dimensions.x; ++x) {
        const Vec3i first(x * n, y * n, z0);
        const Vec3i last(std::min(first.x + n, from.dimensions.x), std::min(first.y + n, from.dimensions.y),
                         from.slices);
        const std::int64_t at = y * to.dimensions.x + x;
        switch (format.content) {
          case VoxelContent::scalar:
            for (std::size_t c = 0; c < format.planes; ++c) average(to, from, c, first, last, at);
            break;
          case VoxelContent::labels:
            vote(to, from, first, last, at);
            break;
          default:
            merge_colors(to, from, first, last, at);
        }
      }
    });
  }

  /// Calls function(row, x0, x1) for the rows of the block first..last of a window.
  template <typename T, typename Function>
  void for_each_row(std::vector<T>& window, const Level& level, Vec3i first, Vec3i last, Function function) {
    for (std::int64_t z = first.z; z < last.z; ++z) {
      const T* plane = slice(window, level, z);
      for (std::int64_t y = first.y; y < last.y; ++y) function(plane + y * level.dimensions.x);
    }
  }

  /// The first `count` voxels of a row, each of 2 x 2 x 2 of the finer level: what average() makes of them.
  void average_eights(Level& to, Level& from, std::size_t c, std::int64_t y, std::int64_t z0,
                      std::int64_t count) {
    const bool finest = from.variances.empty();
    Voxel* means = slice(to.planes[c], to, to.slices) + y * to.dimensions.x;
    float* variances = slice(to.variances[c], to, to.slices) + y * to.dimensions.x;
    for (std::int64_t x = 0; x < count; x += kEights) {
      const Voxel* rows[4];
      const float* below[4];
      for (std::int64_t i = 0; i < 4; ++i) {
        const std::int64_t at = (2 * y + i % 2) * from.dimensions.x + 2 * x;
        rows[i] = slice(from.planes[c], from, z0 + i / 2) + at;
        below[i] = finest ? nullptr : slice(from.variances[c], from, z0 + i / 2) + at;
      }
      store::average_eights<Voxel>(rows, finest ? nullptr : &below, std::min(kEights, count - x), means + x,
                                   variances + x);
    }
  }

  void average(Level& to, Level& from, std::size_t c, Vec3i first, Vec3i last, std::int64_t at) {
    MomentSum<Voxel> sum;
    const bool finest = from.variances.empty();
    for (std::int64_t z = first.z; z < last.z; ++z) {
      const Voxel* values = slice(from.planes[c], from, z);
      const float* variances = finest ? nullptr : slice(from.variances[c], from, z);
      for (std::int64_t y = first.y; y < last.y; ++y) {
        const std::int64_t row = y * from.dimensions.x;
        for (std::int64_t x = first.x; x < last.x; ++x) {
          sum.add(values[row + x], finest ? 0.0f : variances[row + x]);
        }
      }
    }
    const Moments moments = sum.moments();
    slice(to.planes[c], to, to.slices)[at] = rounded<Voxel>(moments.mean);
    slice(to.variances[c], to, to.slices)[at] = static_cast<float>(moments.variance);
  }

  void vote(Level& to, Level& from, Vec3i first, Vec3i last, std::int64_t at) {
    std::array<Voxel, 27> labels{};
    std::size_t count = 0;
    for_each_row(from.planes[0], from, first, last, [&](const Voxel* row) {
      for (std::int64_t x = first.x; x < last.x; ++x) labels[count++] = row[x];
    });
    slice(to.planes[0], to, to.slices)[at] = most_frequent(labels, count);
  }

  void merge_colors(Level& to, Level& from, Vec3i first, Vec3i last, std::int64_t at) {
    std::array<Rgba, 27> block{};
    for (std::size_t c = 0; c < 4; ++c) {
      std::size_t i = 0;
      for_each_row(from.planes[c], from, first, last, [&](const Voxel* row) {
        for (std::int64_t x = first.x; x < last.x; ++x) block[i++][c] = static_cast<float>(row[x]) / 255.0f;
      });
    }
    const Vec3i size = last - first;
    const Rgba seen = seen_from_all_sides(block, static_cast<int>(size.x), static_cast<int>(size.y),
                                          static_cast<int>(size.z));
    for (std::size_t c = 0; c < 4; ++c) {
      slice(to.planes[c], to, to.slices)[at] =
          rounded<Voxel>(std::clamp(double(seen[c]) * 255.0, 0.0, 255.0));
    }
    if (format.content == VoxelContent::color_normal) merge_normals(to, from, first, last, at, seen[3]);
  }

  /// The mean of the normals that there are: what is inside has none, and takes nothing away from those of
  /// its surface. Where they disagree it is short.
  void merge_normals(Level& to, Level& from, Vec3i first, Vec3i last, std::int64_t at, float opacity) {
    std::array<Vec3f, 27> normals{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::size_t i = 0;
      for_each_row(from.planes[4 + axis], from, first, last, [&](const Voxel* row) {
        for (std::int64_t x = first.x; x < last.x; ++x) {
          normals[i++][static_cast<int>(axis)] = (static_cast<float>(row[x]) - 127) / 127;
        }
      });
    }
    Vec3f sum;
    float lengths = 0;
    for (const Vec3f& normal : normals) {
      sum = sum + normal;
      lengths += length(normal);
    }
    const Vec3f mean = lengths > 0 ? (opacity / lengths) * sum : Vec3f();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double held = std::clamp(mean[static_cast<int>(axis)], -1.0f, 1.0f);
      slice(to.planes[4 + axis], to, to.slices)[at] = rounded<Voxel>(127 + 127 * held);
    }
  }

  /// A brick's row is short: copies of known sizes, the last of which overlaps, are quicker than one.
  static void copy_row(const Voxel* from, std::int64_t count, Voxel* to) {
    constexpr std::int64_t kPiece = 8;
    for (std::int64_t i = 0; i + kPiece < count; i += kPiece)
      std::memcpy(to + i, from + i, kPiece * sizeof(Voxel));
    std::memcpy(to + count - kPiece, from + count - kPiece, kPiece * sizeof(Voxel));
  }

  /// Cuts out a plane of the brick of node (nx, ny) of the current layer, border included.
  void gather(Level& level, std::vector<Voxel>& plane, std::int64_t nx, std::int64_t ny, Voxel* brick) {
    const std::int64_t edge = m + 2 * border, x0 = nx * m - border;
    const Vec3i d = level.dimensions;
    for (std::int64_t k = 0; k < edge; ++k) {
      const Voxel* from =
          slice(plane, level, std::clamp(level.layers * m + k - border, std::int64_t(0), d.z - 1));
      for (std::int64_t j = 0; j < edge; ++j) {
        const Voxel* row = from + std::clamp(ny * m + j - border, std::int64_t(0), d.y - 1) * d.x;
        Voxel* to = brick + (k * edge + j) * edge;
        if (x0 >= 0 && x0 + edge <= d.x) {
          copy_row(row + x0, edge, to);
        } else {
          for (std::int64_t i = 0; i < edge; ++i) to[i] = row[std::clamp(x0 + i, std::int64_t(0), d.x - 1)];
        }
      }
    }
  }

  /// The deviations of a plane of that brick, as core/voxel.h lays them out.
  void gather_deviations(Level& level, std::vector<float>& variances, std::int64_t nx, std::int64_t ny,
                         std::byte* out) {
    const std::int64_t edge = m / 2 + 2;
    const Vec3i d = level.dimensions;
    thread_local std::vector<float> deviations;
    deviations.resize(static_cast<std::size_t>(edge * edge * edge));
    float greatest = 0;
    std::size_t i = 0;
    const auto pair = [](std::int64_t start, std::int64_t size, std::int64_t out_pair[2]) {
      for (int s = 0; s < 2; ++s) out_pair[s] = std::clamp(start + s, std::int64_t(0), size - 1);
    };
    for (std::int64_t k = -1; k + 1 < edge; ++k) {
      std::int64_t zs[2], ys[2];
      pair(level.layers * m + 2 * k, d.z, zs);
      for (std::int64_t j = -1; j + 1 < edge; ++j) {
        pair(ny * m + 2 * j, d.y, ys);
        const float* rows[4];
        for (std::size_t r = 0; r < 4; ++r) rows[r] = slice(variances, level, zs[r / 2]) + ys[r % 2] * d.x;
        const std::int64_t x0 = nx * m - 2;
        float* const row_deviations = deviations.data() + i;
        if (x0 >= 0 && x0 + 2 * edge <= d.x) {
          for (const float*& row : rows) row += x0;
          sum_eights(rows, edge, row_deviations);
        } else {
          for (std::int64_t h = 0; h < edge; ++h) {
            std::int64_t xs[2];
            pair(x0 + 2 * h, d.x, xs);
            float sum = 0;
            for (const float* const row : rows) sum += row[xs[0]] + row[xs[1]];
            row_deviations[h] = sum;
          }
        }
        for (std::int64_t h = 0; h < edge; ++h) row_deviations[h] = std::sqrt(row_deviations[h] / 8);
        if constexpr (std::is_same_v<Voxel, float>) {
          const bool shifted = x0 >= 0 && x0 + 2 * edge <= d.x;
          for (std::int64_t h = 0; h < edge; ++h) {
            if (!std::isnan(row_deviations[h])) continue;
            std::int64_t xs[2] = {2 * h, 2 * h + 1};
            if (!shifted) pair(x0 + 2 * h, d.x, xs);
            row_deviations[h] = deviation_of_existing(rows, xs[0], xs[1]);
          }
        }
        for (std::int64_t h = 0; h < edge; ++h) greatest = std::max(greatest, row_deviations[h]);
        i += static_cast<std::size_t>(edge);
      }
    }
    const float unit = deviation_unit(greatest);
    std::memcpy(out, &unit, sizeof(unit));
    for (std::size_t c = 0; c < i; ++c) {
      out[sizeof(unit) + c] = static_cast<std::byte>(deviation_code(deviations[c], unit));
    }
  }

  /// Of the node's own voxels and a rim of n around them.
  NodeSummary own_summary(Level& level, std::int64_t nx, std::int64_t ny) {
    const Vec3i d = level.dimensions, node(nx, ny, level.layers);
    Vec3i first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(node[axis] * m - n, std::int64_t(0));
      last[axis] = std::min((node[axis] + 1) * m + n, d[axis]);
    }
    NodeSummary summary = nothing(format.channels());
    for (std::uint32_t c = 0; c < format.channels(); ++c) {
      Extremes<Voxel> extremes;
      for_each_row(range_plane(level, c), level, first, last,
                   [&](const Voxel* row) { extremes.add(row + first.x, last.x - first.x); });
      const Voxel least = extremes.least(), greatest = extremes.greatest();
      summary.gaps = summary.gaps || extremes.any_no_data();
      if (least > greatest) continue;
      summary.ranges.channel[c] = {colored() ? 0 : static_cast<float>(least), static_cast<float>(greatest)};
    }
    return summary;
  }

  /// Fills `brick` with all planes and deviations of a node.
  void gather_brick(Level& level, std::int64_t nx, std::int64_t ny, std::span<std::byte> brick) {
    const auto texels = info.texels(info.border);
    auto* voxels = reinterpret_cast<Voxel*>(brick.data());
    for (auto& plane : level.planes) {
      gather(level, plane, nx, ny, voxels);
      voxels += texels;
    }
    auto* deviations = reinterpret_cast<std::byte*>(voxels);
    std::fill(deviations, brick.data() + brick.size(), std::byte{0});
    for (auto& variances : level.variances) {
      gather_deviations(level, variances, nx, ny, deviations);
      deviations += deviation_bytes(static_cast<std::size_t>(m));
    }
  }

  /// What is known of a node of the current layer, and its compressed brick; none where it is a constant, or
  /// no data.
  void make_brick(Level& level, std::size_t node, const NodeSummary& below, NodeSummary& summary,
                  std::vector<std::byte>& compressed) {
    const auto nx = static_cast<std::int64_t>(node) % level.nodes.x,
               ny = static_cast<std::int64_t>(node) / level.nodes.x;
    summary = own_summary(level, nx, ny);
    summary.include(below);
    compressed.clear();
    const NodeRecord without_brick{0, 0, 0, summary.ranges};
    if (summary.gaps ? without_brick.no_data(format.channels()) : summary.ranges.constant()) return;
    thread_local std::vector<std::byte> brick;
    brick.resize(info.brick_bytes(info.border));
    gather_brick(level, nx, ny, brick);
    compress(info.codec, {sizeof(Voxel), format.planes * info.texels(info.border)}, brick, compressed);
  }

  Status write_layer(std::uint32_t l) {
    Level& level = levels[l];
    auto& below = level.below[level.layers % 2];
    const std::size_t count = below.size(), at_once = bricks_at_once(info.brick_bytes(info.border));
    std::vector<std::vector<std::byte>> compressed[2];
    for (auto& bricks : compressed) bricks.resize(std::min(count, at_once));
    std::vector<NodeSummary> nodes(count);
    std::future<Status> appending;  // of one batch, while the next is made
    for (std::size_t first = 0; first < count; first += at_once) {
      const std::size_t batch = std::min(at_once, count - first);
      auto& bricks = compressed[first / at_once % 2];
      parallel(static_cast<std::int64_t>(batch), [&](std::int64_t i) {
        const auto brick = static_cast<std::size_t>(i);
        make_brick(level, first + brick, below[first + brick], nodes[first + brick], bricks[brick]);
      });
      if (appending.valid()) GVX_TRY(appending.get());
      appending = std::async(std::launch::async, [&, first, batch]() -> Status {
        for (std::size_t i = 0; i < batch; ++i) {
          NodeRecord record{0, 0, 0, nodes[first + i].ranges};
          if (!bricks[i].empty()) {
            GVX_ASSIGN(record, writer.add_brick(bricks[i], nodes[first + i].ranges));
          }
          record_at(level, first + i) = record;
        }
        return {};
      });
    }
    GVX_TRY(appending.get());
    pass_up(l, nodes);
    std::fill(below.begin(), below.end(), nothing(format.channels()));
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

  void pass_up(std::uint32_t l, const std::vector<NodeSummary>& nodes) {
    if (l == 0) {
      info.ranges = nodes[0].ranges;
      for (ValueRange& range : info.ranges.channel) range = range == kNoValues ? ValueRange{} : range;
      return;
    }
    Level& above = levels[l - 1];
    const Level& level = levels[l];
    const std::int64_t above_layer = level.layers / n;
    GVX_CHECK(above_layer == above.layers || above_layer == above.layers + 1);
    for (std::int64_t y = 0; y < level.nodes.y; ++y) {
      for (std::int64_t x = 0; x < level.nodes.x; ++x) {
        above.below[above_layer % 2][static_cast<std::size_t>(y / n * above.nodes.x + x / n)].include(
            nodes[static_cast<std::size_t>(y * level.nodes.x + x)]);
      }
    }
  }

  Status finish() override {
    for (const Level& level : levels)
      GVX_CHECK(level.slices == level.dimensions.z && level.layers == level.nodes.z);
    for (std::uint32_t c = 0; c < format.channels(); ++c) {
      ValueHistogram<Voxel>& sum = histograms[static_cast<std::size_t>(c * bands)];
      for (std::int64_t band = 1; band < bands; ++band) {
        sum.add(histograms[static_cast<std::size_t>(c * bands + band)]);
      }
      info.histograms.push_back(sum.bins(info.ranges.channel[c], kHistogramBins));
      info.no_data = info.no_data || sum.any_no_data();
    }
    return writer.finish(info);
  }
};

PyramidBuilder::PyramidBuilder(const exec::Device& cpu, StoreWriter& writer, VolumeInfo info) {
  steps_ = with_voxel_type(info.format.type, [&](auto zero) -> std::unique_ptr<Steps> {
    return std::make_unique<Levels<decltype(zero)>>(cpu, writer, std::move(info));
  });
}

PyramidBuilder::~PyramidBuilder() = default;

std::uint64_t PyramidBuilder::window_bytes(const VolumeInfo& info) {
  const TreeShape& shape = info.shape;
  const VoxelFormat format = info.format;
  const std::size_t brick = info.brick_bytes(info.border);
  double bytes = 0;
  for (std::uint32_t l = 0; l < shape.levels; ++l) {
    const Vec3d d(shape.level_dimensions(l)), pages(shape.level_pages(l));
    const bool coarse = l + 1 < shape.levels && format.has_deviations();
    const std::size_t number = voxel_bytes(format.type) + (coarse ? sizeof(float) : 0);
    bytes += d.x * d.y * (shape.m + 2 * shape.n) * static_cast<double>(number * format.planes);
    bytes += pages.x * pages.y * kPageNodes * sizeof(NodeRecord);
    const Vec3d nodes(shape.level_nodes(l));
    bytes += nodes.x * nodes.y * 3 * sizeof(NodeSummary);
    // Two batches of compressed bricks, which may be as large as they were.
    if (l + 1 == shape.levels) {
      bytes += std::min(nodes.x * nodes.y, 2.0 * static_cast<double>(bricks_at_once(brick))) *
               static_cast<double>(brick);
    }
  }
  bytes += static_cast<double>(StoreWriter::most_bytes(shape));
  return bytes < 0x1p63 ? static_cast<std::uint64_t>(bytes) : UINT64_MAX / 2;
}

Status PyramidBuilder::push_slices(std::int64_t count, std::span<const std::byte> voxels) {
  return steps_->push(count, voxels);
}

Status PyramidBuilder::finish() {
  return steps_->finish();
}

}  // namespace gvx::store
