#include "gvx/produce/producer.h"

#include <utility>

#include "gvx/exec/buffer.h"

namespace gvx::produce {
namespace {

void make_bricks(const Producer& producer, std::span<const NodeKey> nodes, ElementSink& sink) {
  static const exec::Device host = exec::Device::cpu(1);
  const std::size_t bytes = producer.description().brick_bytes();
  const auto memory = std::make_shared<exec::Buffer<std::byte>>(producer.batching().device.value_or(host),
                                                                nodes.size() * bytes);
  const std::span<std::byte> voxels(memory->view().data, memory->size());
  std::vector<std::optional<ChannelRanges>> constants(nodes.size());
  const Status status = producer.produce_batch({nodes, voxels, constants});
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!status.ok()) {
      sink.complete(i, status.error());
      continue;
    }
    Element brick;
    brick.voxels = voxels.subspan(i * bytes, bytes);
    brick.memory = memory;
    brick.constant = constants[i];
    sink.complete(i, std::move(brick));
  }
}

void describe_children(const Producer& producer, std::span<const NodeKey> parents, ElementSink& sink) {
  const int n = static_cast<int>(producer.description().n), count = n * n * n;
  std::vector<NodeKey> keys;
  for (const NodeKey& parent : parents) {
    for (int i = 0; i < count; ++i) keys.push_back(producer.canonical(child(parent, n, i)));
  }
  std::vector<tree::NodeInfo> infos(keys.size());
  const Status status = producer.describe(keys, infos);
  for (std::size_t p = 0; p < parents.size(); ++p) {
    if (!status.ok()) {
      sink.complete(p, status.error());
      continue;
    }
    const auto first = static_cast<std::ptrdiff_t>(p) * count;
    Element children;
    children.child_keys.assign(keys.begin() + first, keys.begin() + first + count);
    children.children.assign(infos.begin() + first, infos.begin() + first + count);
    sink.complete(p, std::move(children));
  }
}

}  // namespace

void Producer::start(const ElementBatch& batch, std::shared_ptr<ElementSink> sink) const {
  if (batch.kind == ElementKind::brick) {
    make_bricks(*this, batch.nodes, *sink);
  } else {
    describe_children(*this, batch.nodes, *sink);
  }
}

bool makes_host_memory(const Producer& producer) {
  const auto device = producer.batching().device;
  return !device || device->kind() == exec::DeviceKind::cpu;
}

}  // namespace gvx::produce
