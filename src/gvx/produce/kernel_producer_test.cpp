#include <cstdlib>
#include <cstring>

#include <gtest/gtest.h>

#include "gvx/produce/balls_kernel.h"
#include "gvx/produce/field_producer.h"

namespace gvx::produce {
namespace {

TEST(KernelProducer, makes_the_bricks_and_bounds_that_the_field_makes) {
  for (std::size_t kind = 0; kind < kHypertextureNames.size(); ++kind) {
    HypertextureOptions options;
    options.kind = static_cast<HypertextureKind>(kind);
    options.noise.octaves = 5;
    TreeDescription tree;
    tree.m = 8;
    tree.max_level = 5;
    tree.scale = 1.0 / 255;
    const auto balls = cumulus_balls(4);
    const FieldProducer field(
        tree, std::make_shared<HypertextureField>(std::make_shared<BallsField>(balls), options));
    for (const exec::Device& device : exec::Device::all()) {
      const auto kernel = make_balls_producer(device, tree, balls, options);
      EXPECT_EQ(kernel->description().ranges, field.description().ranges);
      int differing = 0, voxels = 0, made = 0;
      for (const std::uint32_t level : {0u, 2u, 3u, 5u}) {
        for (std::uint64_t i = 0; i < 40; ++i) {
          const std::uint64_t across = std::uint64_t{1} << level;
          const NodeKey key{level, i * 7 % across, (i * 5 + 3) % across, (i * 3 + across / 3) % across};
          tree::NodeInfo a, b;
          ASSERT_TRUE(field.describe(std::span(&key, 1), std::span(&a, 1)).ok());
          ASSERT_TRUE(kernel->describe(std::span(&key, 1), std::span(&b, 1)).ok());
          EXPECT_NEAR(a.ranges.channel[0].minimum, b.ranges.channel[0].minimum, 1);
          EXPECT_NEAR(a.ranges.channel[0].maximum, b.ranges.channel[0].maximum, 1);
          EXPECT_EQ(a.terminal, b.terminal);
          std::vector<std::byte> by_field(tree.brick_bytes()), by_kernel(tree.brick_bytes());
          ASSERT_TRUE(field.produce(key, by_field).ok());
          ASSERT_TRUE(kernel->produce(key, by_kernel).ok());
          ++made;
          for (std::size_t v = 0; v < 10 * 10 * 10; ++v, ++voxels) {
            const int difference = std::abs(int(by_field[v]) - int(by_kernel[v]));
            EXPECT_LE(difference, 1);
            differing += difference != 0 ? 1 : 0;
            // The kernel's own oracle holds.
            EXPECT_GE(float(by_kernel[v]), b.ranges.channel[0].minimum);
            EXPECT_LE(float(by_kernel[v]), b.ranges.channel[0].maximum);
          }
        }
      }
      EXPECT_EQ(made, 160);
      EXPECT_LT(differing, voxels / 1000) << kHypertextureNames[kind] << " on " << device.name();
    }
  }
}

}  // namespace
}  // namespace gvx::produce
