#include "gvx/produce/check_arguments.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/produce/amplify_producer.h"
#include "gvx/produce/deeper_producer.h"
#include "gvx/produce/field_producer.h"
#include "gvx/produce/repeat_producer.h"
#include "gvx/produce/sampled_bounds.h"
#include "gvx/produce/sponge_producer.h"
#include "gvx/produce/store_producer.h"

namespace gvx::produce {
namespace {

float ramp(Vec3d p) {
  return static_cast<float>(p.x);
}

ValueRange ramp_bounds(const Box3d& box) {
  return {static_cast<float>(box.minimum.x), static_cast<float>(box.maximum.x)};
}

std::shared_ptr<const Producer> ramp_of(const TreeDescription& tree) {
  return std::make_shared<FieldProducer>(tree, std::make_shared<FunctionField>(ramp, ramp_bounds));
}

std::string describe_root(const Producer& producer) {
  const NodeKey root;
  tree::NodeInfo info;
  const Status status = producer.describe(std::span(&root, 1), std::span(&info, 1));
  return status.ok() ? "" : status.error().message;
}

std::string produce_root(const Producer& producer, std::size_t bytes) {
  std::vector<std::byte> brick(bytes);
  const Status status = producer.produce(NodeKey{}, brick);
  return status.ok() ? "" : status.error().message;
}

TEST(FieldProducer, a_tree_that_cannot_be_is_an_error_of_what_is_asked) {
  const auto expect = [](auto change, const char* what) {
    TreeDescription tree;
    EXPECT_EQ(describe_root(*ramp_of(tree)), "");
    change(tree);
    const auto producer = ramp_of(tree);
    EXPECT_NE(describe_root(*producer).find(what), std::string::npos) << describe_root(*producer);
    EXPECT_NE(produce_root(*producer, 8).find(what), std::string::npos) << what;
  };
  expect([](auto& tree) { tree.n = 0; }, "expected 2 or 3");
  expect([](auto& tree) { tree.m = 0; }, "expected 8, 16 or 32");
  expect([](auto& tree) { tree.max_level = 1000; }, "finest level of 1000");
  expect([](auto& tree) { tree.format.planes = 2; }, "one channel");
  expect([](auto& tree) { tree.format.content = VoxelContent::labels; }, "labels");
  expect([](auto& tree) { tree.scale = 0; }, "scale above 0");
  expect([](auto& tree) { tree.offset = NAN; }, "finite");
}

TEST(FieldProducer, no_field_is_an_error_of_what_is_asked) {
  EXPECT_NE(describe_root(FieldProducer({}, nullptr)).find("there is none"), std::string::npos);
  EXPECT_NE(describe_root(FieldProducer({}, ramp, nullptr)).find("there is none"), std::string::npos);
}

TEST(Producers, memory_of_another_size_than_a_brick_is_an_error) {
  const auto field = ramp_of({});
  for (const auto& producer : {field, std::shared_ptr<const Producer>(std::make_shared<SpongeProducer>()),
                               std::shared_ptr<const Producer>(RepeatProducer::create(field, 2).value()),
                               std::shared_ptr<const Producer>(AmplifyProducer::create(field, {}).value())}) {
    const std::size_t bytes = producer->description().brick_bytes();
    EXPECT_EQ(produce_root(*producer, bytes), "");
    EXPECT_NE(produce_root(*producer, bytes - 1).find(std::to_string(bytes)), std::string::npos);
    EXPECT_NE(produce_root(*producer, 0).find("memory of 0 bytes"), std::string::npos);
  }
}

TEST(Producers, that_build_on_another_refuse_null) {
  EXPECT_NE(RepeatProducer::create(nullptr, 1).error().message.find("null"), std::string::npos);
  EXPECT_NE(AmplifyProducer::create(nullptr, {}).error().message.find("null"), std::string::npos);
  EXPECT_NE(DeeperProducer::create(nullptr, 1).error().message.find("null"), std::string::npos);
  const StoreProducer none(nullptr);
  EXPECT_NE(describe_root(none).find("null"), std::string::npos);
  EXPECT_NE(produce_root(none, 0).find("null"), std::string::npos);
  EXPECT_EQ(none.bytes_read(), 0u);
  EXPECT_EQ(none.times().reading_milliseconds, 0);
}

TEST(Producers, levels_without_end_are_an_error) {
  const auto field = ramp_of({});
  EXPECT_FALSE(RepeatProducer::create(field, UINT32_MAX).ok());
  EXPECT_FALSE(AmplifyProducer::create(field, {.levels = UINT32_MAX}).ok());
  EXPECT_FALSE(DeeperProducer::create(field, UINT32_MAX).ok());
}

TEST(AmplifyProducer, noise_that_cannot_be_is_an_error) {
  EXPECT_FALSE(AmplifyProducer::create(ramp_of({}), {.wavelength = 0}).ok());
  EXPECT_FALSE(AmplifyProducer::create(ramp_of({}), {.strength = NAN}).ok());
}

TEST(SpongeProducer, a_hole_has_no_brick) {
  const SpongeProducer sponge;
  std::vector<std::byte> brick(sponge.description().brick_bytes());
  EXPECT_FALSE(sponge.produce({1, 1, 1, 1}, brick).ok());
  EXPECT_TRUE(sponge.produce({1, 0, 0, 0}, brick).ok());
}

TEST(SampledBounds, options_out_of_range_are_errors) {
  const auto message = [](FunctionField::Values values, const SampledBoundsOptions& options) {
    const auto bounds = SampledBounds::create(std::move(values), options);
    return bounds.ok() ? std::string() : bounds.error().message;
  };
  EXPECT_EQ(message(ramp, {}), "");
  EXPECT_NE(message(nullptr, {}).find("function is empty"), std::string::npos);
  EXPECT_NE(message(ramp, {.feature = 0}).find("feature above 0"), std::string::npos);
  EXPECT_NE(message(ramp, {.margin = NAN}).find("margin"), std::string::npos);
  EXPECT_NE(message(ramp, {.samples = 1}).find("expected 2 to 32"), std::string::npos);
  EXPECT_NE(message(ramp, {.samples = 33}).find("expected 2 to 32"), std::string::npos);
}

}  // namespace
}  // namespace gvx::produce
