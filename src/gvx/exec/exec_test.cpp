// The conformance suite of exec: every operation on every device that is there.

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/exec/algorithms.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/for_each.h"
#include "gvx/exec/relaxed.h"
#include "gvx/exec/texture3d.h"

namespace gvx::exec {
namespace {

/// Index 0: one CPU thread, 1: all, 2: more threads than cores; 3: the first GPU.
class EveryDevice : public testing::TestWithParam<int> {
 protected:
  static Device device() {
    switch (GetParam()) {
      case 0:
        return Device::cpu(1);
      case 1:
        return Device::cpu();
      case 2:
        return Device::cpu(8);
      default:
        return Device::cuda().value();
    }
  }
};

std::string device_label(const testing::TestParamInfo<int>& info) {
  const char* labels[] = {"cpu_1_thread", "cpu_all_threads", "cpu_8_threads", "cuda"};
  return labels[info.param];
}

std::vector<int> devices_here() {
  std::vector<int> indices = {0, 1, 2};
  if (Device::cuda().ok()) indices.push_back(3);
  return indices;
}

INSTANTIATE_TEST_SUITE_P(, EveryDevice, testing::ValuesIn(devices_here()), device_label);

std::vector<std::uint32_t> random_words(std::size_t count, std::uint32_t below, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<std::uint32_t> value(0, below - 1);
  std::vector<std::uint32_t> words(count);
  for (auto& word : words) word = value(generator);
  return words;
}

Buffer<std::uint32_t> upload(const Device& device, const std::vector<std::uint32_t>& words) {
  Buffer<std::uint32_t> buffer(device, words.size());
  std::copy(words.begin(), words.end(), buffer.view().begin());
  return buffer;
}

std::vector<std::uint32_t> download(const Device& device, const Buffer<std::uint32_t>& buffer,
                                    std::size_t count) {
  device.synchronize();
  return {buffer.view().begin(), buffer.view().begin() + count};
}

struct CountVisits {
  BufferView<std::uint32_t> visits;
  GVX_HD void operator()(std::size_t i) const { visits[i] += 1 + static_cast<std::uint32_t>(i); }
};

TEST_P(EveryDevice, for_each_visits_every_index_once) {
  for (const std::size_t count : {0u, 1u, 255u, 257u, 100000u}) {
    Buffer<std::uint32_t> visits(device(), count);
    for_each(device(), "count_visits", count, CountVisits{visits.view()});
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(visits.view()[i], i + 1);
  }
}

struct MarkPixel {
  BufferView<std::uint32_t> pixels;
  std::uint32_t width;
  GVX_HD void operator()(std::uint32_t x, std::uint32_t y) const {
    pixels[y * width + x] += 1000 * x + y + 1;
  }
};

TEST_P(EveryDevice, for_each_pixel_visits_every_pixel_of_the_listed_tiles_once) {
  const TileGrid grid{37, 21, 16};
  const auto tiles = upload(device(), {5, 0, 2, 1});
  Buffer<std::uint32_t> pixels(device(), 37 * 21);
  EXPECT_TRUE(for_each_pixel(device(), "mark_pixel", grid, tiles.view(), no_deadline(),
                             MarkPixel{pixels.view(), 37}));
  for (std::uint32_t y = 0; y < 21; ++y) {
    for (std::uint32_t x = 0; x < 37; ++x) {
      const bool listed = y < 16 || x >= 32;  // tiles 3 and 4 are not
      ASSERT_EQ(pixels.view()[y * 37 + x], listed ? 1000 * x + y + 1 : 0) << x << ',' << y;
    }
  }
}

TEST_P(EveryDevice, for_each_pixel_begins_no_row_after_the_deadline) {
  const TileGrid grid{64, 64, 16};
  const auto tiles = upload(device(), {0, 1, 2, 3});
  Buffer<std::uint32_t> pixels(device(), 64 * 64);
  EXPECT_FALSE(for_each_pixel(device(), "mark_pixel", grid, tiles.view(), Deadline::min(),
                              MarkPixel{pixels.view(), 64}));
  for (const std::uint32_t pixel : pixels.view()) ASSERT_EQ(pixel, 0u);
}

TEST_P(EveryDevice, scan_equals_the_serial_sum) {
  for (const std::size_t count : {0u, 1u, 1000u, 200000u}) {
    const auto words = random_words(count, 7, 1);
    const auto input = upload(device(), words);
    Buffer<std::uint32_t> output(device(), count);
    const std::uint64_t sum = exclusive_scan(device(), input.view(), output.view());
    std::vector<std::uint32_t> expected(count);
    std::exclusive_scan(words.begin(), words.end(), expected.begin(), 0u);
    EXPECT_EQ(download(device(), output, count), expected);
    EXPECT_EQ(sum, std::accumulate(words.begin(), words.end(), std::uint64_t(0)));
  }
}

TEST_P(EveryDevice, partition_keeps_the_order_of_both_groups) {
  for (const std::size_t count : {0u, 1u, 1000u, 200000u}) {
    auto items = random_words(count, 1u << 30, 2);
    const auto flags = random_words(count, 2, 3);
    auto on_device = upload(device(), items);
    const auto flags_on_device = upload(device(), flags);
    Buffer<std::uint32_t> scratch(device(), count);
    const std::size_t first =
        stable_partition(device(), on_device.view(), flags_on_device.view(), scratch.view());

    std::vector<std::uint32_t> expected;
    for (const std::uint32_t group : {0u, 1u}) {
      for (std::size_t i = 0; i < count; ++i) {
        if (flags[i] == group) expected.push_back(items[i]);
      }
    }
    EXPECT_EQ(download(device(), on_device, count), expected);
    EXPECT_EQ(first, static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 0u)));
  }
}

