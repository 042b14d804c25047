// What a store may hold beyond voxels of one border: sections and payloads of programs to come, borders of
// two, levels that are mostly of one value.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "gvx/store/codec.h"
#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

std::string temporary(const std::string& name) {
  return testing::TempDir() + "gvx_parts_" + name + ".gvx";
}

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// A store whose whole tree has one value.
VolumeInfo constant_info(Vec3i dimensions) {
  VolumeInfo info;
  info.shape = TreeShape::covering(dimensions, 2, 16);
  info.ranges = ValueRange{7, 7};
  info.histograms.emplace_back(kHistogramBins);
  return info;
}

TEST(Sections, that_are_not_known_are_listed_and_checked_and_otherwise_ignored) {
  const std::string path = temporary("unknown");
  const VolumeInfo info = constant_info({40, 40, 40});
  {
    const auto writer = StoreWriter::create(path, info.shape, info.format).value();
    for (std::uint32_t l = 0; l < info.shape.levels; ++l) {
      ASSERT_TRUE(writer->set_background(l, ValueRange{7, 7}).ok());
    }
    ASSERT_TRUE(writer->add_section("light", 4, false, bytes_of(std::string(3'000'000, 'l'))).ok());
    ASSERT_TRUE(writer->add_section("time", 1, false, {}).ok());
    ASSERT_TRUE(writer->finish(info).ok());
  }
  const auto reader = StoreReader::open(path).value();
  const auto& sections = reader->sections();
  ASSERT_EQ(sections.size(), 5u);
  EXPECT_EQ(sections[0].name, "light");
  EXPECT_EQ(sections[0].version, 4u);
  EXPECT_EQ(sections[0].bytes, 3'000'000u);
  EXPECT_FALSE(sections[0].required);
  EXPECT_EQ(reader->node({2, 1, 1, 1}).value().ranges, ChannelRanges(ValueRange{7, 7}));
  ASSERT_TRUE(verify(exec::Device::cpu(), path, {}).ok());

  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(sections[0].offset + 2'500'000));
  file.put('L');
  file.close();
  const auto report = verify(exec::Device::cpu(), path, {});
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("section \"light\""), std::string::npos) << report.error().message;
}

TEST(Sections, that_are_required_and_not_known_are_an_error_that_names_them) {
  const std::string path = temporary("required");
  const VolumeInfo info = constant_info({40, 40, 40});
  const auto writer = StoreWriter::create(path, info.shape, info.format).value();
  for (std::uint32_t l = 0; l < info.shape.levels; ++l) {
    ASSERT_TRUE(writer->set_background(l, ValueRange{7, 7}).ok());
  }
  ASSERT_TRUE(writer->add_section("twenty-four-letters-name", 2, true, bytes_of("x")).ok());
  ASSERT_TRUE(writer->finish(info).ok());
  const auto opened = StoreReader::open(path);
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().message,
            path +
                ": made by a newer gvx: this program does not know section \"twenty-four-letters-name\" "
                "(version 2), which is required to read the store");
}

/// A store of one node with records that hold two more payloads and a number.
Status write_richer(const std::string& path, bool required) {
  const VolumeInfo info = constant_info({16, 16, 16});
  const RecordLayout::Extra extras[] = {
      {"surface"}, {"content-error", FieldKind::values, 4, required}, {"light"}};
  const RecordLayout layout(info.format, extras);
  GVX_ASSIGN(const auto writer, StoreWriter::create(path, info.shape, layout));
  const std::vector<std::byte> brick(info.brick_bytes(), std::byte{7});
  std::vector<std::byte> compressed;
  compress(info.codec, {1, info.texels(1)}, brick, compressed);
  GVX_ASSIGN(const NodeRecord node, writer->add_brick(compressed, ValueRange{7, 7}));
  GVX_ASSIGN(const BlockRef light, writer->add_block(bytes_of(std::string(1000, 'l'))));
  std::vector<std::byte> page(std::size_t{kPageNodes} * layout.bytes());
  layout.encode(node, page.data());
  std::memcpy(page.data() + layout.other_payloads()[1].offset, &light, sizeof(light));
  GVX_TRY(writer->add_page(0, {}, page));
  return writer->finish(info);
}

