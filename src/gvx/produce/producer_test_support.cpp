#include "gvx/produce/producer_test_support.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "gvx/produce/amplify_producer.h"
#include "gvx/produce/deeper_producer.h"
#include "gvx/produce/field_producer.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/produce/repeat_producer.h"
#include "gvx/produce/sponge_producer.h"
#include "gvx/produce/store_producer.h"
#include "gvx/produce/terrain.h"
#include "gvx/store/store_test_support.h"

namespace gvx::produce {
namespace {

std::shared_ptr<const Producer> make_hypertexture(HypertextureKind kind) {
  HypertextureOptions options;
  options.kind = kind;
  return make_density(
      std::make_shared<HypertextureField>(std::make_shared<BallsField>(cumulus_balls(3)), options), 16);
}

std::shared_ptr<const Producer> make_sparse_hypertexture() {
  const HypertextureOptions options;
  auto sparse =
      std::make_shared<SparseField>(std::make_shared<BallsField>(cumulus_balls(3)), options.thickness);
  return make_density(std::make_shared<HypertextureField>(std::move(sparse), options), 16);
}

}  // namespace

std::shared_ptr<const Producer> make_store_producer() {
  const store::TestVolume<std::uint8_t> volume({50, 40, 30}, [](auto x, auto y, auto z) {
    return x > 30 ? 9 : 100 + 50 * std::sin(double(x) * 0.4) + double(y % 7) + double(z);
  });
  const std::string path = testing::TempDir() + "gvx_producer.gvx";
  GVX_CHECK(store::write_store(volume, path, 2, 8, store::Codec::zstd, 2, 2).ok());
  return std::make_shared<StoreProducer>(store::StoreReader::open(path).value());
}

std::shared_ptr<const Producer> make_field_producer() {
  TreeDescription tree;
  tree.n = 3;
  tree.m = 8;
  tree.max_level = 3;
  return std::make_shared<FieldProducer>(
      tree, [](Vec3d p) { return static_cast<float>(p.x + 2 * p.y - p.z); },
      [](const Box3d& b) {
        return ValueRange{
            std::nextafter(static_cast<float>(b.minimum.x + 2 * b.minimum.y - b.maximum.z), -INFINITY),
            std::nextafter(static_cast<float>(b.maximum.x + 2 * b.maximum.y - b.minimum.z), INFINITY)};
      });
}

std::shared_ptr<const Producer> make_density(std::shared_ptr<const Field> field, std::uint32_t m) {
  TreeDescription tree;
  tree.m = m;
  tree.max_level = 6;
  tree.scale = 1.0 / 255;
  return std::make_shared<FieldProducer>(tree, std::move(field));
}

std::shared_ptr<const Producer> repeated(std::shared_ptr<const Producer> volume, std::uint32_t levels) {
  return RepeatProducer::create(std::move(volume), levels).value();
}

std::shared_ptr<const Producer> amplified(std::shared_ptr<const Producer> volume) {
  return AmplifyProducer::create(std::move(volume), {}).value();
}

std::shared_ptr<const Producer> deepened(std::shared_ptr<const Producer> volume) {
  return DeeperProducer::create(std::move(volume), 2).value();
}

std::vector<NodeKey> random_nodes(const TreeDescription& tree, int count) {
  std::mt19937 random(4);
  std::vector<NodeKey> keys;
  for (int i = 0; i < count; ++i) {
    const std::uint32_t level = static_cast<std::uint32_t>(random()) % (std::min(tree.max_level, 6u) + 1);
    const double across = nodes_across(static_cast<int>(tree.n), level);
    NodeKey key{level, 0, 0, 0};
    std::uint64_t* place[] = {&key.x, &key.y, &key.z};
    for (int axis = 0; axis < 3; ++axis) {
      std::uniform_real_distribution<double> inside(tree.extent.minimum[axis], tree.extent.maximum[axis]);
      *place[axis] = static_cast<std::uint32_t>(std::min(inside(random) * across, across - 1));
    }
    keys.push_back(key);
  }
  return keys;
}

std::vector<ProducerCase> every_producer() {
  return {
      ProducerCase{"store", make_store_producer},
      ProducerCase{"field", make_field_producer},
      ProducerCase{"terrain",
                   [] { return make_density(std::make_shared<TerrainField>(TerrainOptions{}), 8); }},
      ProducerCase{"hypertexture", [] { return make_hypertexture(HypertextureKind::hypertexture); }},
      ProducerCase{"sparse_hypertexture", make_sparse_hypertexture},
      ProducerCase{"pseudo_mesh", [] { return make_hypertexture(HypertextureKind::pseudo_mesh); }},
      ProducerCase{"ramp", [] { return make_hypertexture(HypertextureKind::ramp); }},
      ProducerCase{"blurred", [] { return make_hypertexture(HypertextureKind::blurred); }},
      ProducerCase{"solid_noise", [] { return make_hypertexture(HypertextureKind::solid_noise); }},
      ProducerCase{"repeated", [] { return repeated(make_store_producer(), 3); }},
      ProducerCase{"repeated_often", [] { return repeated(make_store_producer(), 6); }},
      ProducerCase{"amplified", [] { return amplified(make_store_producer()); }},
      ProducerCase{"amplified_floats", [] { return amplified(make_field_producer()); }},
      ProducerCase{"amplified_and_repeated", [] { return repeated(amplified(make_store_producer()), 2); }},
      ProducerCase{"sponge", [] { return std::shared_ptr<const Producer>(new SpongeProducer(8)); }}};
}

}  // namespace gvx::produce
