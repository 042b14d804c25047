// Stores of version 2, written by a program that knew no other (testdata/*.gvx): today's program reads them
// as it reads a store that it makes of the same voxels.

#include <fstream>

#include <gtest/gtest.h>

#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

struct Stored {
  const char* name;
  Codec codec;
  VoxelFormat format;
  Vec3i dimensions;
  /// Number `plane` of a voxel.
  double (*value)(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t plane);
};

const Stored kStored[] = {
    {"scalar_u8",
     Codec::zstd,
     {VoxelType::u8, VoxelContent::scalar, 1},
     {21, 18, 9},
     [](auto x, auto y, auto z, auto) { return double(x < 12 ? x * 9 + y * y / 2 + z * (x % 3) : 90); }},
    {"constant_f32",
     Codec::zstd,
     {VoxelType::f32, VoxelContent::scalar, 1},
     {10, 17, 5},
     [](auto, auto, auto, auto) { return -2.5; }},
    {"channels_u16",
     Codec::none,
     {VoxelType::u16, VoxelContent::scalar, 2},
     {8, 5, 4},
     [](auto x, auto y, auto z, auto plane) { return double(1000 * plane + 20 * x + 300 * y + z); }},
    {"labels_u16",
     Codec::lz4,
     {VoxelType::u16, VoxelContent::labels, 1},
     {21, 11, 9},
     [](auto x, auto y, auto z, auto) { return double(x / 5 * 1000 + (y + z) / 6); }},
    {"colors",
     Codec::zstd,
     {VoxelType::u8, VoxelContent::color, 4},
     {18, 12, 9},
     [](auto x, auto y, auto z, auto plane) {
       return double(x < 9 ? 0 : plane == 3 ? 200 : (x * (plane + 1) + y + z) % 100);
     }},
};

VolumeInfo info_of(const Stored& stored) {
  VolumeInfo info;
  info.shape = TreeShape::covering(stored.dimensions, 2, 8);
  info.format = stored.format;
  info.codec = stored.codec;
  info.voxel_to_world = scaling(Vec3d(0.5, 0.25, 2));
  info.anatomical = true;
  info.scale = 0.125;
  info.offset = -7;
  info.source = stored.name;
  info.border = 1;
  return info;
}

std::vector<std::byte> voxels_of(const Stored& stored) {
  std::vector<std::byte> bytes;
  const Vec3i d = stored.dimensions;
  for (std::int64_t z = 0; z < d.z; ++z) {
    for (std::int64_t y = 0; y < d.y; ++y) {
      for (std::int64_t x = 0; x < d.x; ++x) {
        for (std::uint32_t plane = 0; plane < stored.format.planes; ++plane) {
          with_voxel_type(stored.format.type, [&](auto zero) {
            const auto v = static_cast<decltype(zero)>(stored.value(x, y, z, plane));
            const auto* first = reinterpret_cast<const std::byte*>(&v);
            bytes.insert(bytes.end(), first, first + sizeof(v));
          });
        }
      }
    }
  }
  return bytes;
}

void expect_same_bricks(const StoreReader& old, const StoreReader& now) {
  const TreeShape& shape = now.info().shape;
  std::vector<std::byte> old_brick(now.info().brick_bytes()), brick(old_brick.size());
  for (std::uint32_t l = 0; l < shape.levels; ++l) {
    const Vec3i nodes = shape.level_nodes(l);
    for (std::uint32_t z = 0; z < nodes.z; ++z) {
      for (std::uint32_t y = 0; y < nodes.y; ++y) {
        for (std::uint32_t x = 0; x < nodes.x; ++x) {
          const NodeKey key{l, x, y, z};
          const NodeRecord old_record = old.node(key).value(), record = now.node(key).value();
          ASSERT_EQ(old_record.ranges, record.ranges) << node_name(key);
          ASSERT_TRUE(old.read_brick(key, old_record, old_brick).ok());
          ASSERT_TRUE(now.read_brick(key, record, brick).ok());
          ASSERT_EQ(old_brick, brick) << node_name(key);
        }
      }
    }
  }
}

class Version2 : public testing::TestWithParam<Stored> {
 protected:
  std::string old_path() const {
    return std::string(GVX_SOURCE_DIR "/src/gvx/store/testdata/") + GetParam().name + ".gvx";
  }
};
INSTANTIATE_TEST_SUITE_P(, Version2, testing::ValuesIn(kStored),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(Version2, reads_as_a_store_made_today) {
  const auto old = StoreReader::open(old_path());
  ASSERT_TRUE(old.ok()) << old.error().message;
  EXPECT_EQ(old.value()->version(), 2u);
  EXPECT_TRUE(verify(exec::Device::cpu(), old_path(), {}).ok());

  const std::string path = testing::TempDir() + "gvx_version2_" + GetParam().name + ".gvx";
  const VolumeInfo info = info_of(GetParam());
  const auto writer = StoreWriter::create(path, info.shape, info.format).value();
  PyramidBuilder builder(exec::Device::cpu(2), *writer, info);
  ASSERT_TRUE(builder.push_slices(info.shape.dimensions.z, voxels_of(GetParam())).ok());
  ASSERT_TRUE(builder.finish().ok());
  const auto now = StoreReader::open(path).value();
  EXPECT_EQ(now->version(), 3u);

  const VolumeInfo &a = old.value()->info(), &b = now->info();
  EXPECT_EQ(a.shape.dimensions, b.shape.dimensions);
  EXPECT_EQ(a.shape.levels, b.shape.levels);
  EXPECT_EQ(a.format, b.format);
  EXPECT_EQ(a.codec, b.codec);
  EXPECT_EQ(a.border, 1u);
  EXPECT_EQ(a.voxel_to_world.column[1], b.voxel_to_world.column[1]);
  EXPECT_EQ(a.anatomical, b.anatomical);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.ranges, b.ranges);
  EXPECT_EQ(a.histograms, b.histograms);
  EXPECT_EQ(a.source, b.source);
  expect_same_bricks(*old.value(), *now);
}

TEST_P(Version2, every_flipped_byte_and_every_truncation_is_found) {
  std::ifstream file(old_path(), std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string path = testing::TempDir() + "gvx_version2_bad.gvx";
  const auto found = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), std::streamsize(bytes.size()));
    const auto report = verify(exec::Device::cpu(1), path, {});
    return !report.ok() && report.error().message.find(path) == 0;
  };
  ASSERT_FALSE(found(good));
  for (std::size_t i = 0; i < good.size(); i += i < 256 ? 1 : 17) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x04);
    ASSERT_TRUE(found(bad)) << "byte " << i;
    ASSERT_TRUE(found(good.substr(0, i))) << i << " bytes";
  }
}

}  // namespace
}  // namespace gvx::store