TEST(Records, with_payloads_that_are_not_known_are_read_and_checked) {
  const std::string path = temporary("richer");
  ASSERT_TRUE(write_richer(path, false).ok());
  const auto reader = StoreReader::open(path).value();
  EXPECT_EQ(reader->index().layout().bytes(), 16u + 8 + 16 + 4 + 16);
  ASSERT_EQ(reader->index().layout().other_payloads().size(), 2u);
  const NodeRecord record = reader->node({}).value();
  EXPECT_FALSE(record.constant());
  std::vector<std::byte> brick(reader->info().brick_bytes());
  ASSERT_TRUE(reader->read_brick({}, record, brick).ok());
  EXPECT_EQ(brick[5], std::byte{7});
  const auto sound = verify(exec::Device::cpu(), path, {});
  ASSERT_TRUE(sound.ok()) << sound.error().message;

  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(record.offset + record.bytes + 999));
  file.put('L');
  file.close();
  const auto report = verify(exec::Device::cpu(), path, {});
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("payload \"light\" of node (level 0: 0, 0, 0)"), std::string::npos)
      << report.error().message;
}

TEST(Records, with_a_required_field_that_is_not_known_are_an_error_that_names_it) {
  const std::string path = temporary("required_field");
  ASSERT_TRUE(write_richer(path, true).ok());
  const auto opened = StoreReader::open(path);
  ASSERT_FALSE(opened.ok());
  EXPECT_NE(opened.error().message.find("does not know field \"content-error\""), std::string::npos)
      << opened.error().message;
}

TEST(Records, of_one_channel_take_24_bytes_and_of_four_48) {
  EXPECT_EQ(RecordLayout({VoxelType::u8, VoxelContent::scalar, 1}).bytes(), 24u);
  EXPECT_EQ(RecordLayout({VoxelType::f32, VoxelContent::scalar, 4}).bytes(), 48u);
  EXPECT_EQ(RecordLayout({VoxelType::u8, VoxelContent::color_normal, 7}).bytes(), 24u);
}

struct Bordered {
  std::uint32_t n, m;
};
class BorderOfTwo : public testing::TestWithParam<Bordered> {};
INSTANTIATE_TEST_SUITE_P(, BorderOfTwo,
                         testing::Values(Bordered{2, 8}, Bordered{2, 16}, Bordered{3, 8}, Bordered{2, 32}),
                         [](const auto& tested) {
                           return "N" + std::to_string(tested.param.n) + "_M" +
                                  std::to_string(tested.param.m);
                         });

