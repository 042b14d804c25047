#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "gvx/produce/examine_element.h"
#include "gvx/produce/field_kernels.h"
#include "gvx/produce/field_producer.h"

namespace gvx::produce {
namespace {

TreeDescription bytes_tree() {
  TreeDescription tree;
  tree.m = 8;
  tree.max_level = 5;
  tree.scale = 1.0 / 255;
  return tree;
}

/// Nodes all over a level.
NodeKey some_node(std::uint32_t level, std::uint64_t i) {
  const std::uint64_t across = std::uint64_t{1} << level;
  return {level, i * 7 % across, (i * 5 + 3) % across, (i * 3 + across / 3) % across};
}

/// Bricks and bounds are those of the field but for roundings; the kernel's own bounds hold exactly.
void expect_alike(const Producer& field, const Producer& kernel, const std::string& what) {
  EXPECT_EQ(kernel.description().ranges, field.description().ranges) << what;
  int differing = 0, voxels = 0, made = 0;
  for (const std::uint32_t level : {0u, 2u, 3u, 5u}) {
    for (std::uint64_t i = 0; i < 40; ++i) {
      const NodeKey key = some_node(level, i);
      tree::NodeInfo a, b;
      ASSERT_TRUE(field.describe(std::span(&key, 1), std::span(&a, 1)).ok());
      ASSERT_TRUE(kernel.describe(std::span(&key, 1), std::span(&b, 1)).ok());
      EXPECT_NEAR(a.ranges.channel[0].minimum, b.ranges.channel[0].minimum, 1) << what;
      EXPECT_NEAR(a.ranges.channel[0].maximum, b.ranges.channel[0].maximum, 1) << what;
      EXPECT_EQ(a.terminal, b.terminal) << what;
      const std::size_t bytes = field.description().brick_bytes();
      std::vector<std::byte> by_field(bytes), by_kernel(bytes);
      ASSERT_TRUE(field.produce(key, by_field).ok());
      ASSERT_TRUE(kernel.produce(key, by_kernel).ok());
      ++made;
      for (std::size_t v = 0; v < 10 * 10 * 10; ++v, ++voxels) {
        const int difference = std::abs(int(by_field[v]) - int(by_kernel[v]));
        EXPECT_LE(difference, 1) << what;
        differing += difference != 0 ? 1 : 0;
        EXPECT_GE(float(by_kernel[v]), b.ranges.channel[0].minimum) << what;
        EXPECT_LE(float(by_kernel[v]), b.ranges.channel[0].maximum) << what;
      }
    }
  }
  EXPECT_EQ(made, 160);
  EXPECT_LT(differing, voxels / 1000) << what;
}

TEST(KernelProducer, makes_the_bricks_and_bounds_that_the_field_makes) {
  for (const exec::Device& device : exec::Device::all()) {
    for (std::size_t kind = 0; kind < kHypertextureNames.size(); ++kind) {
      HypertextureOptions options;
      options.kind = static_cast<HypertextureKind>(kind);
      options.noise.octaves = 5;
      const auto balls = cumulus_balls(4);
      const FieldProducer field(
          bytes_tree(), std::make_shared<HypertextureField>(std::make_shared<BallsField>(balls), options));
      expect_alike(field, *make_balls_producer(device, bytes_tree(), balls, options),
                   kHypertextureNames[kind] + (" on " + device.name()));
    }
    const TerrainOptions options{.noise = {.octaves = 9, .wavelength = 0.45, .seed = 11}};
    const FieldProducer field(bytes_tree(), std::make_shared<TerrainField>(options));
    expect_alike(field, *make_terrain_producer(device, bytes_tree(), options), "terrain on " + device.name());
  }
}

/// Keeps what a batch comes to.
struct ListSink final : ElementSink {
  explicit ListSink(std::size_t elements) : made(elements) {}
  void complete(std::size_t element, Result<Element> result) override { made[element] = std::move(result); }
  bool cancelled(std::size_t) override { return false; }
  void drop(std::size_t) override {}

  std::vector<std::optional<Result<Element>>> made;
};

TEST(KernelProducer, makes_of_a_batch_what_it_makes_one_by_one) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::f32}) {
    TreeDescription tree = bytes_tree();
    tree.format.type = type;
    tree.scale = type == VoxelType::f32 ? 1 : type == VoxelType::u16 ? 1.0 / 65535 : 1.0 / 255;
    for (const exec::Device& device : exec::Device::all()) {
      const auto producer = make_terrain_producer(device, tree, {});
      std::vector<NodeKey> nodes;
      for (std::uint64_t i = 0; i < 40; ++i) nodes.push_back(some_node(i % 2 == 0 ? 3 : 5, i));
      int constant = 0, mixed = 0;
      for (const ElementKind kind : {ElementKind::brick, ElementKind::children}) {
        const auto sink = std::make_shared<ListSink>(nodes.size());
        producer->start({kind, nodes}, sink);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          ASSERT_TRUE(sink->made[i] && sink->made[i]->ok());
          Element& made = sink->made[i]->value();
          const bool here = makes_host_memory(*producer);
          if (kind == ElementKind::brick) examine_element(tree, nodes[i], here, made);
          const Element alone = make_element(*producer, nodes[i], kind).value();
          EXPECT_EQ(made.constant, alone.constant);
          EXPECT_EQ(made.child_keys, alone.child_keys);
          ASSERT_EQ(made.children.size(), alone.children.size());
          for (std::size_t c = 0; c < alone.children.size(); ++c) {
            EXPECT_EQ(made.children[c].ranges, alone.children[c].ranges);
            EXPECT_EQ(made.children[c].terminal, alone.children[c].terminal);
          }
          if (kind == ElementKind::children) continue;
          std::vector<std::byte> on_host(tree.brick_bytes());
          ASSERT_TRUE(producer->produce(nodes[i], on_host).ok());
          ASSERT_EQ(made.voxels.size(), on_host.size());
          EXPECT_EQ(std::memcmp(made.voxels.data(), on_host.data(), on_host.size()), 0);
          const std::size_t element = voxel_bytes(type), plane = plane_texels(tree.m) * element;
          const bool one_value = std::memcmp(&on_host[0], &on_host[element], plane - element) == 0;
          EXPECT_EQ(made.constant.has_value(), one_value && nodes[i].level == tree.max_level);
          (one_value ? constant : mixed) += 1;
        }
      }
      EXPECT_GT(constant, 5);
      EXPECT_GT(mixed, 5);
    }
  }
}

}  // namespace
}  // namespace gvx::produce
