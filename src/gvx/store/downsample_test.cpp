#include "gvx/store/downsample.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

std::string temporary(const char* name) {
  return testing::TempDir() + "gvx_downsample_" + name;
}

TEST(Downsample, the_most_frequent_label_wins_and_the_greater_of_two) {
  EXPECT_EQ(most_frequent<std::uint8_t>({3, 0, 3, 0, 0, 7, 7, 7}, 8), 7);
  EXPECT_EQ(most_frequent<std::uint8_t>({0, 0, 0, 0, 9, 9, 9, 9}, 8), 9);
  EXPECT_EQ(most_frequent<std::uint16_t>({500, 500, 2, 500}, 4), 500);
  EXPECT_EQ(most_frequent<std::uint16_t>({42}, 1), 42);
}

TEST(Downsample, colours_keep_what_is_seen) {
  std::array<Rgba, 27> block{};
  const Rgba red{0.9f, 0, 0, 0.9f}, clear{};
  // Fog of opacity a is 1 - (1 - a)^2 through two voxels.
  block.fill({0.05f, 0.05f, 0.05f, 0.1f});
  EXPECT_NEAR(seen_from_all_sides(block, 2, 2, 2)[3], 1 - 0.9 * 0.9, 1e-6);
  // One voxel of eight covers a quarter of each side, and is as opaque as it is.
  block.fill(clear);
  block[0] = red;
  const Rgba quarter = seen_from_all_sides(block, 2, 2, 2);
  EXPECT_NEAR(quarter[3], 0.9 / 4, 1e-6);
  EXPECT_NEAR(quarter[0], 0.9 / 4, 1e-6);
  // A single voxel at a volume's corner stays what it is.
  EXPECT_NEAR(seen_from_all_sides(block, 1, 1, 1)[3], 0.9, 1e-6);
  // The same from every side: the block's axes do not matter.
  std::mt19937 random(4);
  std::array<Rgba, 27> turned{};
  for (int z = 0; z < 3; ++z) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 3; ++x) {
        const float a = static_cast<float>(random() % 100) / 100;
        block[static_cast<std::size_t>(x + 3 * (y + 3 * z))] = {a * 0.5f, a, 0, a};
        turned[static_cast<std::size_t>(z + 3 * (x + 3 * y))] = {a * 0.5f, a, 0, a};
      }
    }
  }
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_NEAR(seen_from_all_sides(block, 3, 3, 3)[c], seen_from_all_sides(turned, 3, 3, 3)[c], 1e-5);
  }
}

/// The standard deviation of the finest voxels below half-resolution texel (i, j, k) of a level, which is
/// over `scale` finest voxels a voxel; between the means of the level's own voxels it does not count.
template <typename Voxel>
double deviation_below(const TestVolume<Voxel>& finest, std::int64_t scale, Vec3i texel) {
  double variance = 0;
  int count = 0;
  const Vec3i d = finest.dimensions;
  const auto held = [&](std::int64_t voxel, std::int64_t size) {
    return std::clamp<std::int64_t>(voxel, 0, (size + scale - 1) / scale - 1);
  };
  for (int corner = 0; corner < 8; ++corner, ++count) {
    const Vec3i v{held(2 * texel.x + (corner & 1), d.x), held(2 * texel.y + (corner >> 1 & 1), d.y),
                  held(2 * texel.z + (corner >> 2), d.z)};
    double sum = 0, squares = 0, n = 0;
    for (std::int64_t z = v.z * scale; z < std::min((v.z + 1) * scale, d.z); ++z) {
      for (std::int64_t y = v.y * scale; y < std::min((v.y + 1) * scale, d.y); ++y) {
        for (std::int64_t x = v.x * scale; x < std::min((v.x + 1) * scale, d.x); ++x) {
          const double value = finest.at(x, y, z);
          sum += value, squares += value * value, n += 1;
        }
      }
    }
    variance += squares / n - sum / n * (sum / n);
  }
  return std::sqrt(std::max(variance, 0.0) / count);
}

