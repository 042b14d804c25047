#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

std::string temporary(const std::string& name) {
  return testing::TempDir() + "gvx_store_" + name;
}

/// Waves with a large flat part, so that there are constant nodes at several levels.
double waves(std::int64_t x, std::int64_t y, std::int64_t z) {
  if (x > 40) return 17;
  return 100 + 60 * std::sin(0.3 * double(x)) * std::cos(0.2 * double(y)) + double(z % 5);
}

/// The level above by definition: the mean of the n^3 voxels that exist and are numbers, rounded as the store
/// rounds.
template <typename Voxel>
TestVolume<Voxel> average(const TestVolume<Voxel>& fine, std::int64_t n) {
  const Vec3i d = (fine.dimensions + Vec3i(n - 1)) / Vec3i(n);
  return TestVolume<Voxel>(d, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    double sum = 0, count = 0;
    for (std::int64_t k = z * n; k < std::min(z * n + n, fine.dimensions.z); ++k) {
      for (std::int64_t j = y * n; j < std::min(y * n + n, fine.dimensions.y); ++j) {
        for (std::int64_t i = x * n; i < std::min(x * n + n, fine.dimensions.x); ++i) {
          if (std::isnan(double(fine.at(i, j, k)))) continue;
          sum += double(fine.at(i, j, k));
          ++count;
        }
      }
    }
    return std::is_same_v<Voxel, float> ? sum / count : std::floor(sum / count + 0.5);
  });
}

template <typename Voxel>
void expect_every_brick_right(const TestVolume<Voxel>& finest, const std::string& path, std::uint32_t n,
                              std::uint32_t m) {
  const auto reader = StoreReader::open(path).value();
  const TreeShape& shape = reader->info().shape;
  ASSERT_EQ(shape.dimensions, finest.dimensions);
  TestVolume<Voxel> level = finest;
  std::uint64_t constants = 0;
  for (std::uint32_t l = shape.levels; l-- > 0; level = average(level, n)) {
    ASSERT_EQ(shape.level_dimensions(l), level.dimensions);
    const Vec3i nodes = shape.level_nodes(l);
    std::vector<Voxel> brick(reader->info().brick_bytes(1) / sizeof(Voxel));
    for (std::uint32_t z = 0; z < nodes.z; ++z) {
      for (std::uint32_t y = 0; y < nodes.y; ++y) {
        for (std::uint32_t x = 0; x < nodes.x; ++x) {
          const NodeKey key{l, x, y, z};
          const NodeRecord record = reader->node(key).value();
          constants += record.constant() ? 1 : 0;
          ASSERT_TRUE(reader->read_brick(key, record, std::as_writable_bytes(std::span(brick)), 1).ok());
          std::size_t i = 0;
          const std::int64_t edge = m;
          for (std::int64_t k = -1; k <= edge; ++k) {
            for (std::int64_t j = -1; j <= edge; ++j) {
              for (std::int64_t h = -1; h <= edge; ++h, ++i) {
                const Voxel expected = level.at(x * edge + h, y * edge + j, z * edge + k);
                if (std::isnan(double(expected))) {
                  ASSERT_TRUE(std::isnan(double(brick[i])));
                  continue;
                }
                ASSERT_EQ(brick[i], expected) << l << ' ' << x << ' ' << y;
                ASSERT_TRUE(record.ranges.channel[0].contains(static_cast<float>(brick[i])));
              }
            }
          }
        }
      }
    }
  }
  EXPECT_GT(constants, 0u);
}

struct Shape {
  std::uint32_t n, m;
};
class EveryShape : public testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(, EveryShape,
                         testing::Values(Shape{2, 8}, Shape{2, 16}, Shape{2, 32}, Shape{3, 8}, Shape{3, 16},
                                         Shape{3, 32}),
                         [](const auto& tested) {
                           return "N" + std::to_string(tested.param.n) + "_M" +
                                  std::to_string(tested.param.m);
                         });

TEST_P(EveryShape, holds_every_level_of_a_u8_volume) {
  const auto [n, m] = GetParam();
  const TestVolume<std::uint8_t> volume({101, 37, 53}, waves);
  const std::string path = temporary("u8.gvx");
  ASSERT_TRUE(write_store(volume, path, n, m).ok());
  expect_every_brick_right(volume, path, n, m);
  EXPECT_TRUE(verify(exec::Device::cpu(), path, {}).ok());
}