TEST_P(EveryDevice, find_nonzero_lists_indices_in_order) {
  const auto words = random_words(100000, 3, 4);
  const auto input = upload(device(), words);
  Buffer<std::uint32_t> indices(device(), words.size());
  const std::size_t count = find_nonzero(device(), input.view(), indices.view());
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < words.size(); ++i) {
    if (words[i] != 0) expected.push_back(i);
  }
  EXPECT_EQ(download(device(), indices, count), expected);
}

struct SampleTexture {
  Texture3DView texture;
  BufferView<float> values;
  GVX_HD void operator()(std::size_t i) const {
    const auto s = static_cast<float>(i);
    values[i] = texture.sample(0.05f * s, 4.5f - 0.04f * s, 0.03f * s);
  }
};

TEST_P(EveryDevice, texture_filters_trilinearly_and_clamps) {
  // A function linear in each axis is reproduced exactly between texel centres and held constant beyond them.
  const Vec3u size{5, 4, 3};
  std::vector<float> texels;
  const auto field = [](float x, float y, float z) { return 1 + 2 * x - 3 * y + 0.5f * z + x * y * z; };
  for (std::uint32_t z = 0; z < size.z; ++z) {
    for (std::uint32_t y = 0; y < size.y; ++y) {
      for (std::uint32_t x = 0; x < size.x; ++x) texels.push_back(field(float(x), float(y), float(z)));
    }
  }
  const Texture3D texture(device(), size, texels);
  Buffer<float> values(device(), 101);
  for_each(device(), "sample_texture", 101, SampleTexture{texture.view(), values.view()});
  const float tolerance =
      device().kind() == DeviceKind::cuda ? 0.2f : 1e-4f;  // the unit's weights have 8 bits
  for (int i = 0; i <= 100; ++i) {
    const auto clamp = [](float v, float last) { return std::clamp(v - 0.5f, 0.0f, last); };
    const float s = static_cast<float>(i);
    EXPECT_NEAR(values.view()[i], field(clamp(0.05f * s, 4), clamp(4.5f - 0.04f * s, 3), clamp(0.03f * s, 2)),
                tolerance);
  }
}

struct WriteRelaxed {
  BufferView<std::uint32_t> word;
  BufferView<unsigned long long> sum;
  GVX_HD void operator()(std::size_t i) const {
    store_relaxed(&word[0], 42);
    add_relaxed(&sum[0], i);
  }
};

TEST_P(EveryDevice, relaxed_words_take_any_number_of_writers) {
  Buffer<std::uint32_t> word(device(), 1);
  Buffer<unsigned long long> sum(device(), 1);
  for_each(device(), "write_relaxed", 10000, WriteRelaxed{word.view(), sum.view()});
  EXPECT_EQ(word.view()[0], 42u);
  EXPECT_EQ(sum.view()[0], 10000ull * 9999 / 2);
}

TEST(Device, says_what_is_missing) {
  const auto device = Device::cuda();
  if (device.ok()) GTEST_SKIP() << "there is a GPU";
  EXPECT_NE(device.error().message.find("CUDA"), std::string::npos);
}

}  // namespace
}  // namespace gvx::exec