template <typename Voxel>
void expect_deviations(std::uint32_t n, std::uint32_t m, Vec3i dimensions, double most, double tolerance) {
  std::mt19937 random(5);
  const TestVolume<Voxel> volume(dimensions, [&](auto x, auto, auto) {
    return static_cast<double>(random() % 1000) / 999 * (x < dimensions.x / 2 ? most : most / 50);
  });
  const std::string path = temporary("deviation.gvx");
  ASSERT_TRUE(write_store(volume, path, n, m).ok());
  ASSERT_TRUE(verify(exec::Device::cpu(), path, {}).ok());
  const auto reader = StoreReader::open(path).value();
  const std::int64_t half = m / 2;
  std::int64_t scale = 1;
  for (std::uint32_t l = reader->info().shape.levels; l-- > 0; scale *= n) {
    const NodeKey key{l, 0, 0, 0};
    std::vector<std::byte> brick(reader->info().brick_bytes());
    ASSERT_TRUE(reader->read_brick(key, reader->node(key).value(), brick).ok());
    const std::byte* deviations = brick.data() + plane_texels(m) * sizeof(Voxel);
    float unit = 0;
    std::memcpy(&unit, deviations, sizeof(unit));
    if (scale == 1) {
      EXPECT_EQ(unit, 0.0f);
    }
    std::size_t i = sizeof(unit);
    for (std::int64_t z = -1; z <= half; ++z) {
      for (std::int64_t y = -1; y <= half; ++y) {
        for (std::int64_t x = -1; x <= half; ++x, ++i) {
          if (scale == 1) continue;
          const double found =
              double(unit) * deviation_of_code(std::to_integer<std::uint32_t>(deviations[i]));
          const double expected = deviation_below(volume, scale, {x, y, z});
          // A mantissa of four bits: a thirty-second.
          ASSERT_NEAR(found, expected, expected / 32 + double(unit) + tolerance)
              << l << ": " << x << ' ' << y << ' ' << z;
        }
      }
    }
  }
}

TEST(Downsample, eights_with_gaps_are_the_moments_of_what_exists) {
  std::mt19937 random(8);
  std::vector<float> rows[4], variances[4];
  const std::int64_t count = kEights;
  for (int r = 0; r < 4; ++r) {
    for (std::int64_t i = 0; i < 2 * count; ++i) {
      const bool gap = random() % 4 == 0 || i / 2 % 9 == 0;
      rows[r].push_back(gap ? NAN : static_cast<float>(random() % 100));
      variances[r].push_back(gap ? NAN : static_cast<float>(random() % 10));
    }
  }
  const float* const row[4] = {rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data()};
  const float* const below[4] = {variances[0].data(), variances[1].data(), variances[2].data(),
                                 variances[3].data()};
  float means[kEights], spread[kEights];
  average_eights<float>(row, &below, count, means, spread);
  for (std::int64_t x = 0; x < count; ++x) {
    MomentSum<float> sum;
    for (int r = 0; r < 4; ++r) {
      for (std::int64_t i = 2 * x; i < 2 * x + 2; ++i)
        sum.add(rows[r][std::size_t(i)], variances[r][std::size_t(i)]);
    }
    const Moments expected = sum.moments();
    EXPECT_EQ(std::isnan(means[x]), std::isnan(expected.mean)) << x;
    EXPECT_EQ(x % 9 == 0, std::isnan(means[x]) && std::isnan(spread[x])) << x;
    if (std::isnan(expected.mean)) continue;
    EXPECT_NEAR(means[x], expected.mean, 1e-4) << x;
    EXPECT_NEAR(spread[x], expected.variance, 1e-2) << x;
  }
}

TEST(Deviations, are_those_of_the_finest_voxels) {
  // Sizes that blocks divide: others weigh a block at the face like a full one. Means are rounded, by half of
  // one a level.
  expect_deviations<std::uint8_t>(2, 8, {48, 32, 16}, 255, 0.6);
  expect_deviations<std::uint16_t>(3, 8, {54, 36, 18}, 60000, 1);
  expect_deviations<float>(2, 16, {64, 32, 16}, 1e-3, 1e-8);
}