template <typename Voxel>
void expect_border_of_two_right(const Bordered& tested, Codec codec) {
  const TestVolume<Voxel> volume(
      {53, 37, 29}, [](auto x, auto y, auto z) { return x > 30 ? 9 : (x * 7 + y * 3 + z * z) % 251; });
  const std::string narrow_path = temporary("narrow"), wide_path = temporary("wide");
  ASSERT_TRUE(write_store(volume, narrow_path, tested.n, tested.m, codec).ok());
  ASSERT_TRUE(write_store(volume, wide_path, tested.n, tested.m, codec, 2, 2).ok());
  const auto narrow = StoreReader::open(narrow_path).value(), wide = StoreReader::open(wide_path).value();
  const auto sound = verify(exec::Device::cpu(), wide_path, {});
  ASSERT_TRUE(sound.ok()) << sound.error().message;
  EXPECT_EQ(narrow->info().border, 1u);
  ASSERT_EQ(wide->info().border, 2u);
  const TreeShape& shape = wide->info().shape;
  std::vector<std::byte> from_narrow(narrow->info().brick_bytes(1)), cropped(from_narrow.size()),
      whole(wide->info().brick_bytes(2));
  const std::int64_t edge = tested.m;
  for (std::uint32_t l = 0; l < shape.levels; ++l) {
    const Vec3i nodes = shape.level_nodes(l);
    for (std::uint32_t z = 0; z < nodes.z; ++z) {
      for (std::uint32_t y = 0; y < nodes.y; ++y) {
        for (std::uint32_t x = 0; x < nodes.x; ++x) {
          const NodeKey key{l, x, y, z};
          const NodeRecord record = wide->node(key).value();
          ASSERT_EQ(record.ranges, narrow->node(key).value().ranges);
          ASSERT_TRUE(narrow->read_brick(key, narrow->node(key).value(), from_narrow, 1).ok());
          ASSERT_TRUE(wide->read_brick(key, record, cropped, 1).ok());
          ASSERT_EQ(from_narrow, cropped) << node_name(key);
          ASSERT_TRUE(wide->read_brick(key, record, whole, 2).ok());
          if (l + 1 < shape.levels) continue;
          const auto* at = reinterpret_cast<const Voxel*>(whole.data());
          for (std::int64_t k = -2; k < edge + 2; ++k) {
            for (std::int64_t j = -2; j < edge + 2; ++j) {
              for (std::int64_t i = -2; i < edge + 2; ++i, ++at) {
                ASSERT_EQ(*at, volume.at(x * edge + i, y * edge + j, z * edge + k)) << node_name(key);
              }
            }
          }
        }
      }
    }
  }
}

TEST_P(BorderOfTwo, holds_the_voxels_there_and_gives_bricks_with_one) {
  expect_border_of_two_right<std::uint8_t>(GetParam(), Codec::zstd);
  expect_border_of_two_right<float>(GetParam(), Codec::none);
}

/// All of a brick's texels, with a border of two, of a store with one.
template <typename Voxel, typename Expected>
void expect_widened(VoxelContent content, const Expected& expected) {
  const TestVolume<Voxel> volume({24, 24, 24}, [](auto x, auto y, auto z) { return 10 + x + 3 * y + 5 * z; });
  const std::string path = temporary("one");
  ASSERT_TRUE(write_store(volume, path, 2, 8, Codec::zstd, 2, 1, content).ok());
  const auto reader = StoreReader::open(path).value();
  const NodeKey middle{reader->info().shape.levels - 1, 1, 1, 1};
  std::vector<std::byte> brick(reader->info().brick_bytes(2));
  ASSERT_TRUE(reader->read_brick(middle, reader->node(middle).value(), brick, 2).ok());
  const auto* at = reinterpret_cast<const Voxel*>(brick.data());
  for (std::int64_t k = 6; k < 18; ++k) {
    for (std::int64_t j = 6; j < 18; ++j) {
      for (std::int64_t i = 6; i < 18; ++i, ++at) ASSERT_EQ(*at, expected(volume, i, j, k)) << i << j << k;
    }
  }
}

TEST(Border, that_is_not_stored_goes_on_as_the_voxels_do) {
  const auto linear = [](const auto& volume, auto x, auto y, auto z) { return volume.at(x, y, z); };
  expect_widened<std::uint8_t>(VoxelContent::scalar, linear);
  expect_widened<float>(VoxelContent::scalar, linear);
  const auto held = [](auto i) { return std::clamp<std::int64_t>(i, 7, 16); };
  expect_widened<std::uint16_t>(VoxelContent::labels, [&](const auto& volume, auto x, auto y, auto z) {
    return volume.at(held(x), held(y), held(z));
  });
}

TEST(NoData, is_kept) {
  VolumeInfo info = constant_info({16, 16, 16});
  info.no_data = true;
  const std::string path = temporary("no_data");
  const auto writer = StoreWriter::create(path, info.shape, info.format).value();
  ASSERT_TRUE(writer->set_background(0, ValueRange{7, 7}).ok());
  ASSERT_TRUE(writer->finish(info).ok());
  EXPECT_TRUE(StoreReader::open(path).value()->info().no_data);
}

