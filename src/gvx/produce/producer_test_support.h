/// \file
/// For tests: one producer of every kind, and nodes of their trees.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/produce/field.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// Of a store of 50 x 40 x 30 bytes, written at each call.
std::shared_ptr<const Producer> make_store_producer();
/// Of floats that grow evenly; n = 3.
std::shared_ptr<const Producer> make_field_producer();
/// A density of 8 bits, 0 to 1.
std::shared_ptr<const Producer> make_density(std::shared_ptr<const Field> field, std::uint32_t m);
std::shared_ptr<const Producer> repeated(std::shared_ptr<const Producer> volume, std::uint32_t levels);
std::shared_ptr<const Producer> amplified(std::shared_ptr<const Producer> volume);
std::shared_ptr<const Producer> deepened(std::shared_ptr<const Producer> volume);

/// Random nodes that hold part of the volume, from the root down.
std::vector<NodeKey> random_nodes(const TreeDescription& tree, int count);

struct ProducerCase {
  const char* name;
  std::shared_ptr<const Producer> (*make)();
};
/// For conformance suites.
std::vector<ProducerCase> every_producer();
inline std::string name_of_case(const testing::TestParamInfo<ProducerCase>& tested) {
  return tested.param.name;
}

}  // namespace gvx::produce