TEST(Ranges, hold_a_rim_of_n_voxels_and_everything_below) {
  std::mt19937 random(6);
  const TestVolume<std::uint8_t> volume({60, 50, 40}, [&](auto, auto, auto) {
    return random() % 200 == 0 ? static_cast<double>(random() % 256) : 7.0;
  });
  for (const std::uint32_t n : {2u, 3u}) {
    const std::string path = temporary("rim.gvx");
    ASSERT_TRUE(write_store(volume, path, n, 8).ok());
    const auto reader = StoreReader::open(path).value();
    const TreeShape& shape = reader->info().shape;
    std::int64_t scale = 1;
    for (std::uint32_t l = shape.levels; l-- > 0; scale *= n) {
      const Vec3i nodes = shape.level_nodes(l);
      for (std::int64_t i = 0; i < nodes.x * nodes.y * nodes.z; ++i) {
        const Vec3i node{i % nodes.x, i / nodes.x % nodes.y, i / nodes.x / nodes.y};
        const NodeKey key{l, static_cast<std::uint32_t>(node.x), static_cast<std::uint32_t>(node.y),
                          static_cast<std::uint32_t>(node.z)};
        const ValueRange range = reader->node(key).value().ranges.channel[0];
        // At the finest level exactly, above it at least.
        float least = 255, greatest = 0;
        const std::int64_t rim = n, from = 8 * scale;
        for (std::int64_t z = node.z * from - rim; z < (node.z + 1) * from + rim; ++z) {
          for (std::int64_t y = node.y * from - rim; y < (node.y + 1) * from + rim; ++y) {
            for (std::int64_t x = node.x * from - rim; x < (node.x + 1) * from + rim; ++x) {
              least = std::min(least, static_cast<float>(volume.at(x, y, z)));
              greatest = std::max(greatest, static_cast<float>(volume.at(x, y, z)));
            }
          }
        }
        if (scale == 1) {
          ASSERT_EQ(range, (ValueRange{least, greatest}));
        } else {
          ASSERT_LE(range.minimum, least);
          ASSERT_GE(range.maximum, greatest);
        }
      }
    }
  }
}