TEST_P(EveryShape, holds_every_level_of_an_f32_volume) {
  const auto [n, m] = GetParam();
  const TestVolume<float> volume({101, 20, 35},
                                 [](auto x, auto y, auto z) { return waves(x, y, z) * 1e-3 - 0.05; });
  const std::string path = temporary("f32.gvx");
  ASSERT_TRUE(write_store(volume, path, n, m, Codec::lz4).ok());
  expect_every_brick_right(volume, path, n, m);
}

TEST_P(EveryShape, holds_every_level_of_a_volume_with_gaps) {
  const auto [n, m] = GetParam();
  std::mt19937 random(11);
  // Some voxels of waves and of a flat part are no data, and one end of it is none at all.
  const TestVolume<float> volume({133, 37, 53}, [&](auto x, auto y, auto z) {
    return x > 90 || random() % 16 == 0 ? NAN : waves(x, y, z) - 300;
  });
  const std::string path = temporary("gaps.gvx");
  ASSERT_TRUE(write_store(volume, path, n, m).ok());
  expect_every_brick_right(volume, path, n, m);
  const auto report = verify(exec::Device::cpu(), path, {});
  EXPECT_TRUE(report.ok()) << report.error().message;
  const VolumeInfo info = StoreReader::open(path).value()->info();
  EXPECT_TRUE(info.no_data);
  ValueRange range{INFINITY, -INFINITY};
  std::uint64_t numbers = 0;
  for (const float v : volume.voxels) {
    if (std::isnan(v)) continue;
    range.include({v, v});
    ++numbers;
  }
  EXPECT_EQ(info.ranges.channel[0], range);
  EXPECT_EQ(std::accumulate(info.histograms[0].begin(), info.histograms[0].end(), std::uint64_t(0)), numbers);
}

TEST(Store, holds_a_volume_without_any_data) {
  const TestVolume<float> volume({40, 30, 20}, [](auto, auto, auto) { return NAN; });
  const std::string path = temporary("no_data.gvx");
  ASSERT_TRUE(write_store(volume, path, 2, 8).ok());
  const auto report = verify(exec::Device::cpu(), path, {});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report.value().bricks, 0u);
  EXPECT_TRUE(StoreReader::open(path).value()->info().no_data);
}

TEST(Store, holds_volumes_of_one_voxel_and_of_one_line) {
  for (const Vec3i d : {Vec3i{1, 1, 1}, Vec3i{300, 1, 1}, Vec3i{1, 1, 300}, Vec3i{1, 129, 2}}) {
    const TestVolume<std::uint16_t> volume(d,
                                           [](auto x, auto y, auto z) { return 1000 + x + 7 * y + 3 * z; });
    const std::string path = temporary("thin.gvx");
    ASSERT_TRUE(write_store(volume, path, 2, 8).ok());
    const auto report = verify(exec::Device::cpu(), path, {});
    ASSERT_TRUE(report.ok()) << report.error().message;
    const auto reader = StoreReader::open(path).value();
    EXPECT_EQ(reader->info().ranges.channel[0],
              (ValueRange{1000, static_cast<float>(1000 + d.x - 1 + 7 * (d.y - 1) + 3 * (d.z - 1))}));
  }
}

TEST(Store, is_the_same_bytes_for_any_number_of_threads) {
  const TestVolume<std::uint16_t> volume({70, 60, 50},
                                         [](auto x, auto y, auto z) { return waves(x, y, z) * 100; });
  std::vector<std::string> files;
  for (const int threads : {1, 2, 7}) {
    const std::string path = temporary("threads.gvx");
    ASSERT_TRUE(write_store(volume, path, 2, 16, Codec::zstd, threads).ok());
    std::ifstream file(path, std::ios::binary);
    files.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
}

TEST(Store, histogram_counts_every_voxel_in_its_bin) {
  std::mt19937 random(9);
  std::normal_distribution<float> value(-3, 40);
  const TestVolume<float> volume({40, 30, 20}, [&](auto, auto, auto) { return value(random); });
  const std::string path = temporary("histogram.gvx");
  ASSERT_TRUE(write_store(volume, path, 2, 8).ok());
  const VolumeInfo info = StoreReader::open(path).value()->info();
  ASSERT_EQ(info.histograms[0].size(), kHistogramBins);
  EXPECT_EQ(std::accumulate(info.histograms[0].begin(), info.histograms[0].end(), std::uint64_t(0)),
            40u * 30 * 20);
  // Of floats the bin is known to 8 bits of mantissa: the count below each bin boundary is right up to that.
  const double width = info.ranges.channel[0].maximum - info.ranges.channel[0].minimum;
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < info.histograms[0].size(); bin += 16) {
    const double edge =
        info.ranges.channel[0].minimum + width * double(bin) / double(info.histograms[0].size());
    const auto low = std::count_if(volume.voxels.begin(), volume.voxels.end(),
                                   [&](float v) { return v < edge - std::abs(edge) / 128 - width / 1024; });
    const auto high = std::count_if(volume.voxels.begin(), volume.voxels.end(),
                                    [&](float v) { return v < edge + std::abs(edge) / 128 + width / 1024; });
    EXPECT_LE(low, static_cast<std::ptrdiff_t>(below));
    EXPECT_GE(high, static_cast<std::ptrdiff_t>(below));
    for (std::size_t i = 0; i < 16; ++i) below += info.histograms[0][bin + i];
  }
}