/// A page of u8 nodes, of which the first has a brick of noise.
std::vector<std::byte> page_with_a_brick(StoreWriter& writer, const VolumeInfo& info) {
  std::vector<std::byte> brick(info.brick_bytes()), compressed;
  for (std::size_t i = 0; i < info.texels(1); ++i) brick[i] = std::byte(i * i % 7);
  compress(info.codec, {1, info.texels(1)}, brick, compressed);
  const RecordLayout layout(info.format);
  std::vector<std::byte> page(std::size_t{kPageNodes} * layout.bytes());
  for (std::size_t i = 0; i < kPageNodes; ++i) {
    const NodeRecord record = i == 0 ? writer.add_brick(compressed, ValueRange{0, 7}).value()
                                     : NodeRecord{0, 0, 0, ValueRange{7, 7}};
    layout.encode(record, page.data() + i * layout.bytes());
  }
  return page;
}

TEST(SparseStore, of_65536_voxels_along_each_axis_is_small_and_opens_with_a_few_kilobytes) {
  VolumeInfo info = constant_info({65536, 65536, 65536});
  info.ranges = ValueRange{0, 7};
  const std::string path = temporary("sparse");
  const std::uint32_t finest = info.shape.levels - 1;
  const Vec3i pages[] = {{0, 0, 0}, {511, 0, 3}, {100, 200, 300}, {101, 200, 300}, {511, 511, 511}};
  {
    const auto writer = StoreWriter::create(path, info.shape, info.format).value();
    for (std::uint32_t l = 0; l < info.shape.levels; ++l) {
      ASSERT_TRUE(writer->set_background(l, ValueRange{7, 7}).ok());
    }
    // On each level above a brick where one is below, so that ranges hold what is below them.
    for (std::uint32_t l = 0; l <= finest; ++l) {
      std::vector<Vec3i> here;
      for (const Vec3i& page : pages) {
        const Vec3i node = page * std::int64_t{kPageEdge};
        Vec3i above;
        for (int axis = 0; axis < 3; ++axis) above[axis] = node[axis] >> (finest - l) >> 3;
        if (std::find(here.begin(), here.end(), above) == here.end()) here.push_back(above);
      }
      std::stable_sort(here.begin(), here.end(), [](const Vec3i& a, const Vec3i& b) { return a.z < b.z; });
      const RecordLayout layout(info.format);
      for (const Vec3i& page : here) {
        std::vector<std::byte> records = page_with_a_brick(*writer, info);
        if (l < finest) {
          // Any of the page's nodes may have a brick below.
          for (std::size_t i = 1; i < kPageNodes; ++i) {
            std::copy(records.begin(), records.begin() + layout.bytes(),
                      records.begin() + static_cast<std::ptrdiff_t>(i * layout.bytes()));
          }
        }
        ASSERT_TRUE(writer->add_page(l, page, records).ok());
      }
    }
    ASSERT_TRUE(writer->finish(info).ok());
  }
  EXPECT_LT(std::filesystem::file_size(path), 200'000u);
  const auto reader = StoreReader::open(path).value();
  EXPECT_LT(reader->bytes_read(), 8192u);
  for (const Vec3i& page : pages) {
    const auto at = [](std::int64_t p) { return static_cast<std::uint64_t>(p * kPageEdge); };
    const NodeKey key{finest, at(page.x), at(page.y), at(page.z)};
    EXPECT_FALSE(reader->node(key).value().constant());
    EXPECT_TRUE(reader->node({finest, key.x + 1, key.y, key.z}).value().constant());
  }
  const NodeRecord air = reader->node({finest, 2000, 2000, 5}).value();
  EXPECT_TRUE(air.constant());
  EXPECT_EQ(air.ranges, ChannelRanges(ValueRange{7, 7}));
  EXPECT_LT(reader->bytes_read(), 100'000u);
  const auto report = verify(exec::Device::cpu(), path, {});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report.value().nodes, info.shape.nodes());
}

TEST(SparseStore, finds_each_node_of_a_tree_whose_index_has_three_heights) {
  // 1200 nodes of 8 voxels along x are 150 pages, 19 pages above them, and 3 above those.
  const TestVolume<std::uint16_t> volume(
      {9600, 3, 2}, [](auto x, auto y, auto z) { return x > 4000 && x < 8000 ? 5 : x + y + z; });
  const std::string path = temporary("long");
  ASSERT_TRUE(write_store(volume, path, 2, 8).ok());
  const auto reader = StoreReader::open(path).value();
  const std::uint32_t finest = reader->info().shape.levels - 1;
  EXPECT_EQ(reader->info().shape.index_height(finest), 3u);
  for (std::uint64_t x = 0; x < 1200; ++x) {
    const NodeRecord record = reader->node({finest, x, 0, 0}).value();
    const std::int64_t first = static_cast<std::int64_t>(x) * 8 - 2;
    EXPECT_EQ(record.ranges.channel[0].minimum, std::min(volume.at(first, 0, 0), volume.at(first + 11, 0, 0)))
        << x;
  }
  const auto report = verify(exec::Device::cpu(), path, {});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report.value().nodes, reader->info().shape.nodes());
}