TEST(Planes, of_labels_and_colours_are_kept_apart_at_every_level) {
  struct Case {
    VoxelFormat format;
    const char* name;
  };
  // 255 - 10 c, but for a normal: (2, 1, 2) / 3 times the opacity of 225 of 255.
  const auto value_of = [](int c) { return c < 4 ? 255 - 10 * c : c == 5 ? 164 : 202; };
  for (const Case& tested : {Case{{VoxelType::u16, VoxelContent::labels, 1}, "labels"},
                             Case{{VoxelType::u8, VoxelContent::color, 4}, "color"},
                             Case{{VoxelType::u8, VoxelContent::color_normal, 7}, "normal"},
                             Case{{VoxelType::u8, VoxelContent::scalar, 3}, "channels"}}) {
    const std::string path = temporary(tested.name);
    VolumeInfo info;
    info.shape = TreeShape::covering({30, 20, 25}, 2, 8);
    info.format = tested.format;
    auto writer = StoreWriter::create(path, info.shape, info.format).value();
    PyramidBuilder builder(exec::Device::cpu(2), *writer, info);
    // Each plane has a value of its own everywhere, but in an empty corner.
    std::vector<std::byte> bytes;
    for (int z = 0; z < 25; ++z) {
      for (int i = 0; i < 30 * 20; ++i) {
        for (std::uint32_t c = 0; c < info.format.planes; ++c) {
          const std::uint16_t value = i % 30 < 12 && z < 8 ? 0 : static_cast<std::uint16_t>(value_of(int(c)));
          const auto* word = reinterpret_cast<const std::byte*>(&value);
          bytes.insert(bytes.end(), word, word + voxel_bytes(info.format.type));
        }
      }
    }
    ASSERT_TRUE(builder.push_slices(25, bytes).ok());
    ASSERT_TRUE(builder.finish().ok());
    const auto report = verify(exec::Device::cpu(), path, {});
    ASSERT_TRUE(report.ok()) << report.error().message;
    const auto reader = StoreReader::open(path).value();
    EXPECT_EQ(reader->info().format, tested.format);
    EXPECT_EQ(reader->info().histograms.size(), tested.format.channels());
    for (std::uint32_t l = 0; l < info.shape.levels; ++l) {
      const Vec3i nodes = info.shape.level_nodes(l);
      const NodeKey key{l, static_cast<std::uint32_t>(nodes.x - 1), static_cast<std::uint32_t>(nodes.y - 1),
                        static_cast<std::uint32_t>(nodes.z - 1)};
      std::vector<std::byte> brick(reader->info().brick_bytes());
      ASSERT_TRUE(reader->read_brick(key, reader->node(key).value(), brick).ok());
      const std::size_t width = voxel_bytes(info.format.type), texels = plane_texels(8);
      const std::size_t last_full = (12 * 7 + 1) * 12 + 1;  // well inside, away from the empty corner
      const auto stored = [&](std::uint32_t c) {
        std::uint16_t value = 0;
        std::memcpy(&value, &brick[(c * texels + last_full) * width], width);
        return value;
      };
      for (std::uint32_t c = 0; c < info.format.planes; ++c) {
        const std::uint16_t value = stored(c);
        // Colours seen through a whole block are a little more, level by level, and normals go with the
        // opacity; all else is a mean.
        const bool more = tested.format.content >= VoxelContent::color && c < 4 && l + 1 < info.shape.levels;
        if (c >= 4) {
          EXPECT_NEAR(value, 127 + stored(3) / 225.0 * (value_of(int(c)) - 127), 2) << l << ' ' << c;
        } else if (more) {
          EXPECT_GE(value, 254 - 10 * int(c)) << tested.name << ' ' << l << ' ' << c;
        } else {
          EXPECT_NEAR(value, value_of(int(c)), 1) << tested.name << ' ' << l << ' ' << c;
        }
      }
    }
  }
}

TEST(Planes, normals_of_a_surface_are_not_shortened_by_what_is_inside) {
  const std::string path = temporary("surface");
  VolumeInfo info;
  info.shape = TreeShape::covering({16, 16, 16}, 2, 8);
  info.format = {VoxelType::u8, VoxelContent::color_normal, 7};
  auto writer = StoreWriter::create(path, info.shape, info.format).value();
  PyramidBuilder builder(exec::Device::cpu(2), *writer, info);
  // Opaque up to x = 7, where the surface faces x.
  std::vector<std::byte> slice;
  for (int i = 0; i < 16 * 16; ++i) {
    const int x = i % 16, full = x <= 7 ? 255 : 0;
    for (const int v : {full, full, full, full, x == 7 ? 254 : 127, 127, 127}) slice.push_back(std::byte(v));
  }
  for (int z = 0; z < 16; ++z) ASSERT_TRUE(builder.push_slices(1, slice).ok());
  ASSERT_TRUE(builder.finish().ok());
  const auto reader = StoreReader::open(path).value();
  std::vector<std::byte> brick(reader->info().brick_bytes());
  ASSERT_TRUE(reader->read_brick(NodeKey{}, reader->node(NodeKey{}).value(), brick).ok());
  const auto stored = [&](int x, std::size_t plane) {
    return static_cast<int>(
        brick[plane * plane_texels(8) + static_cast<std::size_t>((6 * 12 + 6) * 12 + x + 2)]);
  };
  EXPECT_EQ(stored(3, 3), 255);
  EXPECT_EQ(stored(3, 4), 254);
  EXPECT_EQ(stored(2, 4), 127);
  EXPECT_EQ(stored(3, 5), 127);
}

}  // namespace
}  // namespace gvx::store