TEST(Store, keeps_what_a_default_camera_needs_and_refuses_bounds_beyond_the_volume) {
  const TestVolume<std::uint8_t> volume({40, 30, 20}, waves);
  const auto written = [&](UpAxis up, std::optional<Box3d> bounds) {
    VolumeInfo info;
    info.shape = TreeShape::covering(volume.dimensions, 2, 8);
    info.up = up;
    info.bounds = bounds;
    const std::string path = temporary("bounds.gvx");
    const auto writer = StoreWriter::create(path, info.shape, info.format).value();
    PyramidBuilder builder(exec::Device::cpu(2), *writer, info);
    EXPECT_TRUE(builder.push_slices(20, std::as_bytes(std::span(volume.voxels))).ok());
    EXPECT_TRUE(builder.finish().ok());
    return StoreReader::open(path);
  };
  const Box3d bounds{{3, 3.5, 0}, {37.25, 30, 1.0 / 3}};
  const auto turned = written(UpAxis::y, bounds);
  EXPECT_EQ(turned.value()->info().up, UpAxis::y);
  ASSERT_TRUE(turned.value()->info().bounds);
  EXPECT_EQ(turned.value()->info().bounds->minimum, bounds.minimum);
  EXPECT_EQ(turned.value()->info().bounds->maximum, bounds.maximum);
  const auto plain = written(UpAxis::z, std::nullopt);
  EXPECT_EQ(plain.value()->info().up, UpAxis::z);
  EXPECT_FALSE(plain.value()->info().bounds);
  for (const Box3d& bad : {Box3d{{-1, 0, 0}, {1, 1, 1}}, Box3d{{0, 0, 0}, {41, 1, 1}},
                           Box3d{{0, 2, 0}, {1, 1, 1}}, Box3d{{0, 0, 0}, {1, 1, 1e300}}}) {
    const auto refused = written(UpAxis::z, bad);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("metadata"), std::string::npos) << refused.error().message;
  }
}

TEST(StoreWriter, leaves_nothing_when_it_does_not_finish) {
  const std::string path = temporary("unfinished.gvx");
  std::filesystem::remove(path);
  {
    const auto writer =
        StoreWriter::create(path, TreeShape::covering({64, 64, 64}, 2, 16), VoxelFormat()).value();
    EXPECT_TRUE(std::filesystem::exists(path + ".partial"));
    const auto second = StoreWriter::create(path, TreeShape::covering({64, 64, 64}, 2, 16), VoxelFormat());
    ASSERT_FALSE(second.ok());
    EXPECT_NE(second.error().message.find("another build"), std::string::npos);
  }
  EXPECT_FALSE(std::filesystem::exists(path + ".partial"));
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(
      StoreWriter::create("/no/such/folder/x.gvx", TreeShape::covering({8, 8, 8}, 2, 8), VoxelFormat()).ok());
}

TEST(StoreWriter, a_full_disk_is_an_error) {
  // Linux's /dev/full takes no byte; the writer opens PATH.partial, so a link of that name stands in for the
  // disk.
  const std::string path = temporary("full.gvx");
  std::filesystem::remove(path + ".partial");
  std::filesystem::create_symlink("/dev/full", path + ".partial");
  const TestVolume<std::uint8_t> volume({64, 64, 64}, waves);
  const Status status = write_store(volume, path, 2, 16);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find(path), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path));
  std::filesystem::remove(path + ".partial");
}

}  // namespace
}  // namespace gvx::store