TEST(StoreReader, an_index_that_may_keep_what_it_wants_reads_each_page_once) {
  const TestVolume<std::uint8_t> volume({300, 200, 150},
                                        [](auto x, auto y, auto z) { return 3 * x ^ y ^ z; });
  const std::string path = temporary("wanted");
  ASSERT_TRUE(write_store(volume, path, 2, 8).ok());
  const auto reader = StoreReader::open(path).value();
  const PageIndex& index = reader->index();
  index.keep_at_most(index.wanted_bytes());
  const auto read_all = [&] {
    for (std::uint32_t level = 0; level < reader->info().shape.levels; ++level) {
      const Vec3i nodes = reader->info().shape.level_nodes(level);
      for (std::int64_t i = 0; i < nodes.x * nodes.y * nodes.z; ++i) {
        const NodeKey key{level, static_cast<std::uint64_t>(i % nodes.x),
                          static_cast<std::uint64_t>(i / nodes.x % nodes.y),
                          static_cast<std::uint64_t>(i / nodes.x / nodes.y)};
        ASSERT_TRUE(reader->node(key).ok());
      }
    }
  };
  read_all();
  const std::uint64_t once = reader->bytes_read();
  EXPECT_LT(index.wanted_bytes(), PageIndex::kCacheBytes);
  EXPECT_LE(index.cached_bytes(), index.wanted_bytes());
  read_all();
  EXPECT_EQ(reader->bytes_read(), once);
}

TEST(StoreReader, many_threads_find_the_same_records) {
  const TestVolume<std::uint8_t> volume({200, 150, 60}, [](auto x, auto y, auto z) { return x ^ y ^ z; });
  const std::string path = temporary("threads");
  ASSERT_TRUE(write_store(volume, path, 2, 8).ok());
  const auto reader = StoreReader::open(path).value();
  const auto alone = StoreReader::open(path).value();
  const std::uint32_t finest = reader->info().shape.levels - 1;
  const Vec3i nodes = reader->info().shape.level_nodes(finest);
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (std::int64_t i = 0; i < nodes.x * nodes.y * nodes.z; ++i) {
        const NodeKey key{finest, static_cast<std::uint64_t>(i % nodes.x),
                          static_cast<std::uint64_t>(i / nodes.x % nodes.y),
                          static_cast<std::uint64_t>(i / nodes.x / nodes.y)};
        if (reader->node(key).value().ranges != alone->node(key).value().ranges) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(reader->index().cached_bytes(), 2 * PageIndex::kCacheBytes);
}

}  // namespace
}  // namespace gvx::store
